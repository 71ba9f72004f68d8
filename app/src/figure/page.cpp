#include "figure/page.hpp"

#include <fmt/format.h>

#include "figure/page_assets.hpp"

namespace tendril::app {

namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += (c >= 0 && c < ' ') || c == 127 ? ' ' : c;
    }
  }
  return out;
}

/// JSON inside a script element: nothing in it ends the element.
std::string data_text(const Json& data) {
  const std::string text = data.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string page_policy(const std::vector<const PageAsset*>& scripts, bool connects) {
  std::string hashes;
  for (const PageAsset* script : scripts) hashes += fmt::format(" 'sha256-{}'", script->hash);
  return fmt::format("default-src 'none'; script-src{}; style-src 'sha256-{}'; {}base-uri 'none'; form-action 'none'",
                     hashes, page_style.hash, connects ? "connect-src 'self'; " : "");
}

std::string page_of(const PageParts& parts) {
  std::string scripts;
  for (const PageAsset* script : parts.scripts) scripts += fmt::format("<script>{}</script>\n", script->text);
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n"
      "<style>{}</style>\n</head>\n<body>\n<div id=\"tendril\"><p>This page draws with JavaScript. "
      "Where this stays, it is switched off, or the browser is too old: expected one of 2021 or later.</p></div>\n"
      "<script type=\"application/json\" id=\"{}\">{}</script>\n{}</body>\n</html>\n",
      page_policy(parts.scripts, parts.connects), escaped(parts.title), page_style.text, parts.data_name,
      data_text(parts.data), scripts);
}

std::string drawing_page(const Json& drawing) {
  return page_of({drawing.value("title", ""), "drawing", drawing, {&drawing_script}});
}

}  // namespace tendril::app

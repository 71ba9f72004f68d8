#include "common/section.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "common/statistics.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::bench {

namespace {

using Json = nlohmann::ordered_json;

Json value_of(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) return *integer;
  const double real = std::get<double>(cell);
  return std::isfinite(real) ? Json(real) : Json(nullptr);
}

std::string base64(const std::string& bytes) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? letters[group >> (18U - 6U * k) & 63U] : '=';
    }
  }
  return out;
}

bool is_number(const Cell& cell) { return !std::holds_alternative<std::string>(cell); }

}  // namespace

std::string text_of(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) return std::to_string(*integer);
  const double real = std::get<double>(cell);
  return std::isfinite(real) ? fmt::format("{:.3g}", real) : "-";
}

Table pace_table(const std::string& name, const std::vector<double>& seconds) {
  const Quartiles q = quartiles(seconds);
  return {name,
          "The machine's own pace meanwhile: processor time of one fixed piece of arithmetic, taken beside every plan",
          {"beats", "seconds_low", "seconds_median", "seconds_high"},
          {{static_cast<std::int64_t>(seconds.size()), q.low, q.median, q.high}}};
}

std::string markdown(const Table& table) {
  std::string text = "|";
  std::string rule = "|";
  for (const std::string& column : table.columns) {
    text += ' ' + column + " |";
    rule += "---|";
  }
  text += '\n' + rule + '\n';
  for (const auto& row : table.rows) {
    text += '|';
    for (const Cell& cell : row) {
      text += ' ';
      for (const char c : text_of(cell)) text += c == '|' ? std::string("\\|") : c == '\n' ? " " : std::string(1, c);
      text += " |";
    }
    text += '\n';
  }
  return text;
}

std::string csv(const Table& table) {
  std::string text;
  const auto field = [](const std::string& value) {
    if (value.find_first_of(",\"\n\r") == std::string::npos) return value;
    std::string out = "\"";
    for (const char c : value) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + '"';
  };
  for (std::size_t i = 0; i < table.columns.size(); ++i) text += (i > 0 ? "," : "") + field(table.columns[i]);
  text += '\n';
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const auto* real = std::get_if<double>(&row[i]);
      text += (i > 0 ? "," : "") + field(real != nullptr ? fmt::format("{}", *real) : text_of(row[i]));
    }
    text += '\n';
  }
  return text;
}

std::string markdown(const Section& section) {
  std::string text = "## " + section.title + "\n\n";
  for (const std::string& paragraph : section.prose) text += paragraph + "\n\n";
  for (const Figure& figure : section.figures) {
    text += fmt::format("![{}]({}.png)\n\n*{}*\n\n", figure.chart.title, figure.name, figure.caption);
  }
  for (const Table& table : section.tables) {
    if (!table.printed) {
      text += fmt::format("{}: `{}.csv`.\n\n", table.caption, table.name);
      continue;
    }
    text += "**" + table.caption + "**\n\n" + markdown(table) + '\n';
  }
  if (!section.left_out.empty()) text += "**Left out, and why**\n\n";
  for (const LeftOut& item : section.left_out) text += "- " + item.what + ": " + item.why + '\n';
  if (!section.left_out.empty()) text += '\n';
  return text;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '"') {
      out += "&quot;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string html(const Section& section, const std::vector<std::pair<std::string, std::string>>& pictures) {
  std::string text = fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n", section.name, escaped(section.title));
  for (const std::string& paragraph : section.prose) text += "<p>" + escaped(paragraph) + "</p>\n";
  for (const Figure& figure : section.figures) {
    for (const auto& [name, svg] : pictures) {
      if (name != figure.name) continue;
      text += fmt::format(
          "<figure><img alt=\"{}\" src=\"data:image/svg+xml;base64,{}\">\n<figcaption>{}</figcaption></figure>\n",
          escaped(figure.chart.title), base64(svg), escaped(figure.caption));
    }
  }
  for (const Table& table : section.tables) {
    if (!table.printed) {
      text += fmt::format("<p>{}: <code>{}.csv</code>.</p>\n", escaped(table.caption), escaped(table.name));
      continue;
    }
    text += "<div class=\"wide\"><table><caption>" + escaped(table.caption) + "</caption>\n<tr>";
    for (const std::string& column : table.columns) text += "<th>" + escaped(column) + "</th>";
    text += "</tr>\n";
    for (const auto& row : table.rows) {
      text += "<tr>";
      for (const Cell& cell : row) {
        text += (is_number(cell) ? "<td class=\"number\">" : "<td>") + escaped(text_of(cell)) + "</td>";
      }
      text += "</tr>\n";
    }
    text += "</table></div>\n";
  }
  if (!section.left_out.empty()) {
    text += "<h3>Left out, and why</h3>\n<ul>\n";
    for (const LeftOut& item : section.left_out) {
      text += "<li>" + escaped(item.what) + ": " + escaped(item.why) + "</li>\n";
    }
    text += "</ul>\n";
  }
  return text + "</section>\n";
}

std::string json(const Section& section) {
  Json out;
  out["name"] = section.name;
  out["title"] = section.title;
  out["prose"] = section.prose;
  out["tables"] = Json::object();
  for (const Table& table : section.tables) {
    Json rows = Json::array();
    for (const auto& row : table.rows) {
      Json values = Json::array();
      for (const Cell& cell : row) values.push_back(value_of(cell));
      rows.push_back(std::move(values));
    }
    out["tables"][table.name] = {{"caption", table.caption}, {"columns", table.columns}, {"rows", std::move(rows)}};
  }
  out["left_out"] = Json::array();
  for (const LeftOut& item : section.left_out) out["left_out"].push_back({{"what", item.what}, {"why", item.why}});
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::vector<std::pair<std::string, std::string>> write_files(const Section& section, app::StagedFiles& files) {
  for (const Table& table : section.tables) files.write(table.name + ".csv", csv(table));
  files.write(section.name + ".json", json(section));
  std::vector<std::pair<std::string, std::string>> pictures;
  for (const Figure& figure : section.figures) {
    draw_chart(figure.chart, files, figure.name, {app::Picture::svg, app::Picture::png});
    std::ifstream svg(files.staging() / (figure.name + ".svg"), std::ios::binary);
    pictures.emplace_back(figure.name, std::string(std::istreambuf_iterator<char>(svg), {}));
    if (pictures.back().second.empty()) throw app::InputError("no figure: '" + figure.name + ".svg' cannot be read");
  }
  return pictures;
}

}  // namespace tendril::bench

#include "live/door.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "figure/page_assets.hpp"
#include "live/live_script.hpp"

namespace tendril::app {

namespace {

http::Answer plain(int status, const std::string& text) {
  http::Answer answer;
  answer.status = status;
  answer.body = text + '\n';
  return answer;
}

http::Answer json(const LiveAnswer& made) {
  http::Answer answer;
  answer.status = made.status;
  // With the parameter the HTTP library does not know the type, and does not compress it: that took five times as long
  // as a plan.
  answer.type = "application/json; charset=utf-8";
  answer.body = made.body.dump(-1, ' ', false, Json::error_handler_t::replace);
  return answer;
}

/// Takes as long wherever the two differ.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

/// What every answer carries: nothing is kept, embedded elsewhere, or taken for something else.
void harden(http::Answer& answer) {
  answer.headers = {{"Cache-Control", "no-store"},
                    {"X-Content-Type-Options", "nosniff"},
                    {"X-Frame-Options", "DENY"},
                    {"Referrer-Policy", "no-referrer"},
                    {"Cross-Origin-Resource-Policy", "same-origin"},
                    {"Cross-Origin-Opener-Policy", "same-origin"}};
  answer.headers.emplace_back("Content-Security-Policy",
                              answer.type.starts_with("text/html")
                                  ? page_policy({&drawing_script, &live_script}, true) + "; frame-ancestors 'none'"
                                  : "default-src 'none'; frame-ancestors 'none'");
}

}  // namespace

void Door::open(int port) { hosts_ = {fmt::format("127.0.0.1:{}", port), fmt::format("localhost:{}", port)}; }

http::Answer Door::answer(const http::Request& request) {
  std::optional<http::Answer> refused = refusal(request);
  http::Answer answer;
  if (refused) {
    answer = std::move(*refused);
  } else {
    const std::string what = request.path.substr(token_.size() + 2);
    const Json asked = request.method == "POST" ? Json::parse(request.body, nullptr, false) : Json();
    if (request.method == "GET") {
      answer = what.empty() ? page() : plain(404, "not found");
    } else if (asked.is_discarded()) {
      answer = plain(400, "the request is no JSON");
    } else if (what == "run") {
      answer = json(scene_.run(asked));
    } else if (what == "scene") {
      answer = json(scene_.scene_text(asked));
    } else if (what == "result") {
      answer = json(scene_.result_text(asked));
    } else {
      answer = plain(404, "not found");
    }
  }
  harden(answer);
  return answer;
}

std::optional<http::Answer> Door::refusal(const http::Request& request) {
  if (too_fast()) return plain(429, "too many requests");
  // A foreign page that has its own name lead to this machine is told by the name.
  const std::optional<std::string> host = request.header("Host");
  if (!host || std::find(hosts_.begin(), hosts_.end(), *host) == hosts_.end()) return plain(403, "wrong Host");
  const std::optional<std::string> origin = request.header("Origin");
  const bool own = origin && *origin == "http://" + *host;
  if (!own && (request.method == "POST" || origin)) return plain(403, "wrong Origin");
  const std::size_t slash = request.path.find('/', 1);
  if (slash == std::string::npos || !same(std::string_view(request.path).substr(1, slash - 1), token_)) {
    return plain(404, "not found");
  }
  if (request.method == "POST" && request.header("Content-Type").value_or("") != "application/json") {
    return plain(415, "expected application/json");
  }
  return std::nullopt;
}

bool Door::too_fast() {
  const std::lock_guard lock(counting_);
  const auto now = std::chrono::steady_clock::now();
  const double passed = std::chrono::duration<double>(now - counted_).count();
  counted_ = now;
  allowed_ = std::min(requests_per_second, allowed_ + passed * requests_per_second);
  if (allowed_ < 1.0) return true;
  allowed_ -= 1.0;
  return false;
}

http::Answer Door::page() const {
  const Json data = scene_.beginning();
  http::Answer answer;
  answer.type = "text/html; charset=utf-8";
  answer.body = page_of({data["drawing"].value("title", ""), "live", data, {&drawing_script, &live_script}, true});
  return answer;
}

}  // namespace tendril::app

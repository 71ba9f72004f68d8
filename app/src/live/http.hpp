#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tendril/export.hpp"

/// The server of the live page, in a library of its own (libtendril-http): it alone needs an HTTP library, which would
/// make every start of the command slower.
namespace tendril::http {

struct Request {
  std::string method, path, body;
  /// Of a header that was sent once; absent or sent several times: nothing.
  std::function<std::optional<std::string>(const std::string& name)> header;
};

struct Answer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body{};
  std::vector<std::pair<std::string, std::string>> headers{};
};

struct Service {
  int port = 0;                                  ///< 0: any that is free
  std::size_t largest_body = 0;                  ///< bytes; larger ones are answered with 413
  std::function<Answer(const Request&)> answer;  ///< called by several threads
  std::function<void(int port)> ready;           ///< called once the port is open
  std::function<void()> ending;                  ///< called when it is to stop: answers that are made now should end
};

/// Serves on 127.0.0.1 until `stop`. False: the port cannot be opened.
extern "C" TENDRIL_API bool tendril_http_serve(const Service& service, const std::atomic<bool>& stop);

}  // namespace tendril::http

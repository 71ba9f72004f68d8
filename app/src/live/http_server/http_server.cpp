#include <httplib.h>

#include <chrono>
#include <exception>
#include <thread>

#include "live/http.hpp"

namespace tendril::http {

namespace {

void set_options(httplib::Server& server, const Service& service) {
  // Without the option to share a port, which the library sets by itself: a second server must not take half of the
  // first one's requests.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  server.set_payload_max_length(service.largest_body);
  server.set_keep_alive_max_count(10000);
  server.set_read_timeout(std::chrono::seconds(5));
  server.set_tcp_nodelay(true);
  server.new_task_queue = [] { return new httplib::ThreadPool(6); };
}

void fill(const Answer& answer, httplib::Response& response) {
  response.status = answer.status;
  for (const auto& [name, value] : answer.headers) response.set_header(name, value);
  response.set_content(answer.body, answer.type);
}

}  // namespace

bool tendril_http_serve(const Service& service, const std::atomic<bool>& stop) {
  httplib::Server server;
  set_options(server, service);
  const auto handle = [&](const httplib::Request& request, httplib::Response& response) {
    const auto header = [&](const std::string& name) {
      return request.get_header_value_count(name) == 1 ? std::optional(request.get_header_value(name)) : std::nullopt;
    };
    fill(service.answer({request.method, request.target, request.body, header}), response);
  };
  server.Get(".*", handle);
  server.Post(".*", handle);
  int port = service.port;
  if (port == 0) {
    port = server.bind_to_any_port("127.0.0.1");
    if (port <= 0) return false;
  } else if (!server.bind_to_port("127.0.0.1", port)) {
    return false;
  }
  std::thread watch([&] {
    while (!stop) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    service.ending();
    server.stop();
  });
  service.ready(port);
  server.listen_after_bind();
  watch.join();
  return true;
}

}  // namespace tendril::http

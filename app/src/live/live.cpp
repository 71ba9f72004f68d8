#include "live/live.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cstdlib>

#include "live/door.hpp"
#include "system/output.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/interrupt.hpp"
#include "tendril/app/process.hpp"

namespace tendril::app {

namespace {

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw InputError("live: this system gives no random numbers");
  }
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

decltype(&http::tendril_http_serve) load_server(const std::string& name) {
  if (name.empty()) {
    throw InputError(
        "live: this tendril was built without the server of the page, which needs cpp-httplib (Debian: "
        "libcpp-httplib-dev); expected a build with it");
  }
  void* library = ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    throw InputError(
        fmt::format("live: the page's server cannot be loaded, expected {} and, of Debian, libcpp-httplib0.11: {}",
                    name, ::dlerror()));
  }
  void* const symbol = ::dlsym(library, "tendril_http_serve");
  if (symbol == nullptr) throw InputError(fmt::format("live: {} holds no server", name));
  return reinterpret_cast<decltype(&http::tendril_http_serve)>(symbol);
}

/// Opens the page in the user's browser. Arguments of a program can be seen by everybody on the machine, and the
/// address holds the token, so the browser is given a file that leads there.
class BrowserStart {
 public:
  explicit BrowserStart(const std::string& address) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing sets variables here
    if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
    std::string pattern = (std::filesystem::temp_directory_path() / "tendril-live-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) return;
    directory_ = pattern;
    StagedFiles files(directory_);
    files.write("open.html",
                fmt::format("<!DOCTYPE html><meta http-equiv=\"refresh\" content=\"0; url={}\">\n", address));
    files.publish();
    const std::string file = (directory_ / "open.html").string();
    run_process("setsid", {"--fork", "xdg-open", file}, directory_, 5.0);
  }
  ~BrowserStart() {
    std::error_code ignored;
    if (!directory_.empty()) std::filesystem::remove_all(directory_, ignored);
  }
  BrowserStart(const BrowserStart&) = delete;
  BrowserStart& operator=(const BrowserStart&) = delete;

 private:
  std::filesystem::path directory_;
};

}  // namespace

std::string live_server() { return TENDRIL_HTTP_LIBRARY; }

int run_live(const LiveArguments& arguments) {
  const files::LiveControl& control = arguments.control;
  const auto serve = load_server(arguments.server);
  LiveScene scene(arguments.scene);
  const std::string token = random_token();
  Door door(scene, token);
  std::optional<InterruptGuard> guard;
  if (control.stop == nullptr) guard.emplace();
  std::optional<BrowserStart> browser;
  http::Service service;
  service.port = control.port;
  service.largest_body = Door::largest_body;
  service.answer = [&](const http::Request& request) { return door.answer(request); };
  service.ending = [&] { scene.end(); };
  service.ready = [&](int port) {
    door.open(port);
    const std::string address = fmt::format("http://127.0.0.1:{}/{}/", port, token);
    if (control.ready) {
      control.ready(address);
    } else {
      print("live at " + address + "\nCtrl-C ends it\n");
    }
    if (control.open_browser) browser.emplace(address);
  };
  if (!serve(service, control.stop != nullptr ? *control.stop : InterruptGuard::flag())) {
    throw InputError(control.port == 0
                         ? "live: no port of the loopback interface can be opened"
                         : fmt::format("--port {}: the port cannot be opened, for instance because another program "
                                       "uses it; expected one that is free, or no --port",
                                       control.port));
  }
  return 0;
}

}  // namespace tendril::app

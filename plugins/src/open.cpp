#include <dlfcn.h>

#include <array>
#include <boost/dll/shared_library.hpp>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "opening_guard.hpp"
#include "tendril/plugin.hpp"
#include "tendril/plugins/handshake.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::plugins {

namespace {

constexpr const char* handshake_symbol = "tendril_plugin_handshake";
constexpr const char* register_symbol = "tendril_plugin_register";

std::string title(const PluginFile& file) { return std::string(to_string(file.kind)) + " plugin '" + file.name + "'"; }

[[noreturn]] void fail(const PluginFile& file, Failure failure, const std::string& reason) {
  std::string message =
      title(file) + " was found (" + file.origin + ") but cannot be used: " + reason + "\nfile: " + file.path.string();
  if (!file.resolved.empty() && file.resolved != file.path) {
    message += "\nwhich is a link to: " + file.resolved.string();
  }
  throw PluginError(failure, message, reason);
}

/// The word that ends where `mark` begins.
std::optional<std::string> word_before(const std::string& text, std::string_view mark) {
  const std::size_t end = text.find(mark);
  if (end == std::string::npos) return std::nullopt;
  const std::size_t space = text.rfind(' ', end);
  const std::size_t begin = space == std::string::npos ? 0 : space + 1;
  return text.substr(begin, end - begin);
}

/// Turns the loader's text into a reason that tells what to do.
[[noreturn]] void fail_to_load(const PluginFile& file, const std::string& text) {
  if (const auto library = word_before(text, ": cannot open shared object file");
      library && *library != file.resolved) {
    if (library->starts_with("libtendril.so.")) {
      fail(file, Failure::other_interface,
           "built for another interface: it needs " + *library + ", this program has libtendril.so." +
               std::to_string(TENDRIL_INTERFACE_VERSION) + "; rebuild the plugin against this tendril");
    }
    fail(file, Failure::missing_dependency,
         *library + " is missing, which it needs; install it or add its directory to LD_LIBRARY_PATH");
  }
  if (text.find("undefined symbol") != std::string::npos) {
    fail(file, Failure::other_interface,
         "a symbol that it needs is missing (" + text + "); rebuild the plugin against this tendril");
  }
  fail(file, Failure::failed, text);
}

/// The loader's own text. Boost.DLL puts words before it and a stale error number behind it.
std::string loader_text(std::string text) {
  constexpr std::string_view mark = "dlerror system message: ";
  if (const std::size_t at = text.find(mark); at != std::string::npos) {
    text.erase(0, at + mark.size());
    if (const std::size_t end = text.rfind("): "); end != std::string::npos) text.resize(end);
  }
  return text;
}

void require_library(const PluginFile& file) {
  std::array<char, 4> magic{};
  std::ifstream in(file.resolved, std::ios::binary);
  if (!in) fail(file, Failure::failed, "it cannot be read");
  in.read(magic.data(), magic.size());
  if (in.gcount() == 0) fail(file, Failure::not_a_plugin, "it is empty");
  if (magic != std::array{'\x7f', 'E', 'L', 'F'}) fail(file, Failure::not_a_plugin, "it is not a shared library");
}

boost::dll::shared_library load(const PluginFile& file) {
  boost::dll::shared_library library;
  try {
    library.load(file.resolved, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  } catch (const std::exception& error) {
    fail_to_load(file, loader_text(error.what()));
  } catch (...) {
    fail(file, Failure::threw, "it threw something that is no std::exception while it was loaded");
  }
  // Its exceptions, vtables and functions may outlive every handle, so the library stays for good.
  if (void* pinned = ::dlopen(file.resolved.c_str(), RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE)) ::dlclose(pinned);
  return library;
}

void compare_handshakes(const PluginFile& file, const boost::dll::shared_library& library) {
  for (const char* symbol : {handshake_symbol, register_symbol}) {
    if (!library.has(symbol)) {
      fail(
          file, Failure::not_a_plugin,
          std::string("it has no symbol ") + symbol + "; a plugin's source contains TENDRIL_PLUGIN(registrar) { ... }");
    }
  }
  const tendril_handshake* plugin = library.get<const tendril_handshake*()>(handshake_symbol)();
  if (plugin == nullptr) fail(file, Failure::not_a_plugin, "its handshake is missing");
  constexpr tendril_handshake program = detail::this_handshake();
  const std::vector<std::string> found = differences(*plugin, program);
  if (found.empty()) return;
  std::string reason = "built for another interface:";
  for (const std::string& difference : found) reason += "\n  " + difference;
  fail(file, Failure::other_interface, reason);
}

class Collector : public Registrar {
 public:
  void add(CoordinateComponent component) override { keep(ComponentKind::coordinates, std::move(component)); }
  void add(ObjectiveComponent component) override { keep(ComponentKind::objective, std::move(component)); }
  void add(ObstacleComponent component) override { keep(ComponentKind::obstacle, std::move(component)); }
  void add(SolverComponent component) override { keep(ComponentKind::solver, std::move(component)); }

  struct Entry {
    ComponentKind kind;
    std::string name;
    AnyComponent component;
  };
  std::vector<Entry> entries;

 private:
  template <class C>
  void keep(ComponentKind kind, C component) {
    std::string name = component.name;
    entries.push_back({kind, std::move(name), std::move(component)});
  }
};

AnyComponent collect(const PluginFile& file, const boost::dll::shared_library& library) {
  Collector collector;
  try {
    library.get<void(Registrar*)>(register_symbol)(&collector);
  } catch (const std::exception& error) {
    fail(file, Failure::threw, std::string("it threw while registering: ") + error.what());
  } catch (...) {
    fail(file, Failure::threw, "it threw something that is no std::exception while registering");
  }
  if (collector.entries.empty()) fail(file, Failure::wrong_component, "it registers nothing");
  if (collector.entries.size() > 1) {
    std::string names;
    for (const auto& entry : collector.entries) names += (names.empty() ? "'" : ", '") + entry.name + "'";
    fail(file, Failure::wrong_component,
         "it registers " + std::to_string(collector.entries.size()) + " components (" + names +
             "); a plugin holds exactly one");
  }
  Collector::Entry& entry = collector.entries.front();
  if (entry.kind != file.kind || entry.name != file.name) {
    fail(file, Failure::wrong_component,
         "it registers " + std::string(to_string(entry.kind)) + " '" + entry.name + "', but its file is named for " +
             std::string(to_string(file.kind)) + " '" + file.name + "'");
  }
  return std::move(entry.component);
}

/// Lets nothing but this program's own errors out of the factory.
template <class Interface>
void guard_factory(const PluginFile& file, Component<Interface>& component) {
  if (!component.make) fail(file, Failure::wrong_component, "it registers no factory");
  component.make = [make = std::move(component.make), where = title(file) + " (" + file.path.string() + ")"](
                       const Options& options) -> std::unique_ptr<Interface> {
    std::unique_ptr<Interface> made;
    try {
      made = make(options);
    } catch (const OptionError&) {
      throw;
    } catch (const std::exception& error) {
      throw PluginError(Failure::threw, where + " cannot be made: " + error.what());
    } catch (...) {
      throw PluginError(Failure::threw, where + " cannot be made: it threw something that is no std::exception");
    }
    if (!made) throw PluginError(Failure::threw, where + " cannot be made: its factory returned nothing");
    return made;
  };
}

}  // namespace

AnyComponent open_plugin(const PluginFile& file) {
  if (!file.refusal.empty()) {
    fail(file, file.untrusted ? Failure::untrusted : Failure::not_a_plugin,
         (file.untrusted ? "refused, because others could have changed it: " : "it is ") + file.refusal);
  }
  require_library(file);
  const OpeningGuard guard(file.path);
  const boost::dll::shared_library library = load(file);
  compare_handshakes(file, library);
  AnyComponent component = collect(file, library);
  std::visit([&file](auto& c) { guard_factory(file, c); }, component);
  return component;
}

}  // namespace tendril::plugins

#include "common/machine.hpp"

#include <fmt/format.h>
#include <link.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "commit.hpp"
#include "tendril/version.hpp"

namespace tendril::bench {

namespace {

/// The value of the first line "key : value" of a file of /proc; "unknown" if there is none.
std::string entry(const std::string& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos || line.compare(0, key.size(), key) != 0) continue;
    const std::size_t from = line.find_first_not_of(" \t", colon + 1);
    return from == std::string::npos ? "unknown" : line.substr(from);
  }
  return "unknown";
}

int add_library(dl_phdr_info* info, std::size_t, void* names) {
  if (info->dlpi_name == nullptr || *info->dlpi_name == '\0') return 0;
  std::error_code error;
  const std::filesystem::path file = std::filesystem::canonical(info->dlpi_name, error);
  if (!error) static_cast<std::set<std::string>*>(names)->insert(file.filename().string());
  return 0;
}

}  // namespace

Facts machine() {
  utsname system{};
  ::uname(&system);
  return {{"processor", entry("/proc/cpuinfo", "model name")},
          {"cores", std::to_string(std::thread::hardware_concurrency())},
          {"memory", entry("/proc/meminfo", "MemTotal")},
          {"system", fmt::format("{} {} {}", system.sysname, system.release, system.machine)}};
}

Facts versions(const plugins::Registry& registry) {
  std::string plugins;
  for (const plugins::Registry::Opened& opened : registry.opened()) {
    plugins += fmt::format("{}{} {}", plugins.empty() ? "" : ", ", to_string(opened.kind), opened.name);
  }
  std::set<std::string> names;
  ::dl_iterate_phdr(add_library, &names);
  std::string libraries;
  for (const std::string& name : names) libraries += (libraries.empty() ? "" : ", ") + name;
  return {{"tendril", TENDRIL_VERSION},
          {"commit", TENDRIL_COMMIT},
          {"compiler", TENDRIL_COMPILER},
          {"build", TENDRIL_BUILD_TYPE},
          {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"plugins opened", plugins},
          {"libraries loaded", libraries}};
}

}  // namespace tendril::bench

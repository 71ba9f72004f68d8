#include "tendril/plugins/handshake.hpp"

#include <cstddef>

namespace tendril::plugins {

namespace {

using Field = std::uint32_t tendril_handshake::*;

std::string number(std::uint32_t value) { return std::to_string(value); }

std::string eigen_version(std::uint32_t value) {
  return number(value / 10000) + '.' + number(value / 100 % 100) + '.' + number(value % 100);
}

std::string yes_or_no(std::uint32_t value) { return value != 0 ? "yes" : "no"; }

std::string sanitizers(std::uint32_t bits) {
  std::string text;
  const auto add = [&text](const char* name) { text += (text.empty() ? "" : " and ") + std::string(name); };
  if ((bits & 1U) != 0) add("address");
  if ((bits & 2U) != 0) add("thread");
  if ((bits & 4U) != 0) add("memory");
  return text.empty() ? "none" : text;
}

struct FieldInWords {
  Field field;
  std::size_t offset;
  const char* what;
  std::string (*show)(std::uint32_t);
  const char* advice;
};

constexpr FieldInWords fields[] = {
    {&tendril_handshake::interface_version, offsetof(tendril_handshake, interface_version), "interface version", number,
     "the plugin is older: rebuild it against this tendril"},
    {&tendril_handshake::gxx_abi, offsetof(tendril_handshake, gxx_abi), "compiler ABI version (__GXX_ABI_VERSION)",
     number, "build both with the same -fabi-version"},
    {&tendril_handshake::cxx11_abi, offsetof(tendril_handshake, cxx11_abi), "_GLIBCXX_USE_CXX11_ABI", number,
     "build both with the same value"},
    {&tendril_handshake::glibcxx_debug, offsetof(tendril_handshake, glibcxx_debug), "debug containers (_GLIBCXX_DEBUG)",
     yes_or_no, "define it for both or for none"},
    {&tendril_handshake::eigen_version, offsetof(tendril_handshake, eigen_version), "Eigen version", eigen_version,
     "build both with the same Eigen"},
    {&tendril_handshake::eigen_align_bytes, offsetof(tendril_handshake, eigen_align_bytes), "Eigen alignment in bytes",
     number, "build both for the same processor (-march) and with the same EIGEN_MAX_ALIGN_BYTES"},
    {&tendril_handshake::eigen_malloc_aligned, offsetof(tendril_handshake, eigen_malloc_aligned),
     "EIGEN_MALLOC_ALREADY_ALIGNED", number, "build both with the same value"},
    {&tendril_handshake::sanitizers, offsetof(tendril_handshake, sanitizers), "sanitizers", sanitizers,
     "build both with the same -fsanitize"},
};

}  // namespace

std::vector<std::string> differences(const tendril_handshake& plugin, const tendril_handshake& program) {
  std::vector<std::string> found;
  if (plugin.size != program.size) {
    found.push_back("handshake size: " + number(plugin.size) + ", this program: " + number(program.size) +
                    " (rebuild the plugin against this tendril)");
  }
  for (const FieldInWords& f : fields) {
    // A shorter handshake ends before the later fields; they must not be read.
    if (plugin.size < f.offset + sizeof(std::uint32_t)) break;
    if (plugin.*f.field == program.*f.field) continue;
    const bool newer = f.field == &tendril_handshake::interface_version && plugin.*f.field > program.*f.field;
    const char* advice =
        newer ? "the plugin is newer: use the tendril it was built for, or rebuild it against this one" : f.advice;
    found.push_back(std::string(f.what) + ": " + f.show(plugin.*f.field) +
                    ", this program: " + f.show(program.*f.field) + " (" + advice + ')');
  }
  return found;
}

}  // namespace tendril::plugins

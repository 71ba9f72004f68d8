#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <type_traits>

#include "tendril/registrar.hpp"
#include "tendril/version.hpp"

/// What both sides of the plugin boundary must agree on before any C++ object crosses. Plain data of fixed layout; the
/// host compares it with its own, field by field. Fields are only ever added at the end.
extern "C" struct tendril_handshake {
  std::uint32_t size;                  ///< sizeof(tendril_handshake)
  std::uint32_t interface_version;     ///< TENDRIL_INTERFACE_VERSION
  std::uint32_t gxx_abi;               ///< __GXX_ABI_VERSION
  std::uint32_t cxx11_abi;             ///< _GLIBCXX_USE_CXX11_ABI
  std::uint32_t glibcxx_debug;         ///< _GLIBCXX_DEBUG defined
  std::uint32_t eigen_version;         ///< world * 10000 + major * 100 + minor
  std::uint32_t eigen_align_bytes;     ///< EIGEN_DEFAULT_ALIGN_BYTES
  std::uint32_t eigen_malloc_aligned;  ///< EIGEN_MALLOC_ALREADY_ALIGNED
  std::uint32_t sanitizers;            ///< bit 0: address, bit 1: thread, bit 2: memory
};

namespace tendril::detail {

constexpr std::uint32_t sanitizer_bits() {
  std::uint32_t bits = 0;
#if defined(__SANITIZE_ADDRESS__)
  bits |= 1U;
#endif
#if defined(__SANITIZE_THREAD__)
  bits |= 2U;
#endif
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
  bits |= 1U;
#endif
#if __has_feature(thread_sanitizer)
  bits |= 2U;
#endif
#if __has_feature(memory_sanitizer)
  bits |= 4U;
#endif
#endif
  return bits;
}

/// The handshake of the translation unit that calls it.
constexpr tendril_handshake this_handshake() {
  return {
    sizeof(tendril_handshake), TENDRIL_INTERFACE_VERSION, __GXX_ABI_VERSION, _GLIBCXX_USE_CXX11_ABI,
#if defined(_GLIBCXX_DEBUG)
        1U,
#else
        0U,
#endif
        EIGEN_WORLD_VERSION * 10000U + EIGEN_MAJOR_VERSION * 100U + EIGEN_MINOR_VERSION, EIGEN_DEFAULT_ALIGN_BYTES,
        EIGEN_MALLOC_ALREADY_ALIGNED, sanitizer_bits()
  };
}

}  // namespace tendril::detail

/// Writes the two symbols of a plugin. The body registers exactly one component:
///
///     TENDRIL_PLUGIN(registrar) {
///       registrar.add(tendril::ObjectiveComponent{"level_tip", "keeps the tip level", {}, [](const auto&) { ... }});
///     }
#define TENDRIL_PLUGIN(registrar)                                                     \
  static void tendril_register_component(tendril::Registrar& registrar);              \
  extern "C" TENDRIL_API const tendril_handshake* tendril_plugin_handshake() {        \
    static constexpr tendril_handshake handshake = tendril::detail::this_handshake(); \
    return &handshake;                                                                \
  }                                                                                   \
  extern "C" TENDRIL_API void tendril_plugin_register(tendril::Registrar* target) {   \
    tendril_register_component(*target);                                              \
  }                                                                                   \
  static void tendril_register_component(tendril::Registrar& registrar)

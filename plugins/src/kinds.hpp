#pragma once

#include <array>

#include "tendril/registrar.hpp"

namespace tendril::plugins {

/// All of them, in the order of AnyComponent.
inline constexpr std::array kinds{ComponentKind::coordinates, ComponentKind::objective, ComponentKind::obstacle,
                                  ComponentKind::solver};

}  // namespace tendril::plugins

#pragma once

#include <memory>
#include <vector>

#include "tendril/geometry.hpp"
#include "tendril/options.hpp"

/// Options as a scene gives them, and what is made with them.
namespace tendril {

template <class Interface>
std::unique_ptr<Interface> make(const Component<Interface>& component, const RawOptions& given) {
  return component.make(resolve_options(component.options, given, Scale{}, {}, component.name));
}

inline RawValue numbers(const std::vector<double>& values) {
  RawValue::List list;
  for (const double value : values) list.push_back({value});
  return {list};
}

inline RawValue points(const std::vector<Vec2>& vertices) {
  RawValue::List list;
  for (const Vec2 v : vertices) list.push_back(numbers({v.x, v.y}));
  return {list};
}

}  // namespace tendril

#pragma once

#include <cmath>
#include <cstddef>
#include <span>

namespace tendril {

/// A point or direction of the plane. Plain data: it may cross a plugin boundary.
struct Vec2 {
  double x = 0.0;  ///< first coordinate
  double y = 0.0;  ///< second coordinate
};

///@{
/// Component by component.
constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
constexpr Vec2 operator-(Vec2 a) { return {-a.x, -a.y}; }
constexpr Vec2 operator*(double f, Vec2 a) { return {f * a.x, f * a.y}; }
constexpr Vec2& operator+=(Vec2& a, Vec2 b) {
  a.x += b.x;
  a.y += b.y;
  return a;
}
///@}
/// Both coordinates are equal.
constexpr bool operator==(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
/// Scalar product.
constexpr double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
/// z-component of the cross product.
constexpr double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
/// The vector turned by +90 degrees.
constexpr Vec2 turned(Vec2 a) { return {-a.y, a.x}; }
/// By -90 degrees.
constexpr Vec2 turned_back(Vec2 a) { return {a.y, -a.x}; }
/// Length.
inline double norm(Vec2 a) { return std::hypot(a.x, a.y); }
/// Whether `p` lies inside of a closed line, given by its corners: a ray from it crosses the line an odd number of
/// times.
inline bool lies_inside(std::span<const Vec2> line, Vec2 p) {
  bool inside = false;
  for (std::size_t i = 0, j = line.size() - 1; i < line.size(); j = i++) {
    const Vec2 a = line[i];
    const Vec2 b = line[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y))) inside = !inside;
  }
  return inside;
}

}  // namespace tendril

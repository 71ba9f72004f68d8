#include <fmt/format.h>

#include <cmath>

#include "figure/frame_figure.hpp"
#include "figure/frames.hpp"

namespace tendril::app {

namespace {

void add_points(DataFile& data, const Json& points) {
  for (const Json& p : points) data.row(point(p));
}

}  // namespace

void FrameFigure::add_shapes(DataFile& data, const Json& shapes, const std::string& prefix) const {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    add_outlines(data, lines_of(shapes[i]), window_, fmt::format("{}obstacle {}.", prefix, i + 1),
                 fmt::format("{}edge {}.", prefix, i + 1));
  }
}

void FrameFigure::add_frame(DataFile& data, std::size_t index) const {
  const Json& one = frame(index);
  const auto block = [&](const std::string& name, const char* columns = "x y") {
    data.block(block_of(index, name), columns);
  };
  const auto add = [&](const char* key) {
    if (!one.contains(key) || one[key].empty()) return;
    block(key);
    add_points(data, one[key]);
  };
  for (std::size_t r = 0; r < one["rods"].size(); ++r) {
    const Json& rod = one["rods"][r];
    block(fmt::format("rod {}", r + 1));
    add_points(data, rod["line"]);
    for (const char* outline : {"body", "band"}) {
      if (!rod.contains(outline)) continue;
      block(fmt::format("{} {}", outline, r + 1));
      add_points(data, rod[outline]);
    }
    const auto [base, angle] = clamp_of(rod);
    add_clamp(data, base, angle, length_, block_of(index, fmt::format("clamp {}", r + 1)));
  }
  if (one.contains("obstacles")) add_shapes(data, one["obstacles"], fmt::format("frame {}: ", index + 1));
  for (const char* key : {"palm", "measured", "tips", "path"}) add(key);
  if (has<hold_key>(one)) block("hold", "x y; around the object, how far forces on it are held");
  for (const Vec2 p : hold_line(one)) data.row(p);
  const double size = 0.1 * length_;
  if (has_target(one)) {
    const Vec2 target = point(one["target"]["position"]);
    block("target");
    data.row(target);
    if (has_direction(one)) {
      const double angle = one["target"]["angle"];
      block("direction", "x y dx dy");
      data.row({target.x, target.y, size * std::cos(angle), size * std::sin(angle)});
    }
  }
  if (has_contact<presses>(one)) block("contacts", "x y dx dy; the arrow's length is proportional to the force");
  for (const Json& contact : one["contacts"]) {
    if (!presses(contact)) continue;
    const auto [from, along] = arrow_of(contact);
    data.row({from.x, from.y, along.x, along.y});
  }
  if (has_contact<touches>(one)) block("touches");
  for (const Json& contact : one["contacts"]) {
    if (touches(contact)) data.row(point(contact["surface"]));
  }
  if (has_contact<slips>(one)) block("slips", "x y dx dy; the force along the rod");
  for (const Json& contact : one["contacts"]) {
    if (!slips(contact)) continue;
    const Vec2 from = point(contact["surface"]);
    const Vec2 along = (per_newton_ * contact["tangential_force"].get<double>()) * point(contact["tangent"]);
    data.row({from.x, from.y, along.x, along.y});
  }
  if (has_contact<rubs>(one)) block("cones", "x y; what the forces may be under friction");
  for (const Json& contact : one["contacts"]) {
    if (!rubs(contact)) continue;
    const auto [from, along] = arrow_of(contact);
    const Vec2 across = (contact["friction"].get<double>() * norm(along)) * point(contact["tangent"]);
    for (const Vec2 p : {from, from + along + across, from + along - across, from}) data.row(p);
    data.gap();
  }
}

std::string FrameFigure::data() const {
  DataFile data(unit_);
  add_shapes(data, drawing_["obstacles"], "");
  if (drawing_.contains("start")) {
    data.block("start.", "x y");
    add_points(data, drawing_["start"]);
  }
  if (drawing_.contains("path")) {
    data.block("path.", "x y");
    for (const Json& p : drawing_["path"]) {
      if (!p.is_null()) data.row(point(p));
    }
    data.block("way.", "x y");
    for (const Json& one : drawing_["frames"]) {
      const bool there = !one["rods"].empty();
      data.row(there ? point(one["rods"][0]["line"].back()) : Vec2{std::nan(""), std::nan("")});
    }
  }
  for (const std::size_t i : frames_) add_frame(data, i);
  return data.text();
}

}  // namespace tendril::app

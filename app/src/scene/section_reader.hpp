#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "scene/keys.hpp"
#include "tendril/scene.hpp"

namespace tendril::app {

/// What a stretch of a rod is made of, as written: stiffness and mass themselves, or a round section, or a table.
struct SectionDraft {
  /// A value where the stretch begins and where it ends.
  using Ends = std::array<double, 2>;
  std::optional<double> length, bending_stiffness, linear_density, rest_curvature, youngs_modulus, density;
  std::optional<double> poisson_ratio, torsional_stiffness, out_of_plane_stiffness, axial_stiffness;
  std::optional<Ends> diameter, inner_diameter, thickness;
  std::optional<std::string> file;
  SourcePosition position{};
};

/// [[rod.load]] as written.
struct LoadDraft {
  std::optional<double> at, from, to, mass;
  std::optional<Vec2> force, force_per_length;
  std::optional<LoadRange> calibrated;
};

/// The key of a value that may change along a stretch.
template <class T>
Key<T> ends(std::string name, std::string default_text, std::string description,
            std::optional<SectionDraft::Ends> SectionDraft::*member) {
  KeySpec spec{
      std::move(name), KeyType::ends, dimension::length, std::move(default_text), std::move(description), 0.0, true};
  return {spec, [spec, member](const Context& context, const Node& node, T& target) {
            const auto* list = std::get_if<Node::List>(&node.value);
            if (list != nullptr && list->size() != 2) {
              context.fail(node, "one value or a list of two, at the base and at the end, each " +
                                     expected_quantity(spec.dimension));
            }
            const double first = read_quantity(context, list != nullptr ? (*list)[0] : node, spec);
            target.*member = {first, list != nullptr ? read_quantity(context, (*list)[1], spec) : first};
          }};
}

/// Keys of a section. `unstated`: where values come from that are not given; empty: defaults.
template <class T>
std::vector<Key<T>> section_keys(const std::string& unstated) {
  const std::string zero = unstated.empty() ? "0" : unstated;
  return {
      quantity<T>("length", dimension::length, positive, unstated, "Length; a 'file' tells it, too.",
                  [](T& t, double v) { t.length = v; }),
      quantity<T>("bending_stiffness", dimension::stiffness, positive, unstated,
                  "Bending stiffness EI; or 'youngs_modulus' and 'diameter', or a 'file'.",
                  [](T& t, double v) { t.bending_stiffness = v; }),
      quantity<T>("linear_density", dimension::linear_density, not_negative, zero,
                  "Mass per length; without it, or 'density', gravity does not act.",
                  [](T& t, double v) { t.linear_density = v; }),
      quantity<T>("rest_curvature", dimension::curvature, any, zero, "Curvature where nothing acts.",
                  [](T& t, double v) { t.rest_curvature = v; }),
      quantity<T>("youngs_modulus", dimension::pressure, positive, unstated,
                  "Young's modulus of the material of a round section.", [](T& t, double v) { t.youngs_modulus = v; }),
      quantity<T>("density", dimension::density, not_negative, zero, "Density of the material of a round section.",
                  [](T& t, double v) { t.density = v; }),
      ends<T>("diameter", unstated, "Diameter of a round section, or [at the base, at the end]; also of the body.",
              &SectionDraft::diameter),
      ends<T>("inner_diameter", zero, "Diameter of its hole.", &SectionDraft::inner_diameter),
      ends<T>("thickness", zero,
              "Diameter of the body around the backbone, where 'diameter' is not given: obstacles are touched so far "
              "from it.",
              &SectionDraft::thickness),
      quantity<T>("poisson_ratio", none, any, unstated.empty() ? "not known" : unstated,
                  "Poisson's ratio of a round section: its torsional stiffness is EI / (1 + this). With it, or "
                  "'torsional_stiffness', plans are judged out of their plane, too.",
                  [](T& t, double v) { t.poisson_ratio = v; }),
      quantity<T>("torsional_stiffness", dimension::stiffness, positive, unstated.empty() ? "not known" : unstated,
                  "Torsional stiffness GJ at the base; along the rod it goes with EI.",
                  [](T& t, double v) { t.torsional_stiffness = v; }),
      quantity<T>("out_of_plane_stiffness", dimension::stiffness, positive, unstated.empty() ? "EI" : unstated,
                  "Stiffness against bending out of the plane, at the base; likewise.",
                  [](T& t, double v) { t.out_of_plane_stiffness = v; }),
      quantity<T>("axial_stiffness", dimension::force, positive, unstated.empty() ? "not known" : unstated,
                  "Axial stiffness EA; or 'youngs_modulus' and 'diameter'. Read where 'stretch_order' is given.",
                  [](T& t, double v) { t.axial_stiffness = v; }),
      text<T>("file", "",
              "CSV file beside the scene with s and bending_stiffness or diameter, and perhaps linear_density and "
              "rest_curvature; linear between its rows.",
              [](T& t, const std::string& v) { t.file = v; })};
}

/// From where to where a load was when its rod was calibrated. `what`: the load; `own`: its dimension in a table.
template <class T>
Key<T> load_range(const std::string& name, const Dimension& dimension, const std::string& what,
                  std::optional<LoadRange> T::*member, Dimension (*own)(const T&) = nullptr) {
  const auto key_of = [=](const Dimension& d) {
    return points<T>(name, KeyType::points, d,
                     what +
                         " that the rod was calibrated with, [along, across] its direction at the base: the least "
                         "coordinates and the largest ones. Results beyond that say so.",
                     [member](T& t, const std::vector<Vec2>& v) {
                       if (v.size() == 2) t.*member = {v.front(), v.back()};
                     });
  };
  Key<T> key = key_of(dimension);
  key.read = [=](const Context& context, const Node& node, T& target) {
    key_of(own != nullptr ? own(target) : dimension).read(context, node, target);
    if (!(target.*member)) context.fail(node, "two points: the least coordinates and the largest ones");
  };
  return key;
}

Table<LoadDraft> load_table();

/// The segments that a section at `path` is made of: one, or those of its table. `name`: of its table in messages.
std::vector<SegmentSpec> finish_section(const Context& context, const std::string& path, const std::string& name,
                                        const SectionDraft& draft);
/// `path`: of its keys.
RodLoadSpec finish_load(const Document& document, const std::string& path, const LoadDraft& draft, double length);

}  // namespace tendril::app

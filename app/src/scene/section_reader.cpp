#include "scene/section_reader.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>

#include "scene/table_file.hpp"

namespace tendril::app {
namespace {

constexpr double agreement = 1e-6;            ///< share by which two statements of one number may differ
constexpr double on_a_line = 1e-9;            ///< share of a column's largest value
constexpr std::size_t most_sections = 10000;  ///< of a table
constexpr std::size_t most_segments = 100;

using Ends = SectionDraft::Ends;
using Coefficients = std::array<double, 5>;

/// Coefficients of (a + (b - a) x)^power.
Coefficients power(Ends ends, int power) {
  Coefficients c{1.0};
  for (int i = 0; i < power; ++i) {
    for (int k = i + 1; k > 0; --k) {
      c[static_cast<std::size_t>(k)] =
          ends[0] * c[static_cast<std::size_t>(k)] + (ends[1] - ends[0]) * c[static_cast<std::size_t>(k) - 1];
    }
    c[0] *= ends[0];
  }
  return c;
}

/// Value and changes of factor (outer^exponent - inner^exponent).
void set_round(Ends outer, Ends inner, int exponent, double factor, double& value, std::vector<double>& more) {
  const Coefficients a = power(outer, exponent);
  const Coefficients b = power(inner, exponent);
  value = factor * (a[0] - b[0]);
  more.clear();
  if (outer[0] == outer[1] && inner[0] == inner[1]) return;
  for (std::size_t k = 1; k <= static_cast<std::size_t>(exponent); ++k) more.push_back(factor * (a[k] - b[k]));
}

void set_line(Ends ends, double& value, std::vector<double>& more) {
  value = ends[0];
  more.clear();
  if (ends[0] != ends[1]) more.push_back(ends[1] - ends[0]);
}

/// A material and the ends of a round section made of it.
struct Round {
  std::optional<double> youngs_modulus, density;
  Ends outer{}, inner{};

  void apply(SegmentSpec& s) const {
    constexpr double pi = std::numbers::pi;
    if (youngs_modulus) {
      set_round(outer, inner, 4, *youngs_modulus * pi / 64.0, s.bending_stiffness, s.more_bending_stiffness);
      set_round(outer, inner, 2, *youngs_modulus * pi / 4.0, s.axial_stiffness, s.more_axial_stiffness);
    }
    if (density) set_round(outer, inner, 2, *density * pi / 4.0, s.linear_density, s.more_linear_density);
    set_line(outer, s.thickness, s.more_thickness);
  }
};

/// What is found and read while one section is put together.
struct Reading {
  const Context& context;
  const std::string& path;
  const std::string& name;
  const SectionDraft& draft;

  [[noreturn]] void fail(const std::string& key, const std::string& message) const {
    const std::string at = key.empty() ? path : path + '.' + key;
    context.document.fail(context.document.find(at), message);
  }
  void refuse_beside(const char* key, bool given, const char* other) const {
    if (given) fail(key, fmt::format("found '{}' beside '{}', expected one of them", key, other));
  }
  void need_diameter(const char* key, bool given) const {
    if (given) fail(key, fmt::format("found '{}' without 'diameter', expected 'diameter' beside it", key));
  }
  /// A number that is stated although a round section tells it, too.
  void compare(const char* key, const std::optional<double>& stated, double round, bool even, const char* unit) const {
    if (!stated || (even && std::abs(*stated - round) <= agreement * std::abs(round))) return;
    fail(key, fmt::format("found {} {} {}, expected what the diameter gives{}, {:.6g} {}, or none of it", key, *stated,
                          unit, even ? "" : " at the base", round, unit));
  }
};

SegmentSpec plain_section(const Reading& r) {
  const SectionDraft& d = r.draft;
  SegmentSpec s;
  s.length = *d.length;
  s.rest_curvature = d.rest_curvature.value_or(0.0);
  if (d.thickness) set_line(*d.thickness, s.thickness, s.more_thickness);
  if (d.diameter) {
    r.refuse_beside("thickness", d.thickness.has_value(), "diameter");
    const Round round{d.youngs_modulus, d.density, *d.diameter, d.inner_diameter.value_or(Ends{})};
    for (const int end : {0, 1}) {
      const auto e = static_cast<std::size_t>(end);
      if (round.inner[e] < round.outer[e]) continue;
      r.fail("inner_diameter",
             fmt::format("found an inner diameter of {} m in a diameter of {} m, expected a smaller one",
                         round.inner[e], round.outer[e]));
    }
    round.apply(s);
    if (d.youngs_modulus) {
      r.compare("bending_stiffness", d.bending_stiffness, s.bending_stiffness, s.more_bending_stiffness.empty(),
                "N m^2");
      r.compare("axial_stiffness", d.axial_stiffness, s.axial_stiffness, s.more_axial_stiffness.empty(), "N");
    }
    if (d.density) {
      r.compare("linear_density", d.linear_density, s.linear_density, s.more_linear_density.empty(), "kg/m");
    }
    if (!d.youngs_modulus && d.bending_stiffness && !s.more_thickness.empty()) {
      r.fail("diameter", "found a diameter that changes beside one 'bending_stiffness', expected 'youngs_modulus'");
    }
  } else {
    r.need_diameter("youngs_modulus", d.youngs_modulus.has_value());
    r.need_diameter("density", d.density.has_value());
    r.need_diameter("inner_diameter", d.inner_diameter.has_value());
  }
  if (!d.youngs_modulus) {
    if (!d.bending_stiffness) {
      r.fail("", r.name + " has no 'bending_stiffness', expected " + expected_quantity(dimension::stiffness) +
                     ", or 'youngs_modulus' and 'diameter'");
    }
    s.bending_stiffness = *d.bending_stiffness;
  }
  if (!d.density) s.linear_density = d.linear_density.value_or(0.0);
  if (d.axial_stiffness && !d.youngs_modulus) s.axial_stiffness = *d.axial_stiffness;
  return s;
}

enum SectionColumn : std::size_t { place, stiffness, mass, rest, width };

/// Rows that lie on a line between the last one kept and the next say nothing.
std::vector<std::vector<double>> without_rows_on_lines(const std::vector<std::vector<double>>& rows) {
  std::vector<double> largest(rows.front().size(), 0.0);
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) largest[c] = std::max(largest[c], std::abs(row[c]));
  }
  std::vector<std::vector<double>> kept{rows.front()};
  std::size_t last = 0;
  const auto on_line = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from + 1; i < to; ++i) {
      const double x = (rows[i][0] - rows[from][0]) / (rows[to][0] - rows[from][0]);
      for (std::size_t c = 1; c < largest.size(); ++c) {
        const double line = rows[from][c] + x * (rows[to][c] - rows[from][c]);
        if (std::abs(rows[i][c] - line) > on_a_line * largest[c]) return false;
      }
    }
    return true;
  };
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (i + 1 < rows.size() && on_line(last, i + 1)) continue;
    kept.push_back(rows[i]);
    last = i;
  }
  return kept;
}

/// Rows of the section's file and which columns it has.
TableFile read_rows(const Reading& r, const std::filesystem::path& path) {
  TableFileSpec spec;
  spec.what = "section";
  spec.columns = {{"s", dimension::length, {"arc_length", "arc length"}},
                  {"bending_stiffness", dimension::stiffness, {"ei", "stiffness"}},
                  {"linear_density", dimension::linear_density, {"mass_per_length"}},
                  {"rest_curvature", dimension::curvature, {"kappa0"}},
                  {"diameter", dimension::length, {"d", "thickness"}}};
  spec.forms = {{place, stiffness}};
  for (const std::vector<std::size_t>& more : std::vector<std::vector<std::size_t>>{
           {mass}, {mass, rest}, {mass, rest, width}, {mass, width}, {rest}, {rest, width}, {width}}) {
    spec.forms.push_back({place, stiffness});
    spec.forms.back().insert(spec.forms.back().end(), more.begin(), more.end());
  }
  spec.forms.push_back({place, width});
  spec.forms.push_back({place, rest, width});
  spec.most_rows = most_sections;
  TableFile file = read_table_file(path, spec, r.context.units);
  if (file.rows.size() < 2) r.fail("file", "the table has fewer than two rows, expected one for each end at least");
  for (std::size_t i = 0; i < file.rows.size(); ++i) {
    const std::vector<double>& row = file.rows[i];
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string& column = spec.columns[file.form[c]].name;
      if (std::isnan(row[c])) r.fail("file", fmt::format("row {} of the table has no {}", i + 1, column));
      const bool above = file.form[c] == stiffness || file.form[c] == width;
      if (above ? !(row[c] > 0.0) : (file.form[c] == mass && row[c] < 0.0)) {
        r.fail("file", fmt::format("found {} {} in row {} of the table, expected {}", column, row[c], i + 1,
                                   above ? "more than 0" : "0 or more"));
      }
    }
    if (i > 0 && !(row[0] > file.rows[i - 1][0])) {
      r.fail("file", fmt::format("found s = {} m after {} m in row {} of the table, expected s to ascend", row[0],
                                 file.rows[i - 1][0], i + 1));
    }
  }
  return file;
}

std::vector<SegmentSpec> table_section(const Reading& r) {
  const SectionDraft& d = r.draft;
  r.refuse_beside("bending_stiffness", d.bending_stiffness.has_value(), "file");
  r.refuse_beside("diameter", d.diameter.has_value(), "file");
  r.refuse_beside("inner_diameter", d.inner_diameter.has_value(), "file");
  const TableFile file = read_rows(r, std::filesystem::path(r.context.document.file()).parent_path() / *d.file);
  const double first = file.rows.front()[0];
  const double length = d.length.value_or(file.rows.back()[0]);
  if (std::abs(first) > on_a_line * length || std::abs(file.rows.back()[0] - length) > on_a_line * length) {
    r.fail("file", fmt::format("found a table from s = {} m to {} m, expected one from 0 to the length, {} m", first,
                               file.rows.back()[0], length));
  }
  std::array<bool, 5> has{};
  for (const std::size_t column : file.form) has[column] = true;
  r.refuse_beside("linear_density", has[mass] && d.linear_density.has_value(), "file");
  r.refuse_beside("rest_curvature", has[rest] && d.rest_curvature.has_value(), "file");
  r.refuse_beside("thickness", has[width] && d.thickness.has_value(), "file");
  r.refuse_beside("axial_stiffness", d.axial_stiffness && d.youngs_modulus, "youngs_modulus");
  r.refuse_beside("youngs_modulus", has[stiffness] && d.youngs_modulus.has_value(), "file");
  r.refuse_beside("density", has[mass] && d.density.has_value(), "file");
  if (!has[width]) r.need_diameter("density", d.density.has_value());
  if (!has[stiffness] && !d.youngs_modulus) {
    r.fail("file", "the table has no bending_stiffness, expected that column, or 'youngs_modulus' beside 'file'");
  }
  const std::vector<std::vector<double>> rows = without_rows_on_lines(file.rows);
  if (rows.size() > most_segments) {
    r.fail("file", fmt::format("found {} rows that lie on no line with their neighbours, expected at most {}",
                               rows.size(), most_segments));
  }
  std::vector<SegmentSpec> segments;
  segments.reserve(rows.size());
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    SegmentSpec s;
    s.length = rows[i + 1][0] - rows[i][0];
    s.linear_density = d.linear_density.value_or(0.0);
    s.rest_curvature = d.rest_curvature.value_or(0.0);
    s.axial_stiffness = d.axial_stiffness.value_or(0.0);
    if (d.thickness) {
      const auto at = [&](double place) {
        return (*d.thickness)[0] + place / length * ((*d.thickness)[1] - (*d.thickness)[0]);
      };
      set_line({at(rows[i][0]), at(rows[i + 1][0])}, s.thickness, s.more_thickness);
    }
    for (std::size_t c = 1; c < file.form.size(); ++c) {
      const Ends ends{rows[i][c], rows[i + 1][c]};
      if (file.form[c] == stiffness) set_line(ends, s.bending_stiffness, s.more_bending_stiffness);
      if (file.form[c] == mass) set_line(ends, s.linear_density, s.more_linear_density);
      if (file.form[c] == rest) set_line(ends, s.rest_curvature, s.more_rest_curvature);
      if (file.form[c] == width) Round{d.youngs_modulus, d.density, ends, {}}.apply(s);
    }
    segments.push_back(std::move(s));
  }
  return segments;
}

/// What a rod resists twist and bending out of its plane with.
void set_out_of_plane(const Reading& r, std::vector<SegmentSpec>& segments) {
  const SectionDraft& d = r.draft;
  r.refuse_beside("torsional_stiffness", d.torsional_stiffness && d.poisson_ratio, "poisson_ratio");
  if (d.poisson_ratio && !(*d.poisson_ratio > -1.0 && *d.poisson_ratio <= 0.5)) {
    r.fail("poisson_ratio",
           fmt::format("found a Poisson's ratio of {}, expected one above -1 and at most 0.5", *d.poisson_ratio));
  }
  if (!d.poisson_ratio && !d.torsional_stiffness) {
    if (!d.out_of_plane_stiffness) return;
    r.fail("out_of_plane_stiffness",
           "found 'out_of_plane_stiffness' alone, expected 'torsional_stiffness' or 'poisson_ratio' beside it");
  }
  const double base = segments.front().bending_stiffness;
  for (SegmentSpec& s : segments) {
    const double share = s.bending_stiffness / base;
    s.torsional_stiffness =
        d.poisson_ratio ? s.bending_stiffness / (1.0 + *d.poisson_ratio) : share * *d.torsional_stiffness;
    if (d.out_of_plane_stiffness) s.out_of_plane_stiffness = share * *d.out_of_plane_stiffness;
  }
}

}  // namespace

Table<LoadDraft> load_table() {
  using T = LoadDraft;
  Key<T> spread = point<T>("force_per_length", dimension::force_per_length, "", "Dead force per length of the rod.",
                           [](T& t, Vec2 v) { t.force_per_length = v; });
  spread.first = true;
  return {
      {quantity<T>("at", dimension::length, positive, "", "Arc length of a point load.",
                   [](T& t, double v) { t.at = v; }),
       point<T>("force", dimension::force, "[0, 0]", "Dead force there.", [](T& t, Vec2 v) { t.force = v; }),
       quantity<T>("mass", dimension::mass, not_negative, "0", "Point mass there.", [](T& t, double v) { t.mass = v; }),
       quantity<T>("from", dimension::length, not_negative, "0",
                   "Arc length at which a load that is spread along the rod begins.",
                   [](T& t, double v) { t.from = v; }),
       quantity<T>("to", dimension::length, positive, "the rod's length", "Arc length at which it ends.",
                   [](T& t, double v) { t.to = v; }),
       std::move(spread),
       load_range<T>("calibrated", dimension::force, "The force, with the weight of the mass,", &T::calibrated,
                     [](const T& t) { return t.force_per_length ? dimension::force_per_length : dimension::force; })}};
}

RodLoadSpec finish_load(const Document& document, const std::string& path, const LoadDraft& draft, double length) {
  const auto fail = [&](const char* key, const std::string& message) {
    document.fail(document.find(path + key), message);
  };
  const auto refuse_beside = [&](const char* key, bool given, const char* other) {
    if (given) fail(key, fmt::format("found '{}' beside '{}', expected one of them", key, other));
  };
  const bool spread = draft.force_per_length.has_value();
  const char* kind = spread ? "force_per_length" : "at";
  refuse_beside("at", spread && draft.at, kind);
  refuse_beside("force", spread && draft.force, kind);
  refuse_beside("mass", spread && draft.mass, kind);
  RodLoadSpec load;
  if (spread) {
    load.from = draft.from.value_or(0.0);
    load.to = draft.to.value_or(length);
    load.force = *draft.force_per_length;
    if (load.from >= load.to) {
      fail(draft.from ? "from" : "to",
           fmt::format("found a load from {} m to {} m, expected from < to", load.from, load.to));
    }
  } else {
    if (!draft.at) {
      document.fail(document.find(path.substr(0, path.size() - 1)),
                    "the load has no place, expected 'at' beside 'force' or 'mass', or 'force_per_length'");
    }
    refuse_beside("from", draft.from.has_value(), kind);
    refuse_beside("to", draft.to.has_value(), kind);
    if (!draft.force && !draft.mass) fail("at", "found 'at' alone, expected 'force' or 'mass' beside it");
    load.from = load.to = *draft.at;
    load.force = draft.force.value_or(Vec2{});
    load.mass = draft.mass.value_or(0.0);
  }
  load.calibrated = draft.calibrated;
  if (load.to > length * (1.0 + 1e-9)) {
    fail(spread ? (draft.to ? "to" : "from") : "at",
         fmt::format("found a load at {} m, expected at most the rod's length, {} m", load.to, length));
  }
  return load;
}

std::vector<SegmentSpec> finish_section(const Context& context, const std::string& path, const std::string& name,
                                        const SectionDraft& draft) {
  const Reading reading{context, path, name, draft};
  std::vector<SegmentSpec> segments;
  if (draft.file) {
    segments = table_section(reading);
  } else {
    if (!draft.length) reading.fail("", name + " has no 'length', expected " + expected_quantity(dimension::length));
    segments = {plain_section(reading)};
  }
  set_out_of_plane(reading, segments);
  return segments;
}

}  // namespace tendril::app

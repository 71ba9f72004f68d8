#include "scene/calibration_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "scene/table_file.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// No file may have more rows: the time limit of a scene is meant for fewer.
constexpr std::size_t most_recorded_rows = 100'000;

constexpr CalibrationUnknown all_unknowns[] = {CalibrationUnknown::stiffness,      CalibrationUnknown::axial_stiffness,
                                               CalibrationUnknown::modulus,        CalibrationUnknown::density,
                                               CalibrationUnknown::rest_curvature, CalibrationUnknown::moment,
                                               CalibrationUnknown::force,          CalibrationUnknown::base_angle,
                                               CalibrationUnknown::base_x,         CalibrationUnknown::base_y};
constexpr Dimension force_per_pressure{0, 0, "N/Pa"};
const std::vector<std::string> scope_names{"all", "group", "recording"};

/// A key whose value is kept as it stands, if it is a number of what an unknown may be.
Key<UnknownDraft> kept(std::string name, std::string description, std::optional<Node> UnknownDraft::*member) {
  KeySpec spec{std::move(name), KeyType::quantity, none, "", std::move(description)};
  return {spec, [spec, member](const Context& context, const Node& node, UnknownDraft& t) {
            for (const Dimension& d : {none, dimension::length, dimension::curvature, dimension::angle,
                                       dimension::moment_per_pressure, force_per_pressure}) {
              KeySpec one = spec;
              one.dimension = d;
              try {
                read_quantity(context, node, one);
                t.*member = node;
                return;
              } catch (const InputError&) {
                continue;
              }
            }
            context.fail(node, "a number that is finite, with the unit of what is looked for or in SI");
          }};
}

Table<UnknownDraft> unknown_table() {
  using T = UnknownDraft;
  std::vector<std::string> names;
  for (const CalibrationUnknown u : all_unknowns) names.emplace_back(to_string(u));
  Key<T> name = text<T>(
      "name", "",
      "What is looked for: a factor on the bending stiffness, on the axial stiffness, on both (modulus) or on the "
      "density, a rest curvature, a moment or an axial force per power of what an actuator is told, or a "
      "coordinate of the base.",
      [names](T& t, const std::string& v) {
        t.spec.kind = all_unknowns[std::find(names.begin(), names.end(), v) - names.begin()];
      },
      names, Need::required);
  name.read = [read = name.read](const Context& context, const Node& node, T& t) {
    const auto* word = std::get_if<std::string>(&node.value);
    if (word != nullptr && *word == "friction") {
      context.document.fail(
          node.position,
          "found \"friction\", which no shape tells: what touches the rod may push off its normal by any share up to "
          "the coefficient, and a shape shows at most that share. Expected it to be measured on a slope, and given as "
          "'friction' in [contact]; problem = \"estimate\" tells what the shapes allow under it");
    }
    read(context, node, t);
  };
  return {{name,
           integer<T>("segment", 1, "all of a stiffness", "Of which segment, counted from the base.",
                      [](T& t, int v) { t.spec.segment = v; }),
           integer<T>("actuator", 1, "1", "Of which actuator.", [](T& t, int v) { t.spec.actuator = v; }),
           integer<T>("degree", 1, "1", "Of a moment or a force as a polynomial of the input, without a constant.",
                      [](T& t, int v) { t.spec.degree = v; }),
           text<T>(
               "per", "all", "Whether each group or recording has a base of its own.",
               [](T& t, const std::string& v) {
                 const auto at = std::find(scope_names.begin(), scope_names.end(), v) - scope_names.begin();
                 t.spec.per = static_cast<CalibrationScope>(at);
               },
               scope_names),
           kept("start", "Where the search begins, of a polynomial its first power; else the scene's own value.",
                &T::start),
           kept("min", "Its smallest value, likewise.", &T::minimum),
           kept("max", "Its largest value, likewise.", &T::maximum),
           kept("prior", "What is believed of it without the measurements.", &T::prior),
           kept("prior_error", "Standard deviation of that.", &T::prior_error)}};
}

/// A column and where its value goes.
struct RecordedColumn {
  ColumnSpec spec;
  std::function<void(Recording&, CalibrationMarker&, double)> take;
  bool marks = false;  ///< it is of a point, not of the recording
};

/// Finds the column's vector entry, made as long as needed.
template <class T>
T& entry(std::vector<T>& list, std::size_t i, std::size_t size) {
  list.resize(std::max(list.size(), size));
  return list[i];
}

std::vector<std::string> numbered(const std::string& name, std::size_t i) {
  return i == 0 ? std::vector<std::string>{name} : std::vector<std::string>{};
}

void add_actuators(std::vector<RecordedColumn>& columns, std::size_t count) {
  struct Input {
    const char* name;
    ActuatorKind kind;
    Dimension dimension;
  };
  const Input inputs[] = {{"moment", ActuatorKind::moment, dimension::moment},
                          {"tension", ActuatorKind::tendon, dimension::force},
                          {"pressure", ActuatorKind::pressure, dimension::pressure}};
  for (std::size_t a = 0; a < count; ++a) {
    for (const Input& input : inputs) {
      columns.push_back({{input.name + ("_" + std::to_string(a + 1)), input.dimension, numbered(input.name, a)},
                         [a, count, kind = input.kind](Recording& r, CalibrationMarker&, double v) {
                           entry(r.inputs, a, count) = v;
                           entry(r.input_kinds, a, count) = kind;
                         }});
    }
  }
}

void add_loads(std::vector<RecordedColumn>& columns, std::size_t count) {
  for (std::size_t l = 0; l < count; ++l) {
    const std::string name = "load_" + std::to_string(l + 1);
    columns.push_back({{name + "_fx", dimension::force, numbered("load_fx", l)},
                       [=](Recording& r, CalibrationMarker&, double v) { entry(r.load_forces, l, count).x = v; }});
    columns.push_back({{name + "_fy", dimension::force, numbered("load_fy", l)},
                       [=](Recording& r, CalibrationMarker&, double v) { entry(r.load_forces, l, count).y = v; }});
    columns.push_back({{name + "_moment", dimension::moment, numbered("load_moment", l)},
                       [=](Recording& r, CalibrationMarker&, double v) { entry(r.load_moments, l, count) = v; }});
  }
}

constexpr std::size_t case_column = 0, group_column = 1, arc_length_column = 2;

/// Everything that a file may say; the first three are as numbered above.
std::vector<RecordedColumn> columns_of(const RodSpec& rod) {
  using R = Recording;
  using M = CalibrationMarker;
  const auto position = [](M& m) -> Vec2& { return m.position ? *m.position : m.position.emplace(); };
  const auto gravity = [](R& r) -> Vec2& { return r.gravity ? *r.gravity : r.gravity.emplace(); };
  std::vector<RecordedColumn> columns{
      {{"case", none, {"recording", "name"}, true}, {}},
      {{"group", none, {"session"}, true}, {}},
      {{"s", dimension::length, {"arc_length", "arc length"}}, [](R&, M& m, double v) { m.arc_length = v; }, true},
      {{"x", dimension::length, {"tip_x"}}, [position](R&, M& m, double v) { position(m).x = v; }, true},
      {{"y", dimension::length, {"tip_y"}}, [position](R&, M& m, double v) { position(m).y = v; }, true},
      {{"angle", dimension::angle, {"tip_angle"}}, [](R&, M& m, double v) { m.angle = v; }, true},
      {{"stalk_normal", dimension::length}, [](R&, M& m, double v) { m.along_normal = v; }, true},
      {{"stalk_axial", dimension::length}, [](R&, M& m, double v) { m.along_tangent = v; }, true},
      {{"out_of_plane", dimension::length, {"z", "tip_out_of_plane"}},
       [](R&, M& m, double v) { m.out_of_plane = v; },
       true},
      {{"gravity_x", dimension::acceleration, {"g_x"}}, [gravity](R& r, M&, double v) { gravity(r).x = v; }},
      {{"gravity_y", dimension::acceleration, {"g_y"}}, [gravity](R& r, M&, double v) { gravity(r).y = v; }},
      {{"tip_fx", dimension::force}, [](R& r, M&, double v) { r.tip_force.x = v; }},
      {{"tip_fy", dimension::force}, [](R& r, M&, double v) { r.tip_force.y = v; }},
      {{"tip_moment", dimension::moment}, [](R& r, M&, double v) { r.tip_moment = v; }}};
  add_actuators(columns, rod.actuators.size());
  add_loads(columns, rod.loads.size());
  return columns;
}

/// Recordings in the order in which their names come up.
class Recordings {
 public:
  Recordings(const Context& context, Scene& scene)
      : context_(context), scene_(scene), columns_(columns_of(scene.rod)) {}

  void read(const std::string& name, bool check);
  std::vector<Recording> take();

 private:
  void compare_units(const TableFile& file, const std::string& name);
  void take_row(const TableFile& file, std::size_t row, const std::string& name, bool check);
  Recording& called(const std::string& name, const std::string& place);

  const Context& context_;
  Scene& scene_;
  std::vector<RecordedColumn> columns_;
  std::vector<Recording> list_;
  std::map<std::string, std::size_t> index_;
  std::map<std::string, std::map<std::size_t, double>> known_;  // of a recording, as told first
  /// A column as the first file has it that has it.
  struct Seen {
    std::string file;
    bool with_unit = false;
    double largest = 0.0;
  };
  std::map<std::size_t, Seen> seen_;
};

void Recordings::read(const std::string& name, bool check) {
  TableFileSpec spec;
  spec.what = "calibrate";
  for (const RecordedColumn& column : columns_) spec.columns.push_back(column.spec);
  spec.most_rows = most_recorded_rows;
  spec.example = arc_length_column;
  const std::filesystem::path path = std::filesystem::path(context_.document.file()).parent_path() / name;
  const TableFile file = read_table_file(path, spec, context_.units);
  for (const std::string& unread : file.unread) {
    scene_.left_out.push_back({"column \"" + unread + "\" of " + name, "a calibration has no use for it"});
  }
  compare_units(file, name);
  for (std::size_t row = 0; row < file.rows.size(); ++row) take_row(file, row, name, check);
}

/// Asks about columns that may be in other units than those of the files before.
void Recordings::compare_units(const TableFile& file, const std::string& name) {
  constexpr double far_apart = 100.0;  // no unit and its thousandth are nearer
  for (std::size_t i = 0; i < file.form.size(); ++i) {
    const ColumnSpec& column = columns_[file.form[i]].spec;
    if (column.dimension.unit.empty()) continue;
    Seen own{name, file.with_unit[i]};
    for (const std::vector<double>& row : file.rows) {
      if (std::isfinite(row[i])) own.largest = std::max(own.largest, std::abs(row[i]));
    }
    const auto [at, fresh] = seen_.emplace(file.form[i], own);
    const Seen& first = at->second;
    if (fresh) continue;
    const auto ask = [&](const std::string& what) {
      scene_.warnings.push_back(
          fmt::format("the column {} of {} {}: is it in the unit that is meant?", column.name, name, what));
    };
    const double ratio = own.largest / first.largest;
    if (own.with_unit != first.with_unit) {
      ask(fmt::format("{} unit, and is read in {}, that of {} {}", own.with_unit ? "has a" : "has no",
                      own.with_unit ? "it" : std::string(column.dimension.unit), first.file,
                      first.with_unit ? "has one" : "has none"));
    } else if (!own.with_unit && own.largest > 0.0 && first.largest > 0.0 &&
               !(ratio < far_apart && ratio > 1.0 / far_apart)) {
      ask(fmt::format("reaches {:.3g} {}, that of {} {:.3g} {}, both without a unit", own.largest,
                      column.dimension.unit, first.file, first.largest, column.dimension.unit));
    }
  }
}

Recording& Recordings::called(const std::string& name, const std::string& place) {
  const auto [at, fresh] = index_.emplace(name, list_.size());
  if (fresh) {
    list_.emplace_back();
    list_.back().name = name;
    list_.back().place = place;
  }
  return list_[at->second];
}

void Recordings::take_row(const TableFile& file, std::size_t row, const std::string& name, bool check) {
  const std::string place = fmt::format("{}:{}", name, file.lines[row]);
  const auto word = [&](std::size_t column) -> std::string {
    const auto at = std::find(file.form.begin(), file.form.end(), column);
    return at == file.form.end() ? "" : file.texts[row][static_cast<std::size_t>(at - file.form.begin())];
  };
  const std::string own = word(case_column);
  Recording& recording = called(own.empty() ? place : own, place);
  if (const std::string group = word(group_column); !group.empty()) recording.group = group;
  CalibrationMarker marker;
  marker.arc_length = std::numeric_limits<double>::quiet_NaN();
  bool seen = false;
  for (std::size_t i = 0; i < file.form.size(); ++i) {
    const RecordedColumn& column = columns_[file.form[i]];
    const double value = file.rows[row][i];
    if (column.spec.text || std::isnan(value)) continue;
    column.take(recording, marker, value);
    seen = seen || (column.marks && file.form[i] != arc_length_column);
    if (column.marks) continue;
    const auto [told, fresh] = known_[recording.name].emplace(file.form[i], value);
    if (!fresh && told->second != value) {
      throw InputError(
          fmt::format("{}: recording \"{}\": found {} = {} {}, but {} before, expected one value for each "
                      "recording",
                      place, recording.name, column.spec.name, value, column.spec.dimension.unit, told->second));
    }
  }
  if (!seen) return;
  // A point without an arc length is the tip.
  if (std::isnan(marker.arc_length)) marker.arc_length = scene_.rod.length();
  if (!marker.position && !marker.angle) return;
  // What was known of it may stand elsewhere: the file with its points says whether it is fitted.
  if (recording.markers.empty()) recording.check_only = check;
  if (recording.check_only != check) {
    throw InputError(
        fmt::format("{}: recording \"{}\" has points among 'files' and among 'check_files', expected it "
                    "in one of them",
                    place, recording.name));
  }
  recording.markers.push_back(marker);
}

std::vector<Recording> Recordings::take() {
  std::erase_if(list_, [&](const Recording& r) {
    const bool empty = r.markers.empty();
    if (empty) scene_.left_out.push_back({"recording \"" + r.name + "\"", "no file has a point of it"});
    return empty;
  });
  return std::move(list_);
}

Dimension dimension_of(const CalibrationUnknownSpec& unknown, const std::vector<Recording>& recordings) {
  switch (unknown.kind) {
    case CalibrationUnknown::stiffness:
    case CalibrationUnknown::axial_stiffness:
    case CalibrationUnknown::modulus:
    case CalibrationUnknown::density:
      return none;
    case CalibrationUnknown::rest_curvature:
      return dimension::curvature;
    case CalibrationUnknown::base_angle:
      return dimension::angle;
    case CalibrationUnknown::base_x:
    case CalibrationUnknown::base_y:
      return dimension::length;
    case CalibrationUnknown::moment:
    case CalibrationUnknown::force:
      break;
  }
  const auto a = static_cast<std::size_t>(unknown.actuator - 1);
  const bool told = !recordings.empty() && a < recordings.front().input_kinds.size();
  const ActuatorKind kind = told ? recordings.front().input_kinds[a] : ActuatorKind::moment;
  if (unknown.kind == CalibrationUnknown::force) {
    return kind == ActuatorKind::pressure ? force_per_pressure
           : kind == ActuatorKind::moment ? dimension::curvature
                                          : none;
  }
  return kind == ActuatorKind::pressure ? dimension::moment_per_pressure
         : kind == ActuatorKind::tendon ? dimension::length
                                        : none;
}

CalibrationUnknownSpec finish_unknown(const Context& context, const UnknownDraft& draft,
                                      const std::vector<Recording>& recordings) {
  CalibrationUnknownSpec spec = draft.spec;
  KeySpec key;
  key.dimension = dimension_of(spec, recordings);
  const auto read = [&](const std::optional<Node>& node, auto set) {
    if (node) set(read_quantity(context, *node, key));
  };
  read(draft.start, [&](double v) { spec.start = v; });
  read(draft.minimum, [&](double v) { spec.minimum = v; });
  read(draft.maximum, [&](double v) { spec.maximum = v; });
  read(draft.prior, [&](double v) { spec.prior = v; });
  read(draft.prior_error, [&](double v) { spec.prior_error = v; });
  return spec;
}

}  // namespace

Table<CalibrationDraft> calibration_table() {
  using T = CalibrationDraft;
  const auto files = [](std::string name, std::string description, std::vector<std::string> T::*member) {
    return texts<T>(std::move(name), std::move(description), {},
                    [member](T& t, const std::vector<std::string>& v) { t.*member = v; });
  };
  return {
      {files("files",
             "CSV files with measured points and with what was known of each recording, beside the scene. Columns: "
             "case, group; s, x, y, angle, stalk_normal, stalk_axial, out_of_plane; moment_1, tension_1 or pressure_1 "
             "of the first "
             "actuator, ...; gravity_x, gravity_y; tip_fx, tip_fy, tip_moment; load_1_fx, load_1_fy, load_1_moment of "
             "the first [[rod.load]], ... A point without s is the tip; without a case each row is a recording.",
             &T::files),
       files("check_files", "Files with recordings that are predicted, and not fitted.", &T::check_files),
       quantity<T>("noise", dimension::length, positive, "estimated from the residuals",
                   "Standard deviation of each measured coordinate.", [](T& t, double v) { t.spec.noise = v; }),
       quantity<T>("angle_noise", dimension::angle, positive, "as the noise turns half the rod",
                   "Standard deviation of a measured angle; needs 'noise'.",
                   [](T& t, double v) { t.spec.angle_noise = v; }),
       text<T>("loss", "squares", "Whether points far off count by their square, or less (Huber's loss).",
               [](T& t, const std::string& v) { t.spec.robust = v == "huber"; }, {"squares", "huber"}),
       integer<T>("folds", 0, "5", "Parts of the recordings that are left out in turn and predicted.",
                  [](T& t, int v) { t.spec.folds = v; }),
       text<T>("fold_by", "recording", "Whether recordings or whole groups are left out in turn.",
               [](T& t, const std::string& v) { t.spec.fold_by_group = v == "group"; }, {"recording", "group"}),
       integer<T>("starts", 1, "4", "Fits that are begun at most.", [](T& t, int v) { t.spec.starts = v; }),
       tables<T>(
           "unknown", "calibrate.unknown", "A number that is looked for.", unknown_table(),
           [](T & t) -> auto& { return t.unknowns; })}};
}

CalibrationSpec finish_calibration(const Context& context, const CalibrationDraft& draft, Scene& scene) {
  const Document& document = context.document;
  if (draft.files.empty()) {
    document.fail(document.find("calibrate"), "[calibrate] has no 'files', expected CSV files with measured points");
  }
  if (draft.spec.folds == 1) {
    document.fail(document.find("calibrate.folds"),
                  "found 1 part, expected 0 or at least 2: each is predicted from the others");
  }
  if (draft.spec.angle_noise > 0.0 && draft.spec.noise == 0.0) {
    document.fail(document.find("calibrate.angle_noise"), "found 'angle_noise' without 'noise', expected both");
  }
  CalibrationSpec spec = draft.spec;
  Recordings recordings(context, scene);
  for (const std::string& name : draft.files) recordings.read(name, false);
  for (const std::string& name : draft.check_files) recordings.read(name, true);
  spec.recordings = recordings.take();
  for (const UnknownDraft& unknown : draft.unknowns) {
    spec.unknowns.push_back(finish_unknown(context, unknown, spec.recordings));
  }
  return spec;
}

}  // namespace tendril::app

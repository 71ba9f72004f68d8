#include "scene/measurement_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "scene/table_file.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {

namespace {

/// A length, or a number of pixels if the scene says how long one is.
MeasuredLength read_measured(const Context& context, const Node& node, const KeySpec& key) {
  return {read_quantity(context, node, key), !std::holds_alternative<std::string>(node.value)};
}

/// Rows of lengths, all of two or all of three entries.
void read_measured_points(const Context& context, const Node& node, const KeySpec& key, MeasurementDraft& draft) {
  const std::string expected = "a list of points, each [s, x, y] or [x, y]";
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr || list->empty()) {
    context.fail(node, expected);
  }
  if (list->size() > most_measured_points) {
    context.document.fail(node.position,
                          fmt::format("found {} points, expected at most {}", list->size(), most_measured_points));
  }
  for (const Node& item : *list) {
    const auto* entries = std::get_if<Node::List>(&item.value);
    if (entries == nullptr || (entries->size() != 2 && entries->size() != 3)) {
      context.fail(item, "a point [s, x, y] or [x, y]");
    }
    if (!draft.rows.empty() && entries->size() != draft.rows.front().size()) {
      context.document.fail(item.position,
                            fmt::format("found a point of {} entries, expected {} as in the points before",
                                        entries->size(), draft.rows.front().size()));
    }
    std::vector<MeasuredLength> row;
    row.reserve(entries->size());
    for (const Node& entry : *entries) row.push_back(read_measured(context, entry, key));
    draft.rows.push_back(std::move(row));
  }
}

void read_origin(const Context& context, const Node& node, const KeySpec& key, MeasurementDraft& draft) {
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr || list->size() != 2) {
    context.fail(node, "a list of two entries [x, y], each " + expected_quantity(key.dimension));
  }
  draft.origin = {read_measured(context, (*list)[0], key), read_measured(context, (*list)[1], key)};
}

void read_known_moments(const Context& context, const Node& node, const KeySpec& key, MeasurementDraft& draft) {
  const auto* list = std::get_if<Node::List>(&node.value);
  if (list == nullptr) {
    context.fail(node, "a list of moments, one for each actuator");
  }
  for (const Node& item : *list) draft.moments.push_back(read_quantity(context, item, key));
}

/// Points as they were measured, one after the other: s, x, y or x, y each; NaN where nothing was seen.
struct Readings {
  std::vector<std::vector<double>> rows;
  std::vector<bool> blank;
};

bool is_complete(const std::vector<double>& row) {
  return std::none_of(row.begin(), row.end(), [](double v) { return std::isnan(v); });
}

/// What was read at once.
struct FrameReadings {
  double time = 0.0;            ///< or its number
  std::string place{};          ///< file and line of its first row
  std::vector<double> moments;  ///< of each actuator, where the file has them; NaN: not yet
  Readings points;
};

constexpr std::size_t s_column = 0, x_column = 1, y_column = 2, time_column = 3, frame_column = 4, first_moment = 5;

TableFileSpec columns_of(const RodSpec& rod, double pixel) {
  TableFileSpec spec;
  spec.what = "measurement";
  spec.columns = {{"s", dimension::length, {"arc_length", "arc length", "arclength"}},
                  {"x", dimension::length},
                  {"y", dimension::length},
                  {"time", dimension::time},
                  {"frame", none}};
  spec.forms = {{x_column, y_column}, {s_column, x_column, y_column}};
  spec.besides = {time_column, frame_column};
  for (std::size_t a = 0; a < rod.actuators.size(); ++a) {
    spec.besides.push_back(spec.columns.size());
    spec.columns.push_back({fmt::format("moment_{}", a + 1), dimension::moment, {}});
    if (a == 0) spec.columns.back().also = {"moment"};
  }
  spec.most_rows = most_sequence_points;
  spec.pixel = pixel;
  return spec;
}

/// Files with one shape, or with one after the other.
class MeasuredFiles {
 public:
  MeasuredFiles(const Context& context, const MeasurementDraft& draft, Scene& scene)
      : context_(context), draft_(draft), scene_(scene), spec_(columns_of(scene.rod, draft.scale.value_or(0.0))) {}
  void read(const std::string& name);

  std::vector<FrameReadings> frames;
  bool timed = false;  ///< times of frames are in s; else numbers

 private:
  double value(std::size_t row, std::size_t column) const;
  bool has(std::size_t column) const {
    return std::find(file_.form.begin(), file_.form.end(), column) != file_.form.end();
  }
  std::string name(double time) const { return timed ? "time " + shown(time) + " s" : "frame " + shown(time); }
  void take(std::size_t row, bool sequence);
  bool begin_frame(std::size_t row);
  void take_moments(std::size_t row);
  void require_once(std::size_t row, const std::vector<double>& point) const;
  void require_same_kind(bool sequence) const;
  void require_moments() const;
  std::string place(std::size_t row) const { return fmt::format("{}:{}:1", path_, file_.lines[row]); }
  [[noreturn]] void fail(std::size_t row, const std::string& message) const {
    throw InputError(place(row) + ": " + message);
  }

  const Context& context_;
  const MeasurementDraft& draft_;
  Scene& scene_;
  TableFileSpec spec_;
  std::string path_;
  TableFile file_;
  std::vector<std::size_t> moment_columns_;
  bool sequence_ = false;          ///< of the last file
  std::size_t first_of_file_ = 0;  ///< among the frames
  std::size_t rows_ = 0;           ///< of all files
};

void MeasuredFiles::read(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(context_.document.file()).parent_path() / name;
  path_ = path.string();
  file_ = read_table_file(path, spec_, context_.units);
  for (const std::string& unread : file_.unread) {
    scene_.left_out.push_back({"column \"" + unread + "\" of " + name,
                               "an estimate reads s, x and y, and of a sequence its time or frame and the moments"});
  }
  const std::size_t actuators = scene_.rod.actuators.size();
  moment_columns_.clear();
  for (std::size_t a = 0; a < actuators; ++a) {
    if (has(first_moment + a)) moment_columns_.push_back(first_moment + a);
  }
  if (!moment_columns_.empty() && (moment_columns_.size() < actuators || !draft_.moments.empty())) {
    throw InputError(fmt::format("{}: found the column {} {}", path_, spec_.columns[moment_columns_.front()].name,
                                 moment_columns_.size() < actuators
                                     ? fmt::format("alone, expected one for each of the {} actuators", actuators)
                                     : "beside 'moments' in [measurement], expected either of them"));
  }
  if (has(time_column) && has(frame_column)) {
    scene_.left_out.push_back({"column \"frame\" of " + name, "the times tell the frames apart"});
  }
  const bool sequence = has(time_column) || has(frame_column);
  require_same_kind(sequence);
  sequence_ = sequence;
  timed = has(time_column);
  first_of_file_ = frames.size();
  rows_ += file_.rows.size();
  if (rows_ > most_sequence_points)
    throw InputError(fmt::format("{}: found {} rows with those of the files before, expected at most {}", path_, rows_,
                                 most_sequence_points));
  if (!sequence) frames.emplace_back();
  for (std::size_t row = 0; row < file_.rows.size(); ++row) take(row, sequence);
  require_moments();
}

/// As the files before have them.
void MeasuredFiles::require_same_kind(bool sequence) const {
  if (frames.empty() || (sequence && sequence_ && timed == has(time_column))) return;
  throw InputError(fmt::format(
      "{}: found {} after a file with {}, expected a column 'time', or 'frame', in each of several files", path_,
      !sequence          ? "a single shape"
      : has(time_column) ? "times"
                         : "numbers of frames",
      !sequence_ ? "a single shape"
      : timed    ? "times"
                 : "numbers of frames"));
}

double MeasuredFiles::value(std::size_t row, std::size_t column) const {
  const auto at = std::find(file_.form.begin(), file_.form.end(), column) - file_.form.begin();
  return file_.rows[row][static_cast<std::size_t>(at)];
}

void MeasuredFiles::take(std::size_t row, bool sequence) {
  if (sequence && !begin_frame(row)) return;
  std::vector<double> point;
  for (std::size_t i = 0; i < file_.form.size(); ++i) {
    if (file_.form[i] <= y_column) point.push_back(file_.rows[row][i]);
  }
  FrameReadings& frame = frames.back();
  if (frame.points.rows.size() == most_measured_points) {
    fail(row, fmt::format("found more than {} points, expected at most as many", most_measured_points));
  }
  if (sequence) require_once(row, point);
  take_moments(row);
  frame.points.blank.push_back(file_.blank[row]);
  frame.points.rows.push_back(std::move(point));
}

/// False: the row is of no frame.
bool MeasuredFiles::begin_frame(std::size_t row) {
  if (file_.blank[row]) return false;
  const double time = value(row, timed ? time_column : frame_column);
  const char* column = timed ? "time" : "frame";
  if (std::isnan(time)) fail(row, fmt::format("found a row without its {}, expected one in each", column));
  const bool begins = frames.size() == first_of_file_;
  if (!begins && time == frames.back().time) return true;
  if (!frames.empty() && time <= frames.back().time) {
    fail(row, fmt::format("found {} after {} at {}, expected an ascending {}, from file to file as well, and the rows "
                          "of a frame together",
                          name(time), name(frames.back().time), frames.back().place, column));
  }
  frames.push_back({time, place(row), {}, {}});
  return true;
}

void MeasuredFiles::require_once(std::size_t row, const std::vector<double>& point) const {
  if (!is_complete(point)) return;
  const FrameReadings& frame = frames.back();
  const std::size_t compared = point.size() == 3 ? 1 : 2;
  for (const std::vector<double>& other : frame.points.rows) {
    if (!std::equal(point.begin(), point.begin() + static_cast<std::ptrdiff_t>(compared), other.begin())) continue;
    fail(row, fmt::format("found a point at the same {} once more in the frame of {}, expected each frame "
                          "once with a {} of its own",
                          compared == 1 ? "arc length" : "place", name(frame.time), timed ? "time" : "number"));
  }
}

void MeasuredFiles::take_moments(std::size_t row) {
  FrameReadings& frame = frames.back();
  if (frame.place.empty()) frame.place = place(row);
  frame.moments.resize(moment_columns_.size(), std::nan(""));
  for (std::size_t a = 0; a < moment_columns_.size(); ++a) {
    const double moment = value(row, moment_columns_[a]);
    if (std::isnan(moment)) continue;
    if (!std::isnan(frame.moments[a]) && frame.moments[a] != moment) {
      fail(row, fmt::format("found moment_{} = {} N m, but {} N m before in the same frame, expected one "
                            "value for each frame",
                            a + 1, shown(moment), shown(frame.moments[a])));
    }
    frame.moments[a] = moment;
  }
}

void MeasuredFiles::require_moments() const {
  for (const FrameReadings& frame : frames) {
    for (std::size_t a = 0; a < frame.moments.size(); ++a) {
      if (std::isnan(frame.moments[a])) {
        throw InputError(
            frame.place +
            fmt::format(": found no moment_{} in the frame that begins here, expected one in each frame", a + 1));
      }
    }
  }
}

Readings listed(const MeasurementDraft& draft) {
  Readings out;
  for (const std::vector<MeasuredLength>& row : draft.rows) {
    std::vector<double> lengths;
    lengths.reserve(row.size());
    for (const MeasuredLength& value : row) lengths.push_back(value.in_metres(draft.scale));
    out.rows.push_back(std::move(lengths));
  }
  out.blank.assign(out.rows.size(), false);
  return out;
}

/// Points [x, y] stand at equal distances: from the base or from the tip on, with one at the base or without.
struct Spacing {
  bool from_tip = false;
  bool with_base = false;
};

/// Arc length of place `i` of `count`.
double equal_arc_length(const Spacing& spacing, std::size_t i, std::size_t count, double length) {
  const std::size_t place = spacing.from_tip ? count - 1 - i : i;
  const auto steps = static_cast<double>(spacing.with_base ? std::max<std::size_t>(count, 2) - 1 : count);
  return length * static_cast<double>(place + (spacing.with_base ? 0 : 1)) / steps;
}

/// Where the points say that the base is. A point at arc length s near it is close to s along the base's tangent.
Spacing spacing_of(const std::vector<std::vector<double>>& rows, const RodSpec& rod) {
  const Vec2 tangent{std::cos(rod.base_angle), std::sin(rod.base_angle)};
  // Distance of the seen point that lies first from where it would be.
  const auto error = [&](const Spacing& spacing) {
    double least = std::numeric_limits<double>::infinity();
    double found = least;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double s = equal_arc_length(spacing, i, rows.size(), rod.length());
      if (!is_complete(rows[i]) || s >= least) continue;
      least = s;
      found = norm(Vec2{rows[i][0], rows[i][1]} - rod.base_position - s * tangent);
    }
    return found;
  };
  Spacing best;
  // Few points are too far apart to tell.
  if (rows.size() < 3) return best;
  const auto nearest = [&](bool from_tip) { return std::min(error({from_tip, false}), error({from_tip, true})); };
  best.from_tip = nearest(true) < 0.25 * nearest(false);
  best.with_base = error({best.from_tip, true}) < 0.25 * error({best.from_tip, false});
  return best;
}

bool has_equal_spacing(const Readings& readings) { return !readings.rows.empty() && readings.rows.front().size() == 2; }

/// What else stands among points.
struct Unread {
  std::size_t rows = 0, lost = 0;  ///< how many, and how many without a point
  bool from_tip = false;
};

/// The points that were seen, along the rod.
std::vector<MeasuredPoint> points_of(const MeasurementDraft& draft, Readings readings, const RodSpec& rod,
                                     Unread& unread) {
  std::vector<MeasuredPoint> points;
  unread.rows += readings.rows.size();
  unread.lost += readings.rows.size();
  // Empty rows at the end are no places along the rod, between points they are.
  while (!readings.rows.empty() && readings.blank[readings.rows.size() - 1]) readings.rows.pop_back();
  const Spacing spacing = has_equal_spacing(readings) ? spacing_of(readings.rows, rod) : Spacing{};
  for (std::size_t i = 0; i < readings.rows.size(); ++i) {
    const std::vector<double>& row = readings.rows[i];
    if (!is_complete(row)) continue;
    const double s = row.size() == 3 ? row[0] : equal_arc_length(spacing, i, readings.rows.size(), rod.length());
    const Vec2 origin{draft.origin[0].in_metres(draft.scale), draft.origin[1].in_metres(draft.scale)};
    const Vec2 p = Vec2{row[row.size() - 2], row[row.size() - 1]} - origin;
    points.push_back({s, {p.x, draft.y_down ? -p.y : p.y}});
  }
  unread.lost -= points.size();
  unread.from_tip = unread.from_tip || spacing.from_tip;
  return points;
}

bool same_points(const MeasuredFrame& a, const MeasuredFrame& b) {
  return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                    [](const MeasuredPoint& p, const MeasuredPoint& q) {
                      return p.arc_length == q.arc_length && p.position.x == q.position.x &&
                             p.position.y == q.position.y;
                    });
}

/// Shapes of the file, of which at least one is there; those of a sequence in which nothing was seen are left out.
std::vector<MeasuredFrame> read_frames(const Context& context, const MeasurementDraft& draft, Scene& scene,
                                       Unread& unread, bool& timed) {
  MeasuredFiles file(context, draft, scene);
  for (const std::string& name : draft.all_files()) file.read(name);
  timed = file.timed;
  const std::string names = fmt::format("{}", fmt::join(draft.all_files(), ", "));
  std::size_t empty = 0;
  std::size_t same = 0;
  std::vector<MeasuredFrame> frames;
  for (FrameReadings& read : file.frames) {
    MeasuredFrame frame{read.time, {}, std::move(read.moments)};
    frame.equal_spacing = has_equal_spacing(read.points);
    frame.points = points_of(draft, std::move(read.points), scene.rod, unread);
    if (frame.points.empty() && file.frames.size() > 1) {
      ++empty;
      continue;
    }
    if (!frames.empty() && same_points(frames.back(), frame)) ++same;
    frames.push_back(std::move(frame));
  }
  if (empty > 0) scene.left_out.push_back({fmt::format("{} frames of {}", empty, names), "they hold no point"});
  if (same > 0) {
    scene.warnings.push_back(
        fmt::format("{} of the {} frames of {} have the points of the frame before to the last "
                    "digit: are frames there twice?",
                    same, frames.size(), names));
  }
  if (frames.empty()) frames.emplace_back();
  return frames;
}

}  // namespace

Table<MeasurementDraft> measurement_table() {
  using T = MeasurementDraft;
  const auto list = [](std::string name, KeyType type, const Dimension& dimension, std::string description, auto read) {
    KeySpec spec{std::move(name), type, dimension, "", std::move(description)};
    return Key<T>{spec, [spec, read](const Context& context, const Node& node, T& t) { read(context, node, spec, t); }};
  };
  return {
      {list("points", KeyType::points, dimension::length,
            "Measured backbone points: [s, x, y] each, or [x, y] at equal distances along the rod, the last one at "
            "the tip.",
            read_measured_points),
       text<T>("file", "",
               "CSV file with the points instead, beside the scene; columns x, y or s, x, y. With a column time or "
               "frame it is a sequence of shapes, and may have the moment of each actuator then: moment_1, ...",
               [](T& t, const std::string& v) { t.file = v; }),
       texts<T>("files",
                "Such files of a sequence instead, in the order in which they were recorded: times, or numbers of "
                "frames, go on from one to the next.",
                {}, [](T& t, const std::vector<std::string>& v) { t.files = v; }),
       quantity<T>("scale", dimension::length, positive, "none: numbers are in m",
                   "Length of one pixel; lengths without a unit in 'points', 'file' and 'origin' are pixels then.",
                   [](T& t, double v) { t.scale = v; }),
       list("origin", KeyType::point, dimension::length,
            "Where in the picture the scene's point (0, 0) is, in the coordinates of the points.", read_origin),
       boolean<T>("y_down", "false", "The points' y axis points down, as in a picture.",
                  [](T& t, bool v) { t.y_down = v; }),
       quantity<T>("noise", dimension::length, positive, "estimated from the residuals",
                   "Standard deviation of each measured coordinate.", [](T& t, double v) { t.noise = v; }),
       quantity<T>("force_rate", dimension::force, positive, "the largest that the frames allow",
                   "Of a sequence: standard deviation of what the force of a contact changes by in 1 s, or from one "
                   "frame to the next where they have numbers; n times as long, by sqrt(n) as much.",
                   [](T& t, double v) { t.force_rate = v; }),
       quantity<T>("place_rate", dimension::length, positive, "the largest that the frames allow",
                   "Likewise of what its arc length changes by.", [](T& t, double v) { t.place_rate = v; }),
       list("moments", KeyType::quantities, dimension::moment,
            "Moment of each actuator while the points were measured; not needed where min and max are equal.",
            read_known_moments)}};
}

MeasurementSpec finish_measurement(const Context& context, const MeasurementDraft& draft, Scene& scene) {
  const Document& document = context.document;
  MeasurementSpec spec;
  if (scene.problem != ProblemKind::estimate) {
    if (document.root().find("measurement") != nullptr) {
      document.fail(document.find("measurement"), "found [measurement] in a scene with problem = \"" +
                                                      std::string(to_string(scene.problem)) +
                                                      "\", expected problem = \"estimate\"");
    }
    return spec;
  }
  const auto refuse = [&](const char* key, bool given, const char* other, bool beside) {
    if (!given || !beside) return;
    document.fail(document.find(std::string("measurement.") + key),
                  fmt::format("found '{}' beside '{}', expected either of them", key, other));
  };
  refuse("file", !draft.file.empty(), "points", !draft.rows.empty());
  refuse("files", !draft.files.empty(), "points", !draft.rows.empty());
  refuse("files", !draft.files.empty(), "file", !draft.file.empty());
  spec.noise = draft.noise.value_or(0.0);
  spec.moments = draft.moments;
  Unread unread;
  bool single = true;
  const std::vector<std::string> files = draft.all_files();
  if (files.empty()) {
    Readings readings = listed(draft);
    spec.equal_spacing = has_equal_spacing(readings);
    spec.points = points_of(draft, std::move(readings), scene.rod, unread);
  } else {
    bool timed = false;
    std::vector<MeasuredFrame> frames = read_frames(context, draft, scene, unread, timed);
    single = frames.size() == 1;
    spec.points = std::move(frames.front().points);
    spec.equal_spacing = frames.front().equal_spacing;
    if (!frames.front().moments.empty()) spec.moments = std::move(frames.front().moments);
  }
  if (unread.lost > 0) {
    scene.left_out.push_back({fmt::format("{} of the {} rows of {}", unread.lost, unread.rows, fmt::join(files, ", ")),
                              "they hold no point: a value is empty or not a number"});
  }
  if (unread.from_tip) scene.warnings.push_back("the measured points are read from the tip to the base");
  const char* rate = draft.force_rate ? "force_rate" : draft.place_rate ? "place_rate" : nullptr;
  if (rate != nullptr && single) {
    document.fail(
        document.find(std::string("measurement.") + rate),
        fmt::format("found '{}' with a single shape, expected a file with a column 'time' or 'frame' and more "
                    "than one frame",
                    rate));
  }
  return spec;
}

std::optional<SequenceSpec> read_sequence(const Document& document, const Units& units, const Scene& scene) {
  std::vector<std::string> told_by_read_scene;
  const Context context{document, units, told_by_read_scene};
  MeasurementDraft draft;
  if (const Node* table = document.root().find("measurement")) {
    read_table(context, *table, "measurement", measurement_table(), draft);
  }
  if (scene.problem != ProblemKind::estimate || draft.all_files().empty()) return std::nullopt;
  Scene told = scene;
  Unread unread;
  SequenceSpec spec;
  spec.frames = read_frames(context, draft, told, unread, spec.timed);
  spec.force_rate = draft.force_rate;
  spec.place_rate = draft.place_rate;
  return spec.frames.size() > 1 ? std::optional(spec) : std::nullopt;
}

}  // namespace tendril::app

#include "figure/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "figure/backbones.hpp"
#include "figure/drawing_numbers.hpp"
#include "figure/gnuplot.hpp"
#include "figure/outlines.hpp"
#include "result/json_reader.hpp"
#include "tendril/grasp.hpp"
#include "tendril/plugins/components.hpp"

namespace tendril::app {

namespace {

/// Decimals that a point of a rod of this length needs, so that it is drawn to a millionth of it.
double decimals_for(double length) { return std::pow(10.0, std::ceil(6.0 - std::log10(length))); }

/// Writes points short: a picture needs no sixteen digits.
class Shorter {
 public:
  explicit Shorter(double length) : places_(decimals_for(length)), per_length_(1e-6 * places_) {}

  double length(double value) const { return round(value, places_); }
  double angle(double value) const { return round(value, 1e6); }
  double curvature(double value) const { return round(value, 1e5 / std::max(per_length_, 1e-12)); }
  Json point(Vec2 p) const { return {length(p.x), length(p.y)}; }
  Json points(const std::vector<Vec2>& list) const {
    Json::array_t array;
    array.reserve(list.size());
    for (const Vec2 p : list) array.push_back(point(p));
    return array;
  }

 private:
  /// A quotient is the number nearest to its decimals, so it is written with these and no more.
  static double round(double value, double places) { return std::round(value * places) / places + 0.0; }

  double places_, per_length_;
};

/// The box around all that a drawing's frames hold, with as much as the rod is long twice more around it: what of an
/// unbounded obstacle lies beyond is never seen.
struct Reach {
  Vec2 low{infinity, infinity}, high{-infinity, -infinity};

  Reach(const Json& frames, double length) {
    for (const Json& frame : frames) {
      for (const Json& rod : frame["rods"]) {
        for (const Json& p : rod["line"]) add({p[0], p[1]});
      }
      if (!frame.contains("target") || !frame["target"].contains("position")) continue;
      const Json& p = frame["target"]["position"];
      add({p[0], p[1]});
    }
    if (low.x > high.x) add({});
    low = (1.0 / length) * low - Vec2{2.0, 2.0};
    high = (1.0 / length) * high + Vec2{2.0, 2.0};
  }
  void add(Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

RawValue raw_of(const Json& value) {
  if (value.is_array()) {
    RawValue::List list;
    list.reserve(value.size());
    for (const Json& entry : value) list.push_back(raw_of(entry));
    return {std::move(list)};
  }
  if (value.is_boolean()) return {value.get<bool>()};
  if (value.is_number_integer()) return {value.get<std::int64_t>()};
  if (value.is_number()) return {value.get<double>()};
  return {value.is_string() ? value.get<std::string>() : value.dump()};
}

/// Makes the document.
class Draft {
 public:
  Draft(const Reader& result, double length, plugins::Registry& registry)
      : result_(result), registry_(registry), length_(length), shorter_(length) {}

  Json document() {
    const LengthUnit unit = unit_for(length_);
    Json drawing;
    drawing["drawing"] = 2;
    drawing["title"] = result_.has("title") ? result_.member("title").text() : "";
    drawing["problem"] = problem();
    drawing["length"] = length_;
    drawing["length_unit"] = {{"name", unit.name}, {"size", unit.size}};
    drawing["obstacles"] = Json::array();
    read_friction();
    if (const auto gravity = result_.optional("gravity")) drawing["gravity"] = {gravity->point().x, gravity->point().y};
    if (result_.has("start_backbone")) {
      drawing["start"] = shorter_.points(line_of(backbone_of(result_, "start_backbone")));
    }
    Json frames = Json::array();
    if (result_.has("cases")) {
      const auto cases = result_.member("cases").list();
      for (const Reader& one : cases) frames.push_back(case_frame(one, cases.size()));
    } else if (result_.has("steps")) {
      const auto steps = result_.member("steps").list();
      drawing["ordered"] = true;
      for (std::size_t i = 0; i < steps.size(); ++i) {
        frames.push_back(plan_frame(steps[i], fmt::format("step {} of {}", i + 1, steps.size())));
        if (frames.back().contains("target"))
          drawing["path"].push_back(frames.back()["target"].value("position", Json()));
      }
      add_loops(drawing, steps);
    } else {
      add_snaps(frames);
      frames.push_back(plan_frame(result_, problem() == "execute" ? "at rest" : ""));
    }
    add_obstacles(drawing, frames, Reach(frames, length_));
    drawing["frames"] = std::move(frames);
    drawing["notes"] = notes_;
    return drawing;
  }

 private:
  std::string problem() const { return result_.has("problem") ? result_.member("problem").text() : "pose"; }

  /// The coefficients of the scene's obstacles, or of a grasp's object.
  void read_friction() {
    const auto grasp = result_.optional("grasp");
    if (const auto friction = grasp ? grasp->optional("friction") : std::nullopt) {
      frictions_ = {friction->member("coefficient").real()};
      return;
    }
    const auto obstacles = result_.optional("obstacles");
    if (!obstacles) return;
    for (const Reader& entry : obstacles->list()) {
      const auto coefficient = entry.optional("friction");
      frictions_.push_back(coefficient ? coefficient->real() : 0.0);
    }
  }

  /// Outlines of the scene's obstacles: those that move in the frames that have them, which name them and their places.
  void add_obstacles(Json& drawing, Json& frames, const Reach& reach) {
    if (problem() == "grasp" || problem() == "estimate") return;
    if (!result_.has("obstacles")) {
      notes_.push_back("the result does not say which obstacles there were, so none are drawn");
      return;
    }
    std::set<std::string> moving;
    for (const Json& frame : frames) {
      for (const Json& moved : frame.value("moved", Json::array())) moving.insert(moved["obstacle"]);
    }
    for (const Reader& entry : result_.member("obstacles").list()) {
      const std::string name = entry.member("name").text();
      if (!moving.contains(name)) {
        add_outline(drawing["obstacles"], entry, Json::object(), reach);
        continue;
      }
      for (Json& frame : frames) {
        for (const Json& moved : frame.value("moved", Json::array())) {
          if (moved["obstacle"] == name) add_outline(frame["obstacles"], entry, moved, reach);
        }
      }
    }
    for (Json& frame : frames) frame.erase("moved");
  }

  /// An obstacle, which is made as the scene made it. `moved`: its `shift` and `turn` if they are others.
  void add_outline(Json& to, const Reader& entry, const Json& moved, const Reach& reach) {
    Scene scene;
    scene.rod.segments = {{length_, 1.0}};
    const auto mode = result_.optional("contact_mode");
    const bool ignored = mode && mode->text() == "ignore" && problem() != "execute";
    ObstacleSpec& spec = scene.obstacles.emplace_back();
    spec.name = entry.member("name").text();
    spec.shape = entry.member("shape").text();
    for (const auto& [name, value] : entry.json().items()) {
      if (!std::set<std::string>{"name", "shape", "friction", "shift", "turn"}.contains(name))
        spec.options[name] = raw_of(value);
    }
    const Json& turn = moved.contains("turn") ? moved["turn"] : entry.json().value("turn", Json(0.0));
    const Json& shift = moved.contains("shift") ? moved["shift"] : entry.json().value("shift", Json{0.0, 0.0});
    spec.place = {turn.get<double>(), {shift[0].get<double>(), shift[1].get<double>()}};
    try {
      const auto made = plugins::make_obstacles(registry_, scene);
      std::vector<ClosedLine> outlines = outlines_of(*made[0], reach.low, reach.high);
      if (outlines.empty()) return;
      for (ClosedLine& line : outlines) {
        for (Vec2& p : line) p = length_ * p;
      }
      to.push_back(shape(spec.name, outlines));
      if (ignored) to.back()["ignored"] = true;
    } catch (const Error& error) {
      notes_.push_back(fmt::format("'{}' is not drawn: {}", spec.name, error.what()));
    }
  }

  Json shape(const std::string& name, const std::vector<ClosedLine>& outlines) const {
    Json json{{"name", name}, {"outlines", Json::array()}};
    for (const ClosedLine& line : outlines) json["outlines"].push_back(shorter_.points(line));
    return json;
  }
  Json object(Vec2 center, double radius) const { return shape("object", {circle_outline(center, radius)}); }

  Json rod(const std::string& name, const std::vector<BackbonePoint>& backbone, const BodyRadius& radius) const {
    Json::array_t along;
    along.reserve(backbone.size());
    for (const BackbonePoint& p : backbone) {
      along.push_back({shorter_.length(p.s), shorter_.angle(p.angle), shorter_.curvature(p.curvature)});
    }
    Json json{{"name", name}, {"line", shorter_.points(line_of(backbone))}, {"along", std::move(along)}};
    if (radius) json["body"] = shorter_.points(line_of(body_outline(backbone, radius)));
    return json;
  }

  /// Adds a rod and its contacts, if it came to a shape.
  void add_rod(Json& frame, const std::string& name, const Reader& state, const BodyRadius& radius) const {
    const std::vector<BackbonePoint> backbone = backbone_of(state);
    if (!backbone.empty()) frame["rods"].push_back(rod(name, backbone, radius));
    add_contacts(frame, state, backbone, radius);
  }

  /// Adds where the first rod is by two standard deviations, across it.
  void add_band(Json& frame, const Reader& plan) const {
    const auto uncertainty = plan.optional("uncertainty");
    const auto shape = uncertainty ? uncertainty->optional("shape") : std::nullopt;
    if (!shape || frame["rods"].empty()) return;
    const std::vector<BackbonePoint> backbone = backbone_of(plan);
    const BodyRadius body = radius_of(plan);
    std::vector<Vec2> widths{{}};  // arc lengths and what lies beside the rod there
    for (const Reader& entry : shape->list()) {
      const std::vector<double> p = entry.reals();
      if (p.size() != 4) entry.fail("an arc length and three variances");
      const auto at = std::find_if(backbone.begin(), backbone.end(), [&](const auto& b) { return b.s >= p[0]; });
      const double angle = at == backbone.end() ? backbone.back().angle : at->angle;
      const Vec2 n{-std::sin(angle), std::cos(angle)};
      widths.push_back(
          {p[0], 2.0 * std::sqrt(std::max(0.0, n.x * (n.x * p[1] + 2.0 * n.y * p[2]) + n.y * n.y * p[3]))});
    }
    const BodyRadius band = [&](double s) {
      std::size_t i = 1;
      while (i + 1 < widths.size() && widths[i].x < s) ++i;
      if (i == widths.size()) return 0.0;
      const double share = std::clamp((s - widths[i - 1].x) / (widths[i].x - widths[i - 1].x), 0.0, 1.0);
      return (body ? body(s) : 0.0) + widths[i - 1].y + share * (widths[i].y - widths[i - 1].y);
    };
    frame["rods"][0]["band"] = shorter_.points(line_of(body_outline(backbone, band)));
  }

  /// Adds the contacts of a state that have a place.
  void add_contacts(Json& frame, const Reader& state, const std::vector<BackbonePoint>& backbone,
                    const BodyRadius& radius) const {
    for (const Reader& entry : state.member("contacts").list()) {
      const auto point = entry.optional("point");
      const auto normal = entry.optional("normal");
      const auto arc_length = entry.optional("arc_length");
      if (!point || !normal || !arc_length) continue;
      Json contact;
      for (const char* key : {"obstacle", "finger", "state"}) {
        if (const auto value = entry.optional(key)) contact[key] = value->text();
      }
      for (const char* key : {"arc_length", "force", "tangential_force", "gap"}) {
        if (const auto value = entry.optional(key)) contact[key] = value->real();
      }
      if (const auto at_tip = entry.optional("at_tip"); at_tip && at_tip->truth()) contact["at_tip"] = true;
      contact["point"] = {point->point().x, point->point().y};
      contact["normal"] = {normal->point().x, normal->point().y};
      const double depth = radius ? radius(arc_length->real()) : 0.0;
      contact["surface"] = shorter_.point(point->point() - depth * normal->point());
      add_friction(contact, entry);
      if (contact.contains("friction") || contact.contains("tangential_force")) {
        const Vec2 tangent = tangent_at(backbone, arc_length->real(), normal->point());
        contact["tangent"] = {tangent.x, tangent.y};
      }
      frame["contacts"].push_back(std::move(contact));
    }
  }

  void add_friction(Json& contact, const Reader& entry) const {
    const auto index = entry.optional("obstacle_index");
    if (!index || frictions_.empty()) return;
    const int obstacle = index->whole(0, static_cast<int>(frictions_.size()) - 1);
    if (const double friction = frictions_[static_cast<std::size_t>(obstacle)]; friction > 0.0)
      contact["friction"] = friction;
  }

  /// What friction does along a way against the input that varies most, of each obstacle that rubs.
  static void add_loops(Json& drawing, const std::vector<Reader>& steps) {
    std::vector<std::vector<double>> inputs;
    std::vector<std::string> obstacles;
    for (const Reader& step : steps) {
      std::vector<double>& values = inputs.emplace_back();
      if (const auto told = step.optional("inputs")) {
        for (const Reader& input : told->list()) {
          if (const auto value = input.optional("value")) values.push_back(value->real());
        }
      }
      if (values.empty() || values.size() != inputs.front().size()) return;
      for (const Reader& contact : step.member("contacts").list()) {
        if (!contact.has("state") || !contact.has("obstacle")) continue;
        const std::string name = contact.member("obstacle").text();
        if (std::find(obstacles.begin(), obstacles.end(), name) == obstacles.end()) obstacles.push_back(name);
      }
    }
    if (obstacles.empty()) return;
    std::size_t varied = 0;
    double widest = -1.0;
    for (std::size_t i = 0; i < inputs.front().size(); ++i) {
      const auto less = [i](const std::vector<double>& a, const std::vector<double>& b) { return a[i] < b[i]; };
      const auto [low, high] = std::minmax_element(inputs.begin(), inputs.end(), less);
      if ((*high)[i] - (*low)[i] <= widest) continue;
      widest = (*high)[i] - (*low)[i];
      varied = i;
    }
    const Reader input = steps.front().member("inputs").list()[varied];
    const std::string name = fmt::format("{} {}", input.member("kind").text(), varied + 1);
    for (const std::string& obstacle : obstacles) {
      Json points = Json::array();
      for (std::size_t i = 0; i < steps.size(); ++i) {
        double force = 0.0;
        for (const Reader& contact : steps[i].member("contacts").list()) {
          if (!contact.has("state") || contact.member("obstacle").text() != obstacle) continue;
          force += contact.member("tangential_force").real();
        }
        points.push_back({inputs[i][varied], force});
      }
      drawing["loops"].push_back(
          {{"obstacle", obstacle}, {"input", name}, {"unit", input.member("unit").text()}, {"points", points}});
    }
  }

  static Json target_of(const Reader& target) {
    Json json = Json::object();
    if (const auto position = target.optional("position"))
      json["position"] = {position->point().x, position->point().y};
    if (const auto angle = target.optional("angle")) json["angle"] = angle->real();
    return json;
  }

  Json plan_frame(const Reader& plan, const std::string& label) const {
    Json frame{{"label", label}};
    for (const char* key : {"status", "message"}) {
      if (const auto value = plan.optional(key)) frame[key] = value->text();
    }
    if (const auto target = plan.optional("target")) frame["target"] = target_of(*target);
    if (const auto moved = plan.optional("moved_obstacles")) frame["moved"] = moved->json();
    frame["rods"] = Json::array();
    frame["contacts"] = Json::array();
    if (const auto fingers = plan.optional("fingers")) {
      for (const Reader& finger : fingers->list()) {
        add_rod(frame, finger.member("finger").text() + " finger", finger, radius_of(finger));
      }
    } else {
      add_rod(frame, plan.has("grasp") ? "finger" : "rod", plan, radius_of(plan));
      add_band(frame, plan);
    }
    if (const auto grasp = plan.optional("grasp")) add_grasp_to(frame, plan, *grasp);
    if (const auto measured = plan.optional("measured")) frame["measured"] = shorter_.points(points_in(*measured));
    if (const auto states = plan.optional("friction_range")) {
      for (const Reader& state : states->list()) {
        const auto x = state.member("tip").optional("x");
        const auto y = state.member("tip").optional("y");
        if (x && y) frame["tips"].push_back(shorter_.point({x->real(), y->real()}));
      }
    }
    frame["numbers"] = plan_numbers(plan);
    return frame;
  }

  /// The object, the palm, and the mirror image of a finger that stands for both.
  void add_grasp_to(Json& frame, const Reader& plan, const Reader& grasp) const {
    if (const auto held = grasp.optional("object")) {
      frame["obstacles"].push_back(object(held->member("center").point(), held->member("radius").real()));
    }
    const auto friction = grasp.optional("friction");
    const std::vector<Vec2> held = friction ? points_in(friction->member("held_forces")) : std::vector<Vec2>{};
    if (!held.empty()) {
      frame["hold"]["center"] = shorter_.point(grasp.member("object").member("center").point());
      for (const Vec2 force : held) frame["hold"]["forces"].push_back({force.x, force.y});
    }
    const auto palm = grasp.optional("palm");
    if (!palm) return;
    GripperSpec gripper;
    gripper.position = palm->member("position").point();
    gripper.angle = palm->member("angle").real();
    gripper.half_palm = palm->member("half_palm").real();
    frame["palm"] = {shorter_.point(palm_to_world(gripper, {0.0, gripper.half_palm})),
                     shorter_.point(palm_to_world(gripper, {0.0, -gripper.half_palm}))};
    if (plan.has("fingers") || frame["rods"].empty()) return;
    std::vector<BackbonePoint> other = backbone_of(plan);
    for (BackbonePoint& p : other) {
      const Vec2 at = mirrored(gripper, p.position());
      p = {p.s, at.x, at.y, 2.0 * gripper.angle - p.angle, -p.curvature};
    }
    frame["rods"].push_back(rod("other finger", other, radius_of(plan)));
    const auto image_of = [&](const Json& p) { return mirrored(gripper, {p[0], p[1]}); };
    const Vec2 origin = mirrored(gripper, {});
    const Json planned = frame["contacts"];
    for (Json contact : planned) {
      const Vec2 across = image_of(contact["normal"]) - origin;
      contact["normal"] = {across.x, across.y};
      for (const char* key : {"point", "surface"}) {
        const Vec2 image = image_of(contact[key]);
        contact[key] = {image.x, image.y};
      }
      contact["finger"] = "other";
      frame["contacts"].push_back(std::move(contact));
    }
  }

  /// States beside the snaps of an execution, in the order in which they came.
  void add_snaps(Json& frames) const {
    const auto snaps = result_.optional("snaps");
    if (!snaps) return;
    const std::vector<Reader> list = snaps->list();
    for (std::size_t i = 0; i < list.size(); ++i) {
      for (const char* side : {"before", "after"}) {
        const Reader state = list[i].member(side);
        if (state.member("backbone").list().empty()) continue;
        Json frame{{"label", fmt::format("{} snap {} ({})", side, i + 1, list[i].member("kind").text())}};
        frame["rods"] = Json::array();
        frame["contacts"] = Json::array();
        add_rod(frame, "rod", state, radius_of(result_));
        frame["numbers"] = snap_numbers(list[i], state);
        frames.push_back(std::move(frame));
      }
    }
  }

  /// A case of a study: the lines that its figure shows.
  Json case_frame(const Reader& one, std::size_t count) const {
    const auto mode = one.optional("mode");
    Json frame{{"label", fmt::format("case {} of {}{}", one.member("index").whole(0, 100'000'000) + 1, count,
                                     mode ? ": " + mode->text() : "")}};
    for (const char* key : {"status", "message"}) {
      if (const auto value = one.optional(key)) frame[key] = value->text();
    }
    if (const auto target = one.optional("target"); target && target->json().is_array()) {
      frame["target"] = {{"position", {target->point().x, target->point().y}}};
    }
    if (mode && mode->text() == "ignore") frame["ignored"] = true;
    if (const auto moved = one.optional("moved_obstacles")) frame["moved"] = moved->json();
    frame["rods"] = Json::array();
    if (const auto lines = one.optional("lines")) {
      for (const Reader& line : lines->list()) {
        if (!line.list().empty())
          frame["rods"].push_back({{"name", "rod"}, {"line", shorter_.points(points_in(line))}});
      }
    }
    if (const auto path = one.optional("path")) frame["path"] = shorter_.points(points_in(*path));
    if (const auto objects = one.optional("objects")) {
      for (const Reader& entry : objects->list()) {
        const std::vector<double> o = entry.reals();
        if (o.size() != 3) entry.fail("centre and radius of an object");
        frame["obstacles"].push_back(object({o[0], o[1]}, o[2]));
      }
    }
    frame["contacts"] = Json::array();
    if (const auto points = one.optional("contact_points")) {
      for (const Vec2 p : points_in(*points)) frame["contacts"].push_back({{"surface", shorter_.point(p)}});
    }
    frame["numbers"] = case_numbers(one);
    return frame;
  }

  const Reader& result_;
  plugins::Registry& registry_;
  double length_;
  Shorter shorter_;
  std::vector<double> frictions_;
  std::vector<std::string> notes_;
};

}  // namespace

Json drawing_of(const Json& result, const std::string& file, plugins::Registry& registry) {
  const Reader root(result, file, "");
  if (!root.has("cases") && !root.has("steps")) root.member("backbone");
  const double length = length_of(root);
  // Without any shape there is nothing to be drawn to scale.
  return Draft(root, length > 0.0 ? length : 1.0, registry).document();
}

bool has_shape(const Json& drawing) {
  return std::any_of(drawing["frames"].begin(), drawing["frames"].end(),
                     [](const Json& frame) { return !frame["rods"].empty(); });
}

}  // namespace tendril::app

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "result/json_reader.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/result.hpp"
#include "tendril/grasp.hpp"

namespace tendril::app {

namespace {

/// Obstacles that contacts of the scene's results may name.
std::vector<std::string> obstacle_names(const Scene& scene) {
  if (scene.gripper) return {"object"};
  std::vector<std::string> names;
  for (const ObstacleSpec& obstacle : scene.obstacles) names.push_back(obstacle.name);
  return names;
}

/// `length`: of the rod, m.
std::vector<PlannedContact> read_contacts(const Reader& root, const Scene& scene, double length) {
  const std::vector<std::string> names = obstacle_names(scene);
  std::vector<PlannedContact> contacts;
  for (const Reader& entry : root.member("contacts").list()) {
    PlannedContact contact;
    contact.obstacle_name = entry.member("obstacle").text();
    const auto obstacle = std::find(names.begin(), names.end(), contact.obstacle_name);
    contact.arc_length = entry.member("arc_length").real();
    contact.point = entry.member("point").point();
    contact.normal = entry.member("normal").point();
    contact.force = entry.member("force").real();
    contact.gap = entry.member("gap").real();
    if (entry.has("at_tip")) contact.at_tip = entry.member("at_tip").truth();
    if (entry.has("tangential_force")) contact.tangential = entry.member("tangential_force").real();
    if (entry.has("state")) contact.sticks = entry.member("state").text() == "stick";
    if (entry.has("extended")) contact.extended = entry.member("extended").truth();
    if (obstacle == names.end()) continue;
    if (contact.arc_length < 0.0 || contact.arc_length > length * (1.0 + 1e-9)) {
      entry.member("arc_length").fail("an arc length on the rod");
    }
    contact.obstacle = static_cast<int>(obstacle - names.begin());
    contacts.push_back(std::move(contact));
  }
  return contacts;
}

/// Where obstacles of the scene are at a step.
std::vector<MovedObstacle> read_moved_obstacles(const Reader& step, const Scene& scene) {
  std::vector<MovedObstacle> moved;
  const auto given = step.optional("moved_obstacles");
  if (!given) return moved;
  const std::vector<std::string> names = obstacle_names(scene);
  for (const Reader& entry : given->list()) {
    const auto obstacle = std::find(names.begin(), names.end(), entry.member("obstacle").text());
    if (obstacle == names.end()) entry.member("obstacle").fail("the name of an obstacle of the scene");
    const Vec2 shift = entry.member("shift").point();
    moved.push_back({static_cast<int>(obstacle - names.begin()), {entry.member("turn").real(), shift}});
  }
  return moved;
}

/// What a step of a trajectory was planned for.
TargetSpec read_target(const Reader& step, const Scene& scene) {
  TargetSpec wanted;
  wanted.obstacles = read_moved_obstacles(step, scene);
  if (!step.has("target")) return wanted;
  const Reader target = step.member("target");
  if (target.has("position")) wanted.position = target.member("position").point();
  if (target.has("angle")) wanted.angle = target.member("angle").real();
  return wanted;
}

/// What may be moved of a rod, absent where it may not.
RodPlace read_place(const Reader& root) {
  RodPlace place;
  if (root.has("insertion")) place.insertion = root.member("insertion").real();
  if (root.has("base")) {
    const Reader base = root.member("base");
    place.base = {{base.member("x").real(), base.member("y").real()}, base.member("angle").real()};
  }
  return place;
}

/// `length`: of the rod, m; `insertion`: of it that is out of its port.
std::vector<BackbonePoint> read_backbone(const Reader& root, double length, std::optional<double> insertion = {}) {
  std::vector<BackbonePoint> backbone;
  for (const Reader& entry : root.member("backbone").list()) {
    const std::vector<double> values = entry.reals();
    if (values.size() != 5) entry.fail("five numbers: s, x, y, angle, curvature");
    if (!backbone.empty() && values[0] < backbone.back().s) entry.fail("arc lengths in ascending order");
    backbone.push_back({values[0], values[1], values[2], values[3], values[4]});
  }
  // A plan for another rod is no start: its shape would have to be stretched.
  const double first = insertion ? length - *insertion : 0.0;
  const bool spans = backbone.size() >= 2 && std::abs(backbone.front().s - first) <= 1e-9 * length &&
                     std::abs(backbone.back().s - length) <= 1e-9 * length;
  if (!spans) {
    root.member("backbone").fail(fmt::format("a backbone from {} m to the rod's length, {} m", first, length));
  }
  return backbone;
}

void read_tip(const Reader& root, double& x, double& y, double& turn) {
  const Reader tip = root.member("tip");
  x = tip.member("x").real();
  y = tip.member("y").real();
  turn = tip.member("angle").real();
}

/// The moments of a rod, which must have one for each of its actuators.
std::vector<double> read_moments(const Reader& root, const RodSpec& rod, const std::string& file) {
  std::vector<double> moments = root.member("moments").reals();
  if (moments.size() != rod.actuators.size()) {
    throw InputError(fmt::format("{}: found {} moments, expected one for each of the scene's {} actuators", file,
                                 moments.size(), rod.actuators.size()));
  }
  return moments;
}

/// What held lengths need: the turns (Plan::turns) of the actuators of a rod, which are `first` and behind it in the
/// result. Empty where it does not tell them.
std::vector<double> read_turns(const Reader& root, const RodSpec& rod, std::size_t first) {
  std::vector<double> turns(rod.actuators.size(), 0.0);
  if (!root.has("inputs")) return {};
  const std::vector<Reader> inputs = root.member("inputs").list();
  for (std::size_t a = 0; a < turns.size() && first + a < inputs.size(); ++a) {
    if (!rod.actuators[a].by_length) continue;
    turns[a] = inputs[first + a].member("shortening").real() / rod.actuators[a].largest_offset();
  }
  return turns;
}

/// Both fingers of a plan.
void read_fingers(const Reader& root, const Scene& scene, const std::string& file, Plan& plan) {
  const std::vector<Reader> fingers = root.member("fingers").list();
  if (fingers.size() != 2) root.member("fingers").fail("the upper and the lower finger");
  const RodSpec upper = finger_of(scene, FingerName::upper).rod;
  const RodSpec lower = finger_of(scene, FingerName::lower).rod;
  plan.moments = read_moments(fingers[0], upper, file);
  plan.turns = read_turns(root, upper, 0);
  plan.coordinates = fingers[0].member("coordinates").reals();
  plan.contacts = read_contacts(fingers[0], scene, upper.length());
  plan.backbone = read_backbone(fingers[0], upper.length());
  plan.place = read_place(fingers[0]);
  read_tip(fingers[0], plan.tip_x, plan.tip_y, plan.tip_angle);
  FingerPlan& below = plan.grasp->lower.emplace();
  below.moments = read_moments(fingers[1], lower, file);
  below.turns = read_turns(root, lower, upper.actuators.size());
  below.coordinates = fingers[1].member("coordinates").reals();
  below.contacts = read_contacts(fingers[1], scene, lower.length());
  below.backbone = read_backbone(fingers[1], lower.length());
  below.place = read_place(fingers[1]);
  read_tip(fingers[1], below.tip_x, below.tip_y, below.tip_angle);
}

/// A plan as a start for `scene`.
Plan read_plan(const Reader& root, const Scene& scene, const std::string& file) {
  Plan plan;
  const Reader coordinates = root.member("coordinates");
  plan.coordinates_name = coordinates.member("name").text();
  plan.order = coordinates.member("order").whole(0, 1'000'000);
  plan.split_at_contact = coordinates.member("split_at_contact").truth();
  if (scene.gripper) plan.grasp.emplace().palm_distance = root.member("palm_distance").real();
  if (plans_both_fingers(scene)) {
    read_fingers(root, scene, file, plan);
    return plan;
  }
  plan.coordinates = coordinates.member("values").reals();
  plan.moments = read_moments(root, scene.rod, file);
  plan.place = read_place(root);
  plan.turns = read_turns(root, scene.rod, 0);
  read_tip(root, plan.tip_x, plan.tip_y, plan.tip_angle);
  plan.contacts = read_contacts(root, scene, scene.rod.length());
  plan.backbone = read_backbone(root, scene.rod.length(), plan.place.insertion);
  return plan;
}

}  // namespace

Json parse_result(const std::string& text, const std::string& file, const std::string& what) {
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded())
    throw InputError(what + " '" + file + "' is not JSON, expected a result of 'tendril plan --json'");
  if (const int schema = Reader(json, file, "").member("schema").whole(0, 1'000'000); schema != 1) {
    throw InputError(fmt::format("{}: found schema {}, expected 1", file, schema));
  }
  return json;
}

std::vector<TrajectoryStep> parse_steps(const std::string& text, const std::string& file, const Scene& scene) {
  const Json json = Json::parse(text, nullptr, false);
  const Reader root(json, file, "");
  std::vector<TrajectoryStep> steps;
  if (!root.has("steps")) return steps;
  if (scene.problem == ProblemKind::grasp) root.member("steps").fail("the result of a grasp");
  for (const Reader& entry : root.member("steps").list()) {
    TrajectoryStep& step = steps.emplace_back();
    step.plan.moments = read_moments(entry, scene.rod, file);
    step.plan.place = read_place(entry);
    step.plan.turns = read_turns(entry, scene.rod, 0);
    step.target = read_target(entry, scene);
  }
  if (steps.empty()) root.member("steps").fail("at least one step");
  return steps;
}

Plan read_start(const std::filesystem::path& path, const Scene& scene, const std::string& what) {
  return parse_start(read_input(path, what), path.string(), scene, what);
}

Plan parse_start(const std::string& text, const std::string& file, const Scene& scene, const std::string& what) {
  const Json json = parse_result(text, file, what);
  return read_plan(Reader(json, file, ""), scene, file);
}

JudgedPlan parse_judged(const std::string& text, const std::string& file, const Scene& scene,
                        const std::optional<int>& step) {
  const Json json = parse_result(text, file, "plan");
  const Reader whole(json, file, "");
  if (!step && whole.has("steps")) whole.member("steps").fail("one plan, or which step of these is meant");
  if (step && !whole.has("steps")) whole.fail("the result of a trajectory, of which a step is asked for");
  const std::vector<Reader> steps = step ? whole.member("steps").list() : std::vector<Reader>{whole};
  const auto index = static_cast<std::size_t>(step.value_or(1) - 1);
  if (index >= steps.size()) whole.member("steps").fail(fmt::format("step {} among its {}", *step, steps.size()));
  const Reader& root = steps[index];
  const std::string method = root.has("method") ? root.member("method").text() : "";
  JudgedPlan judged{read_plan(root, scene, file), method == to_string(StepMethod::executed) ||
                                                      root.member("problem").text() == to_string(ProblemKind::execute)};
  if (!method.empty()) judged.step = read_target(root, scene);
  if (root.member("status").text() == to_string(PlanStatus::solved)) judged.plan.status = PlanStatus::solved;
  const Reader certificate = root.member("certificate");
  if (certificate.has("stability")) judged.plan.certificate.stability = certificate.member("stability").real();
  return judged;
}

}  // namespace tendril::app

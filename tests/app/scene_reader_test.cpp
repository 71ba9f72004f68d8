#include "tendril/app/scene_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "command.hpp"
#include "support/contains.hpp"
#include "support/print.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app::test {
namespace {

Scene read(const std::string& text) { return read_scene(Document::parse(text, "s.toml"), std::make_shared<Units>()); }

std::string refusal_of(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// What the table of keys says of a key's default.
std::string default_text(const std::string& table_name, const std::string& key_name) {
  for (const KeySpec& table : scene_keys()) {
    if (table.name != table_name) continue;
    for (const KeySpec& key : table.keys) {
      if (key.name == key_name) return key.default_text;
    }
  }
  return "no such key";
}

TEST(SceneReader, ReadsTheBracedArm) {
  const Scene scene = read_scene(Document::read(scene_path("brace.toml")), std::make_shared<Units>());
  EXPECT_EQ(scene.title, "Brace on a peg");
  EXPECT_EQ(scene.problem, ProblemKind::pose);
  ASSERT_TRUE(scene.gravity);
  EXPECT_EQ(*scene.gravity, (Vec2{0.0, -9.81}));
  ASSERT_EQ(scene.rod.segments.size(), 1U);
  EXPECT_DOUBLE_EQ(scene.rod.segments[0].length, 0.1);
  EXPECT_DOUBLE_EQ(scene.rod.segments[0].bending_stiffness, 4.9e-4);
  EXPECT_DOUBLE_EQ(scene.rod.segments[0].linear_density, 0.084);
  ASSERT_EQ(scene.rod.actuators.size(), 1U);
  EXPECT_EQ(scene.rod.actuators[0].from, 0.0);
  EXPECT_DOUBLE_EQ(scene.rod.actuators[0].to, 0.1);
  EXPECT_DOUBLE_EQ(scene.rod.actuators[0].minimum, -2.5e-3);
  EXPECT_DOUBLE_EQ(scene.rod.actuators[0].maximum, 2.5e-3);
  EXPECT_EQ(scene.coordinates.plugin, "legendre");
  EXPECT_TRUE(scene.coordinates.split_at_contact);
  EXPECT_EQ(std::get<std::int64_t>(scene.coordinates.options.at("order").value), 6);
  EXPECT_EQ(scene.coordinates.options.at("order").position.line, 15);
  EXPECT_EQ(scene.start_tip_angle, 0.5);
  ASSERT_EQ(scene.obstacles.size(), 1U);
  EXPECT_EQ(scene.obstacles[0].name, "obstacle 1");
  EXPECT_EQ(scene.obstacles[0].shape, "circle");
  EXPECT_EQ(std::get<std::string>(scene.obstacles[0].options.at("radius").value), "8 mm");
  EXPECT_EQ(scene.contact.mode, ContactModeName::allow);
  EXPECT_EQ(scene.contact.max_force, 1.0);
  ASSERT_TRUE(scene.target.position);
  EXPECT_DOUBLE_EQ(scene.target.position->x, 0.097);
  EXPECT_FALSE(scene.target.angle);
  ASSERT_EQ(scene.objectives.size(), 2U);
  EXPECT_EQ(scene.objectives[0].plugin, "tip_pose");
  EXPECT_EQ(scene.objectives[0].weight, 100.0);
  EXPECT_EQ(scene.solver.plugin, TENDRIL_TEST_SOLVER);
}

TEST(SceneReader, ReadsEveryOtherKey) {
  const Scene scene = read(R"(
    [rod]
    base = {position = ["1 m", 2], angle = "90 deg"}
    [[rod.segment]]
    length = 0.3
    bending_stiffness = 2
    rest_curvature = "5 1/m"
    [[rod.segment]]
    length = "10 cm"
    bending_stiffness = 1
    linear_density = 0
    [[rod.actuator]]
    from = 0.1
    to = 0.3
    min = "-1 N m"
    moment_per_pressure = "2 N mm/kPa"
    [tip_load]
    mass = "20 g"
    force = [0, "-1 N"]
    [contact]
    mode = "require"
    min_force = "0.1 N"
    count = 2
    treatment = "fischer_burmeister"
    beta = 3
    check_points = 20
    [target]
    angle = "1 rad"
    [solver]
    tolerance = 1e-8
    time_limit = "1 min"
    max_iterations = 7
    [solver.options]
    mu_init = 0.1
    )");
  EXPECT_EQ(scene.rod.base_position, (Vec2{1.0, 2.0}));
  EXPECT_DOUBLE_EQ(scene.rod.base_angle, std::numbers::pi / 2.0);
  ASSERT_EQ(scene.rod.segments.size(), 2U);
  EXPECT_EQ(scene.rod.segments[0].rest_curvature, 5.0);
  EXPECT_DOUBLE_EQ(scene.rod.segments[1].length, 0.1);
  EXPECT_EQ(scene.rod.actuators[0].minimum, -1.0);
  EXPECT_EQ(scene.rod.actuators[0].maximum, infinity);
  EXPECT_DOUBLE_EQ(scene.rod.actuators[0].moment_per_pressure, 2e-6);
  EXPECT_DOUBLE_EQ(scene.tip_load.mass, 0.02);
  EXPECT_EQ(scene.tip_load.force, (Vec2{0.0, -1.0}));
  EXPECT_EQ(scene.contact.mode, ContactModeName::require);
  EXPECT_EQ(scene.contact.min_force, 0.1);
  EXPECT_EQ(scene.contact.max_force, infinity);
  EXPECT_EQ(scene.contact.count, 2);
  EXPECT_EQ(scene.contact.treatment, Treatment::fischer_burmeister);
  EXPECT_EQ(scene.contact.beta, 3.0);
  EXPECT_EQ(scene.contact.check_points, 20);
  EXPECT_EQ(scene.target.angle, 1.0);
  EXPECT_EQ(scene.solver.tolerance, 1e-8);
  EXPECT_EQ(scene.solver.time_limit, 60.0);
  EXPECT_EQ(scene.solver.max_iterations, 7);
  EXPECT_EQ(std::get<double>(scene.solver.options.at("mu_init").value), 0.1);
  EXPECT_FALSE(scene.gravity);
}

// The table of keys says what holds if a key is absent. Plugins have their default from the reader, since core knows
// none by name; for all else Scene's own initial values are what really holds.
TEST(SceneReader, DefaultsAreThoseOfTheScene) {
  const Scene scene = read("[rod]\nlength = 1\nbending_stiffness = 1\n");
  const Scene plain;
  EXPECT_EQ(scene.coordinates.plugin, "legendre");
  EXPECT_EQ(scene.solver.plugin, "nlopt");
  EXPECT_EQ(default_text("coordinates", "plugin"), scene.coordinates.plugin);
  EXPECT_EQ(default_text("coordinates", "split_at_contact"), plain.coordinates.split_at_contact ? "true" : "false");
  EXPECT_EQ(default_text("solver", "plugin"), scene.solver.plugin);
  EXPECT_EQ(std::stod(default_text("solver", "time_limit")), plain.solver.time_limit);
  EXPECT_EQ(std::stod(default_text("solver", "tolerance")), plain.solver.tolerance);
  EXPECT_EQ(std::stoi(default_text("solver", "max_iterations")), plain.solver.max_iterations);
  EXPECT_EQ(default_text("contact", "mode"), to_string(plain.contact.mode));
  EXPECT_EQ(default_text("contact", "treatment"), to_string(plain.contact.treatment));
  EXPECT_EQ(std::stoi(default_text("contact", "count")), plain.contact.count);
  EXPECT_EQ(std::stod(default_text("contact", "beta")), plain.contact.beta);
  EXPECT_EQ(std::stoi(default_text("contact", "check_points")), plain.contact.check_points);
  EXPECT_EQ(std::stod(default_text("contact", "min_force")), plain.contact.min_force);
  EXPECT_EQ(std::stod(default_text("tip_load", "mass")), plain.tip_load.mass);
  EXPECT_EQ(std::stod(default_text("start", "tip_angle")), plain.start_tip_angle);
  EXPECT_EQ(std::stod(default_text("objective", "weight")), ObjectiveSpec{}.weight);
  EXPECT_EQ(std::stod(default_text("gripper", "finger_angle")), GripperSpec{}.finger_angle);
  EXPECT_EQ(std::stod(default_text("gripper", "angle")), GripperSpec{}.angle);
  EXPECT_EQ(default_text("gripper", "balance"), GripperSpec{}.exact_balance ? "exact" : "objective");
  EXPECT_EQ(std::stoi(default_text("trajectory", "replan_every")), plain.trajectory.replan_every);
  EXPECT_EQ(default_text("trajectory", "cold_starts"), plain.trajectory.cold_starts ? "true" : "false");
}

TEST(SceneReader, DescribesEveryKey) {
  const auto visit = [](const auto& self, const std::vector<KeySpec>& keys) -> void {
    for (const KeySpec& key : keys) {
      EXPECT_FALSE(key.description.empty()) << key.name;
      self(self, key.keys);
    }
  };
  visit(visit, scene_keys());
}

// A pressure that bends to the right makes negative moments, so that the largest one is the smallest moment.
TEST(SceneReader, TurnsLimitsOfPressuresIntoLimitsOfMoments) {
  const auto actuator = [](const std::string& per_pressure) {
    return read(
               "[rod]\nlength = 1\nbending_stiffness = 1\n[[rod.actuator]]\nmin_pressure = \"1 kPa\"\n"
               "max_pressure = \"30 kPa\"\nmoment_per_pressure = " +
               per_pressure + '\n')
        .rod.actuators.at(0);
  };
  EXPECT_DOUBLE_EQ(actuator("2e-6").minimum, 2e-3);
  EXPECT_DOUBLE_EQ(actuator("2e-6").maximum, 6e-2);
  EXPECT_DOUBLE_EQ(actuator("-2e-6").minimum, -6e-2);
  EXPECT_DOUBLE_EQ(actuator("-2e-6").maximum, -2e-3);
  const ActuatorSpec law = actuator("[\"-2 N mm/kPa\", 0, \"-1 N mm/kPa^3\", 0]");
  EXPECT_EQ(law.more_moment_per_pressure.size(), 2U);
  EXPECT_DOUBLE_EQ(law.minimum, -(6e-2 + 27.0));
  EXPECT_DOUBLE_EQ(law.maximum, -3e-3);
  EXPECT_EQ(law.least_pressure, 1e3);
  EXPECT_EQ(law.most_pressure, 3e4);
}

TEST(SceneReader, TensionsMakeTheMomentsOfTheirLaw) {
  const auto tendon = [](const std::string& more) {
    return read("[rod]\nlength = 1\nbending_stiffness = 1\n[[rod.actuator]]\nkind = \"tendon\"\noffset = \"-8 mm\"\n" +
                more)
        .rod.actuators.at(0);
  };
  const ActuatorSpec law = tendon("max = \"3 N\"\nmoment_per_tension = [\"-7 N mm/N\", 0, \"-1 N mm/N^3\"]\n");
  EXPECT_DOUBLE_EQ(law.minimum, -(21e-3 + 27e-3));
  EXPECT_EQ(law.maximum, 0.0);
  EXPECT_DOUBLE_EQ(law.moment_of(2.0), -(14e-3 + 8e-3));
  EXPECT_NEAR(law.input_of(law.moment_of(2.0)), 2.0, 1e-12);
  EXPECT_EQ(law.input(), ActuatorKind::tendon);
  const ActuatorSpec share = tendon("moment_per_tension = -0.006\nlimit = \"2 N\"\n");
  EXPECT_DOUBLE_EQ(share.moment_of(1.0), -6e-3);
  EXPECT_DOUBLE_EQ(share.minimum, -12e-3);
  // Told its length it keeps the law of its tension.
  const ActuatorSpec spool =
      tendon("control = \"length\"\nlimit = \"5 mm\"\nmax_tension = \"2 N\"\nmoment_per_tension = [-7e-3, -1e-3]\n");
  EXPECT_DOUBLE_EQ(spool.minimum, -18e-3);
  EXPECT_DOUBLE_EQ(spool.most_shortening, 5e-3);
  // Drawn into a port so far that its lever is half as long it makes half the moments.
  RodSpec rod;
  rod.segments = {SegmentSpec{.length = 1.0, .bending_stiffness = 1.0}};
  rod.actuators = {law};
  rod.actuators[0].offset = {{0.0, -8e-3}, {1.0, 0.0}};
  rod.actuators[0].to = 1.0;
  const ActuatorSpec cut = out_of_port(rod, 0.5).actuators.at(0);
  EXPECT_NEAR(cut.moment_of(2.0), 0.5 * law.moment_of(2.0), 1e-15);
  EXPECT_NEAR(cut.minimum, 0.5 * law.minimum, 1e-15);
}

TEST(SceneReader, SettingsReachTheEntryThatTheyNumber) {
  const std::string segment = "[[rod.segment]]\nlength = 1\nbending_stiffness = 1\n";
  Document document = Document::parse(segment + segment + segment, "s.toml");
  document.apply({{"", "rod.segment.0.length", "10"}, {"", "rod.segment.2.length", "30"}});
  const Scene scene = read_scene(document, std::make_shared<Units>());
  ASSERT_EQ(scene.rod.segments.size(), 3U);
  EXPECT_EQ(scene.rod.segments[0].length, 10.0);
  EXPECT_EQ(scene.rod.segments[1].length, 1.0);
  EXPECT_EQ(scene.rod.segments[2].length, 30.0);
}

/// A value that a key of this type never takes, and how far behind its beginning what is wrong with it stands.
struct WrongValue {
  std::string text;
  int column = 0;
};

/// No key of a scene is a temperature.
std::vector<WrongValue> wrong_values(const KeySpec& key) {
  const bool excluded = key.minimum_excluded;
  const std::string low =
      std::isfinite(key.minimum) ? std::to_string(excluded ? key.minimum : key.minimum - 1.0) : "nan";
  switch (key.type) {
    case KeyType::text:
      if (!key.choices.empty()) return {{"3"}, {"\"no such word\""}};
      return {{"3"}};
    case KeyType::boolean:
      return {{"1"}, {"\"true\""}};
    case KeyType::integer:
      return {{"1.5"}, {"\"1\""}, {std::to_string(static_cast<int>(key.minimum) - 1)}};
    case KeyType::quantity:
      return {{"\"1 K\""}, {"true"}, {"[1]"}, {low}};
    case KeyType::point:
      return {{"[\"1 K\", 0]", 1}, {"[0, \"1 K\"]", 4}, {"[0]"}, {"3"}};
    case KeyType::texts:
      if (key.choices.empty()) return {{"[3]", 1}, {"[]"}};
      return {{"[\"no such word\"]", 1}, {"[3]", 1}, {"[]"}};
    case KeyType::quantities:
      return {{"[\"1 K\"]", 1}, {'[' + low + ']', 1}, {"3"}};
    case KeyType::ends:
      return {{"\"1 K\""}, {"[\"1 K\", 1]", 1}, {"[1]"}, {low}};
    case KeyType::points:
      return {{"[[\"1 K\", 0]]", 2}, {"[[0]]", 1}, {"[]"}};
    case KeyType::targets:
      return {{"[[\"1 K\", 0]]", 2}, {"{x = [\"1 K\"], y = [0]}", 6}, {"{x = [0]}"}, {"3"}};
    case KeyType::law:
      return {{"\"1 K\""}, {"true"}, {"[]"}, {"[1, \"1 K\"]", 4}, {"[1, 1, 1, 1, 1, 1]"}, {low}};
    case KeyType::offsets:
      return {{"\"1 K\""}, {"true"}, {"[1]"}, {"[1, \"1 K\"]", 4}, {"[[0, 1], [1]]", 9}, {low}};
    case KeyType::table:
    case KeyType::tables:
    case KeyType::options:
      return {{"3"}};
  }
  return {};
}

/// A value that a required key takes.
std::string good_value(const KeySpec& key) {
  if (key.type == KeyType::quantity) return "1";
  return key.choices.empty() ? "\"word\"" : '"' + key.choices.front() + '"';
}

/// What follows a key: a scene without a rod would be refused for that first.
std::string rest(const std::string& path, const KeySpec& key) {
  const bool of_rod = path.starts_with("rod") || (path.empty() && key.name == "rod");
  return of_rod ? "" : "[rod]\n";
}

/// Lines for the keys that a table needs beside this one.
std::string needed_beside(const std::vector<KeySpec>& keys, const KeySpec& key) {
  std::string lines;
  for (const KeySpec& other : keys) {
    if (other.required && other.name != key.name && other.type != KeyType::table)
      lines += other.name + " = " + good_value(other) + '\n';
  }
  return lines;
}

/// Every key below a table, wrong in every way, and misspelt. `path`: of the table; `heads`: lines that begin it.
void expect_refused_keys(const std::vector<KeySpec>& keys, const std::string& path, const std::string& head) {
  for (const KeySpec& key : keys) {
    const std::string before = head + needed_beside(keys, key);
    const auto line = std::to_string(std::count(before.begin(), before.end(), '\n') + 1);
    for (const WrongValue& wrong : wrong_values(key)) {
      const std::string text = before + key.name + " = " + wrong.text + '\n' + rest(path, key);
      const int column = static_cast<int>(key.name.size()) + 4 + wrong.column;
      const std::string place = "s.toml:" + line + ':' + std::to_string(column) + ": found ";
      const std::string message = refusal_of(text);
      EXPECT_TRUE(message.starts_with(place)) << "expected " << place << "..., was: " << message << "\n" << text;
    }
    const bool is_table = key.type == KeyType::table || key.type == KeyType::tables;
    if (is_table && !key.keys.empty()) {
      const std::string inner = (path.empty() ? "" : path + '.') + key.name;
      const std::string brackets = key.type == KeyType::tables ? "[[" + inner + "]]\n" : '[' + inner + "]\n";
      expect_refused_keys(key.keys, inner, before + brackets);
    }
  }
}

TEST(SceneReader, RefusesEveryKeyWithAWrongValueAtItsPlace) { expect_refused_keys(scene_keys(), "", ""); }

TEST(SceneReader, TakesWholeNumbersThatAreWrittenAsRealOnes) {
  int seen = 0;
  const auto visit = [&](const auto& self, const std::vector<KeySpec>& keys, const std::string& path,
                         const std::string& head) -> void {
    for (const KeySpec& key : keys) {
      const std::string before = head + needed_beside(keys, key);
      if (key.type == KeyType::integer) {
        // What follows a key may be missing, as it may be behind 2.
        const auto with = [&](const char* value) {
          return message_of(before + key.name + " = " + value + '\n' + rest(path, key));
        };
        EXPECT_EQ(with("2.0"), with("2")) << path << '.' << key.name;
        EXPECT_EQ(with("2.0").find("whole number"), std::string::npos) << path << '.' << key.name;
        ++seen;
      }
      if (key.type != KeyType::table && key.type != KeyType::tables) continue;
      const std::string inner = (path.empty() ? "" : path + '.') + key.name;
      self(self, key.keys, inner, before + (key.type == KeyType::tables ? "[[" + inner + "]]\n" : '[' + inner + "]\n"));
    }
  };
  visit(visit, scene_keys(), "", "");
  EXPECT_GE(seen, 11);
}

/// The keys of tables that take no others, each with its last letter twice.
TEST(SceneReader, KnowsWhatAMisspeltKeyWasMeantToBe) {
  const auto visit = [](const auto& self, const std::vector<KeySpec>& keys, const std::string& path,
                        const std::string& head, bool takes_options) -> void {
    for (const KeySpec& key : keys) {
      const std::string misspelt = key.name + key.name.back();
      const std::string text = head + misspelt + " = 1\n" + rest(path, key);
      const std::string message = refusal_of(text);
      if (!takes_options) {
        const std::string place = "s.toml:" + std::to_string(std::count(head.begin(), head.end(), '\n') + 1) +
                                  ":1: found the key '" + misspelt + "'";
        EXPECT_TRUE(message.starts_with(place)) << "expected " << place << "..., was: " << message;
        EXPECT_NE(message.find("; did you mean '"), std::string::npos) << message;
      }
      if (key.type != KeyType::table && key.type != KeyType::tables) continue;
      const std::string inner = (path.empty() ? "" : path + '.') + key.name;
      const std::string brackets = key.type == KeyType::tables ? "[[" + inner + "]]\n" : '[' + inner + "]\n";
      self(self, key.keys, inner, head + needed_beside(keys, key) + brackets, key.takes_options);
    }
  };
  visit(visit, scene_keys(), "", "", false);
}

class SceneReaderRefuses : public testing::TestWithParam<BadScene> {};

TEST_P(SceneReaderRefuses, WithThePlace) {
  const std::string message = refusal_of(brace_with(GetParam().old_text, GetParam().new_text));
  EXPECT_TRUE(contains_text(message, GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, SceneReaderRefuses,
    testing::Values(
        BadScene{"length =", "lenght =",
                 "s.toml:6:1: found the key 'lenght', which [rod] does not have; did you mean 'length'?"},
        BadScene{"[contact]", "[contct]",
                 "s.toml:26:2: found the key 'contct', which a scene does not have; did you mean 'contact'?"},
        BadScene{"\"100 mm\"", "nan", "s.toml:6:10: found the number nan"},
        BadScene{"\"100 mm\"", "inf", "s.toml:6:10: found the number inf"},
        BadScene{"\"100 mm\"", "\"0 mm\"", "s.toml:6:10: found \"0 mm\", expected a length greater than 0"},
        BadScene{"\"100 mm\"", "-0.1", "s.toml:6:10: found the number -0.1, expected a length greater than 0"},
        BadScene{"\"100 mm\"", "\"100 N\"", "s.toml:6:10: found \"100 N\", whose unit is not that of a length"},
        BadScene{"\"100 mm\"", "[1, 2]", "s.toml:6:10: found a list of 2 entries, expected a length"},
        BadScene{"\"100 mm\"", "1979-05-27", "s.toml:6:10: found a date, expected a length"},
        BadScene{"\"100 mm\"", "true", "s.toml:6:10: found true, expected a length"},
        BadScene{"length = \"100 mm\"\n", "", "s.toml:5:1: [rod] has no 'length'"},
        BadScene{"\"84 g/m\"", "\"-84 g/m\"", "s.toml:8:18: found \"-84 g/m\", expected a linear density not below 0"},
        BadScene{"\"2.5 N mm\"", "\"2.5 Nmm\"", "s.toml:11:9: found \"2.5 Nmm\""},
        BadScene{"limit = \"2.5 N mm\"", "min = 1\nmax = -1", "s.toml:11:7: found min 1 N m above max -1 N m"},
        BadScene{"limit = \"2.5 N mm\"", "min = 1\nlimit = 1", "found 'limit' beside 'min' or 'max'"},
        BadScene{"limit = \"2.5 N mm\"", "limit = 1\nfrom = 0.1", "s.toml:12:8: found an actuator from 0.1 m to 0.1 m"},
        BadScene{"mode = \"allow\"", "mode = \"alow\"",
                 "s.toml:27:8: found \"alow\", expected one of \"ignore\", \"avoid\", \"allow\", \"require\"; did you "
                 "mean 'allow'?"},
        BadScene{"max_force = \"1 N\"", "max_force = 1\nmin_force = 2",
                 "s.toml:29:13: found min_force 2 N above max_force 1 N"},
        BadScene{"[\"97 mm\", \"20 mm\"]", "[\"97 mm\"]",
                 "s.toml:31:12: found a list of 1 entry, expected a list of two entries"},
        BadScene{"[\"97 mm\", \"20 mm\"]", "[1, nan]", "s.toml:31:16: found the number nan"},
        BadScene{"weight = 100", "weight = -1", "s.toml:35:10: found the number -1"},
        BadScene{"split_at_contact = true", "split_at_contact = 1",
                 "s.toml:16:20: found the number 1, expected true or false"},
        BadScene{"title = \"Brace on a peg\"", "title = 3", "s.toml:1:9: found the number 3, expected text"},
        BadScene{"shape = \"circle\"\n", "", "[obstacle] has no 'shape'"},
        BadScene{"\"pose\"", "\"study\"",
                 "s.toml:2:11: found problem = \"study\", which is not available in this version"},
        BadScene{"limit = \"2.5 N mm\"", "max_pressure = 1", "expected 'moment_per_pressure' beside it"},
        BadScene{"limit = \"2.5 N mm\"", "moment_per_pressure = [1, 1]",
                 "found a law of several coefficients, expected limits of the pressure"},
        BadScene{"limit = \"2.5 N mm\"", "moment_per_pressure = [1, \"1 N m/Pa\"]\nmin_pressure = 0\nmax_pressure = 1",
                 "N m/Pa^2"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendn\"", "did you mean 'tendon'?"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"", "found a tendon without an 'offset'"},
        BadScene{"limit = \"2.5 N mm\"", "offset = \"1 mm\"", "found an 'offset', expected kind = \"tendon\""},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"pressure\"", "without 'moment_per_pressure'"},
        BadScene{"limit = \"2.5 N mm\"", "limit = \"1 N mm\"\nkind = \"tendon\"\noffset = 1e-3", "expected a force"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = 1e-3\nmin = -1", "found a tension of -1 N"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = [1e-3]", "two of them [at from, at to]"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = [[0, 1e-3], [1]]",
                 "expected a pair [arc length, offset]"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = 1e-3\nmoment_per_pressure = 1",
                 "found 'moment_per_pressure' of a tendon"},
        BadScene{"limit = \"2.5 N mm\"", "moment_per_tension = 1", "expected kind = \"tendon\" beside it"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = 1e-3\nmoment_per_tension = [1e-3, 1e-4]",
                 "expected limits of the tension on both sides beside it"},
        BadScene{"limit = \"2.5 N mm\"", "control = \"length\"", "expected kind = \"tendon\" beside it"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = 1e-3\ncontrol = \"lenght\"",
                 "did you mean 'length'?"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = 1e-3\ncontrol = \"length\"\nlimit = \"1 N\"",
                 "expected a length"},
        BadScene{"limit = \"2.5 N mm\"",
                 "kind = \"tendon\"\noffset = 1e-3\ncontrol = \"length\"\nmin = 2e-3\nmax = 1e-3",
                 "found min 0.002 m above max 0.001 m"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"tendon\"\noffset = 1e-3\nmax_tension = 3",
                 "expected control = \"length\" of a tendon beside it"},
        BadScene{"limit = \"2.5 N mm\"", "force_per_pressure = 1e-4", "expected 'moment_per_pressure' beside it"},
        BadScene{"limit = \"2.5 N mm\"", "kind = \"pressure\"\nmoment_per_pressure = 1\nmax_pressure = 1",
                 "found a limit of the pressure beside 'kind'"},
        BadScene{"limit = \"2.5 N mm\"", "limit = 1\nmoment_per_pressure = 1\nmax_pressure = 1",
                 "found a limit of the pressure beside one of the moment"},
        BadScene{"[start]", "[gripper]\nhalf_palm = 1\nobject_diameter = 1\npalm_distance_range = [1]\n[start]",
                 "expected two lengths"},
        BadScene{"[start]", "[gripper]\nhalf_palm = 1\nobject_diameter = 1\nfinger_angle_range = [1]\n[start]",
                 "expected two angles"},
        BadScene{"[start]", "[gripper]\nhalf_palm = 1\nobject_diameter = 1\nhalf_palm_range = [1]\n[start]",
                 "expected two lengths"},
        BadScene{"\"pose\"", "\"poes\"", "did you mean 'pose'?"},
        BadScene{"[start]", "[gripper]\nhalf_palm = 1\n[start]", "[gripper] has no 'object_diameter'"},
        BadScene{"[start]", "[[finger]]\nlenght = 1\n[start]",
                 "s.toml:19:1: found the key 'lenght', which [finger] does not have; did you mean 'length'?"},
        BadScene{"[start]", "[[finger]]\nlength = 1\n[[finger.segment]]\nlength = 1\nbending_stiffness = 1\n[start]",
                 "s.toml:19:10: found 'length' beside [[finger.segment]]"},
        BadScene{"[start]", "[[finger]]\nmin_force = 2\n[start]",
                 "s.toml:19:13: found min_force 2 N above max_force 1 N"},
        BadScene{"[start]", "[[finger]]\n[[finger.actuator]]\nmin = 1\nmax = -1\n[start]",
                 "s.toml:20:7: found min 1 N m"},
        BadScene{"[start]", "[trajectory]\n[start]", "[trajectory] has neither 'positions' nor 'angles'"},
        BadScene{"[start]", "[measurement]\n[start]",
                 "s.toml:18:1: found [measurement] in a scene with problem = \"pose\""},
        BadScene{"[start]", "[study]\nmode = 1\n[start]", "did you mean 'modes'?"},
        BadScene{"[solver]", "[[rod.segment]]\nlength = 1\nbending_stiffness = 1\n[solver]",
                 "s.toml:6:10: found 'length' beside [[rod.segment]]"}));

TEST(SceneReader, RefusesASceneWithoutARod) {
  EXPECT_EQ(refusal_of("").rfind("s.toml:1:1: the scene has no 'rod'", 0), 0U);
  EXPECT_EQ(refusal_of("rod = 3").rfind("s.toml:1:7: found the number 3", 0), 0U);
  EXPECT_EQ(refusal_of("rod = [1]").rfind("s.toml:1:7: found a list", 0), 0U);
}

TEST(SceneReader, ReadsQuantitiesInsideOptions) {
  const Scene scene = read("[rod]\nlength = 1\nbending_stiffness = 1\n");
  EXPECT_DOUBLE_EQ(scene.read_quantity("8 mm", dimension::length), 0.008);
  EXPECT_THROW(scene.read_quantity("8 N", dimension::length), Error);
}

}  // namespace
}  // namespace tendril::app::test

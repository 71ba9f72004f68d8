#include "tendril/app/result.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "support/contains.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/report.hpp"

namespace tendril::app {
namespace {

using nlohmann::json;
using test::TemporaryDirectory;

Scene simple_scene() {
  Scene scene;
  scene.file = "s.toml";
  scene.title = "A title";
  scene.rod.segments = {{0.1, 4.9e-4, 0.084, 0.0}};
  scene.rod.actuators = {{0.0, 0.1, -1.0, 1.0, 0.0}};
  scene.obstacles = {{"peg", "circle", {}}};
  return scene;
}

Plan simple_plan() {
  Plan plan;
  plan.status = PlanStatus::solved;
  plan.coordinates_name = "legendre";
  plan.order = 2;
  plan.split_at_contact = true;
  plan.coordinates = {0.25, -0.5};
  plan.moments = {0.0025};
  plan.tip_x = 0.0967;
  plan.tip_y = 0.022;
  plan.tip_angle = 0.4;
  plan.target_error = 0.002;
  plan.objective = 0.75;
  plan.terms = {{"tip_pose", 0.5}, {"tip_pose", 0.25}};
  PlannedContact& contact = plan.contacts.emplace_back();
  contact.obstacle_name = "peg";
  contact.arc_length = 0.0586;
  contact.point = {0.06, 0.008};
  contact.normal = {0.0, 1.0};
  contact.force = 0.0617;
  plan.certificate.equilibrium = 1e-13;
  plan.certificate.stationarity_kind = "S";
  plan.solver_name = "nlopt";
  plan.solver.status = SolveStatus::converged;
  plan.solver.iterations = 11;
  plan.solver.evaluations.values = 12;
  plan.solver.effective_options = {{"algorithm", "LD_SLSQP"}};
  plan.modes = {{"no contact", "skipped: out of reach", 0, 0}};
  plan.left_out = {{"palm distance", "no gripper"}};
  for (int i = 0; i <= 4; ++i) plan.backbone.push_back({0.025 * i, 0.024 * i, 0.005 * i, 0.1 * i, 4.0});
  return plan;
}

TEST(PlanJson, KeepsTheContract) {
  const json result = json::parse(plan_json(simple_scene(), simple_plan(), {}));
  EXPECT_EQ(result["schema"], 1);
  EXPECT_EQ(result["status"], "solved");
  EXPECT_EQ(result["scene"], "s.toml");
  EXPECT_EQ(result["problem"], "pose");
  EXPECT_EQ(
      result["coordinates"],
      (json{
          {"name", "legendre"}, {"order", 2}, {"split_at_contact", true}, {"dimension", 2}, {"values", {0.25, -0.5}}}));
  EXPECT_EQ(result["solver"]["name"], "nlopt");
  EXPECT_EQ(result["solver"]["status"], "converged");
  EXPECT_EQ(result["solver"]["iterations"], 11);
  EXPECT_EQ(result["solver"]["evaluations"]["values"], 12);
  EXPECT_EQ(result["solver"]["options"]["algorithm"], "LD_SLSQP");
  EXPECT_EQ(result["objective"], 0.75);
  EXPECT_EQ(result["terms"], (json{{"tip_pose", 0.5}, {"tip_pose 2", 0.25}}));
  EXPECT_EQ(result["tip"], (json{{"x", 0.0967}, {"y", 0.022}, {"angle", 0.4}}));
  EXPECT_EQ(result["target_error"], 0.002);
  EXPECT_EQ(result["moments"], json({0.0025}));
  ASSERT_EQ(result["contacts"].size(), 1U);
  const json& contact = result["contacts"][0];
  EXPECT_EQ(contact["obstacle"], "peg");
  EXPECT_EQ(contact["arc_length"], 0.0586);
  EXPECT_EQ(contact["point"], json({0.06, 0.008}));
  EXPECT_EQ(contact["normal"], json({0.0, 1.0}));
  EXPECT_EQ(contact["force"], 0.0617);
  EXPECT_EQ(contact["gap"], 0.0);
  EXPECT_EQ(result["left_out"], json::parse(R"([{"what": "palm distance", "why": "no gripper"}])"));
  EXPECT_EQ(result["backbone"].size(), 5U);
  EXPECT_EQ(result["backbone"][4], json({0.1, 0.096, 0.02, 0.4, 4.0}));
  for (const char* key : {"assemble", "solve", "certify"}) EXPECT_TRUE(result["seconds"][key].is_number()) << key;
  EXPECT_EQ(result["modes"][0]["mode"], "no contact");
  EXPECT_TRUE(result["versions"]["tendril"].is_string());
  for (const char* key :
       {"equilibrium", "penetration", "complementarity", "closest_point", "stationarity", "stationarity_kind", "bounds",
        "stability", "moment_balance", "contact_convexity", "quadrature", "failures"}) {
    EXPECT_TRUE(result["certificate"].contains(key)) << key;
  }
}

TEST(PlanJson, TellsTheMarginOutOfThePlaneWhereItIsKnown) {
  Plan plan = simple_plan();
  EXPECT_FALSE(json::parse(plan_json(simple_scene(), plan, {}))["certificate"].contains("out_of_plane"));
  EXPECT_FALSE(contains_text(plan_report(simple_scene(), plan, {}), "out of plane"));
  const auto row = [&] {
    const std::string report = plan_report(simple_scene(), plan, {});
    const std::size_t at = report.find("out of plane");
    return report.substr(at, report.find('\n', at) - at);
  };
  plan.certificate.out_of_plane = -0.25;
  EXPECT_EQ(json::parse(plan_json(simple_scene(), plan, {}))["certificate"]["out_of_plane"], -0.25);
  EXPECT_TRUE(contains_text(row(), "FAILS")) << row();
  plan.certificate.guided_in_plane = true;
  EXPECT_TRUE(contains_text(row(), "-0.25")) << row();
  EXPECT_TRUE(contains_text(row(), "(guided)")) << row();
  plan.certificate.guided_in_plane = false;
  plan.certificate.out_of_plane = 0.5;
  EXPECT_TRUE(contains_text(row(), "ok")) << row();
}

TEST(PlanJson, SaysThatTimeEndedTheSearchBesideTheStatus) {
  Plan plan = simple_plan();
  EXPECT_FALSE(json::parse(plan_json(simple_scene(), plan, {})).contains("search_cut"));
  EXPECT_FALSE(contains_text(plan_report(simple_scene(), plan, {}), "time ended the search"));
  plan.search_cut = true;
  EXPECT_EQ(json::parse(plan_json(simple_scene(), plan, {}))["search_cut"], true);
  const std::string report = plan_report(simple_scene(), plan, {});
  const std::size_t status = report.find("\nstatus ");
  const std::string line = report.substr(status + 1, report.find('\n', status + 1) - status - 1);
  EXPECT_TRUE(contains_text(line, "solved, but time ended the search")) << line;
}

TEST(PlanJson, WritesNullForWhatIsNotFinite) {
  Plan plan = simple_plan();
  plan.objective = std::nan("");
  plan.backbone[2].angle = infinity;
  plan.target_error.reset();
  const json result = json::parse(plan_json(simple_scene(), plan, {}));
  EXPECT_TRUE(result["certificate"]["penetration"].is_null());
  EXPECT_TRUE(result["certificate"]["stability"].is_null());
  EXPECT_TRUE(result["objective"].is_null());
  EXPECT_TRUE(result["backbone"][2][3].is_null());
  EXPECT_TRUE(result["target_error"].is_null());
}

TEST(PlanJson, TellsNoTipOfAPlanWithoutAShape) {
  Plan plan;
  plan.message = "why";
  const json result = json::parse(plan_json(simple_scene(), plan, {}));
  EXPECT_EQ(result["status"], "failed");
  EXPECT_EQ(result["message"], "why");
  EXPECT_TRUE(result["tip"]["x"].is_null());
  EXPECT_TRUE(result["objective"].is_null());
}

TEST(PlanJson, SurvivesTextThatIsNotUtf8) {
  Scene scene = simple_scene();
  scene.file = "\xff.toml";
  scene.title = "quote \" backslash \\ control \x01";
  const json result = json::parse(plan_json(scene, simple_plan(), {}));
  EXPECT_EQ(result["title"], scene.title);
}

TEST(DescriptionJson, KeepsTheContract) {
  Description description;
  description.variables = {{"coordinates", 12}, {"moments", 1}};
  description.rows = {{"equilibrium", 12, "equality"}};
  description.terms = {"tip_pose"};
  description.left_out = {{"contact", "no obstacle"}};
  RunInfo run;
  run.components = {{"solver", "nlopt", "/x/tendril-solver-nlopt.so"}};
  const json result = json::parse(description_json(simple_scene(), description, run));
  EXPECT_EQ(result["variables"],
            json::parse(R"([{"name": "coordinates", "count": 12}, {"name": "moments", "count": 1}])"));
  EXPECT_EQ(result["rows"], json::parse(R"([{"name": "equilibrium", "count": 12, "kind": "equality"}])"));
  EXPECT_EQ(result["terms"], json({"tip_pose"}));
  EXPECT_EQ(result["plugins"][0]["name"], "nlopt");
  EXPECT_EQ(result["left_out"][0]["why"], "no obstacle");
}

TEST(ReadStart, GivesBackWhatWasWritten) {
  const TemporaryDirectory directory;
  const Plan plan = simple_plan();
  const Plan start = read_start(directory.write("r.json", plan_json(simple_scene(), plan, {})), simple_scene());
  EXPECT_EQ(start.coordinates_name, "legendre");
  EXPECT_EQ(start.coordinates, plan.coordinates);
  EXPECT_EQ(start.moments, plan.moments);
  EXPECT_EQ(start.backbone, plan.backbone);
  ASSERT_EQ(start.contacts.size(), 1U);
  EXPECT_EQ(start.contacts[0].obstacle, 0);
  EXPECT_EQ(start.contacts[0].arc_length, plan.contacts[0].arc_length);
  EXPECT_EQ(start.contacts[0].force, plan.contacts[0].force);
}

TEST(ReadStart, LeavesOutContactsWithOtherObstacles) {
  const TemporaryDirectory directory;
  Scene other = simple_scene();
  other.obstacles[0].name = "another";
  EXPECT_TRUE(
      read_start(directory.write("r.json", plan_json(simple_scene(), simple_plan(), {})), other).contacts.empty());
}

struct Damage {
  const char* pointer;
  const char* value;
  const char* message;
};

void PrintTo(const Damage& damage, std::ostream* out) { *out << damage.pointer << " = " << damage.value; }

class ReadStartRefuses : public testing::TestWithParam<Damage> {};

TEST_P(ReadStartRefuses, WithThePlace) {
  const TemporaryDirectory directory;
  json result = json::parse(plan_json(simple_scene(), simple_plan(), {}));
  result[json::json_pointer(GetParam().pointer)] = json::parse(GetParam().value);
  const std::string file = directory.write("r.json", result.dump());
  try {
    read_start(file, simple_scene());
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_TRUE(contains_text(message, GetParam().message));
    EXPECT_EQ(message.rfind(file, 0), 0U) << message;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Damages, ReadStartRefuses,
    testing::Values(Damage{"/schema", "2", "schema 2"}, Damage{"/schema", "\"1\"", "/schema"},
                    Damage{"/coordinates", "3", "coordinates"},
                    Damage{"/coordinates/order", "1e300", "/coordinates/order"},
                    Damage{"/coordinates/order", "-1", "/coordinates/order"},
                    Damage{"/coordinates/values/0", "\"x\"", "/coordinates/values/0"},
                    Damage{"/coordinates/values/0", "null", "/coordinates/values/0"},
                    Damage{"/moments", "[1, 2]", "2 moments"}, Damage{"/moments", "{}", "/moments"},
                    Damage{"/tip/x", "[]", "/tip/x"}, Damage{"/contacts/0/arc_length", "1e9", "/contacts/0/arc_length"},
                    Damage{"/contacts/0/point", "[1]", "/contacts/0/point"},
                    Damage{"/contacts/0/at_tip", "1", "/contacts/0/at_tip"}, Damage{"/backbone", "[]", "/backbone"},
                    Damage{"/backbone/1", "[1]", "/backbone/1"}, Damage{"/backbone/1/0", "0.09", "/backbone/2"},
                    Damage{"/backbone/4/0", "0.2", "/backbone"}));

TEST(ReadStart, RefusesWhatIsNoResult) {
  const TemporaryDirectory directory;
  for (const std::string& text : {std::string(""), std::string("{}"), std::string("[1, 2"), std::string("3"),
                                  std::string("null"), std::string(1'000'000, '['), std::string("\xff\xfe")}) {
    EXPECT_THROW(read_start(directory.write("r.json", text), simple_scene()), InputError) << text.substr(0, 10);
  }
  std::string deep(1'000'000, '[');
  deep += std::string(1'000'000, ']');
  EXPECT_THROW(read_start(directory.write("r.json", deep), simple_scene()), InputError);
}

}  // namespace
}  // namespace tendril::app

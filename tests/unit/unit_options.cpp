#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/contains.hpp"
#include "tendril/options.hpp"

namespace tendril {
namespace {

using List = RawValue::List;

constexpr Scale unit_scale{};
const std::string owner = "coordinates plugin 'test'";

/// Reads "<number> mm" as a length; anything else is an error with a known text.
double read_millimetres(std::string_view text, const Dimension& dimension) {
  if (dimension.length != 1 || !text.ends_with(" mm")) throw Error("not a length in mm");
  return std::stod(std::string(text)) * 1e-3;
}

Options resolve(const OptionSchema& schema, const RawOptions& given, const Scale& scale = unit_scale,
                const QuantityReader& read = read_millimetres) {
  return resolve_options(schema, given, scale, read, owner);
}

/// The message of the OptionError that `given` ends in.
std::string refusal(const OptionSchema& schema, const RawOptions& given,
                    const QuantityReader& read = read_millimetres) {
  try {
    resolve(schema, given, unit_scale, read);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "nothing was refused";
}

void expect_says(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_TRUE(contains_text(message, part)) << message << "\nlacks: " << part;
}

OptionSpec order() {
  return {.name = "order", .type = OptionType::integer, .default_value = std::int64_t{6}, .minimum = 1, .maximum = 64};
}
OptionSpec radius() {
  return {.name = "radius",
          .type = OptionType::real,
          .minimum = 0,
          .dimension = dimension::length,
          .required = true,
          .minimum_excluded = true};
}

TEST(Options, DefaultsFillInWhatIsNotGiven) {
  EXPECT_EQ(resolve({order()}, {}).integer("order"), 6);
  EXPECT_EQ(resolve({order()}, {{"order", {std::int64_t{9}}}}).integer("order"), 9);
}

TEST(Options, AnOptionWithoutDefaultIsAbsentUnlessGiven) {
  const OptionSchema schema{{.name = "angle_weight", .type = OptionType::real}};
  EXPECT_FALSE(resolve(schema, {}).has("angle_weight"));
  EXPECT_TRUE(resolve(schema, {{"angle_weight", {2.0}}}).has("angle_weight"));
  EXPECT_THROW(resolve(schema, {}).real("angle_weight"), Error);
}

TEST(Options, AnIntegerIsTakenForARealNumber) {
  const OptionSchema schema{{.name = "weight", .type = OptionType::real}};
  EXPECT_EQ(resolve(schema, {{"weight", {std::int64_t{100}}}}).real("weight"), 100.0);
}

TEST(Options, AnIntegerIsTakenForARealDefault) {
  const OptionSchema schema{{.name = "weight", .type = OptionType::real, .default_value = std::int64_t{3}}};
  EXPECT_EQ(resolve(schema, {}).real("weight"), 3.0);
}

TEST(Options, ADefaultOfAnotherTypeIsADefectOfTheComponent) {
  const OptionSchema schema{{.name = "weight", .type = OptionType::real, .default_value = std::string("heavy")}};
  EXPECT_THROW(resolve(schema, {}), Error);
}

TEST(Options, ARealNumberIsTakenForAnIntegerIfItIsWhole) {
  EXPECT_EQ(resolve({order()}, {{"order", {6.0}}}).integer("order"), 6);
  expect_says(refusal({order()}, {{"order", {65.0}}}), {"found 65.0", "out of range"});
  for (const double beyond : {1e300, std::numeric_limits<double>::infinity(), std::nan("")}) {
    expect_says(refusal({order()}, {{"order", {beyond}}}), {"expected a whole number from 1 to 64"});
  }
  expect_says(refusal({order()}, {{"order", {6.5}}}),
              {"option 'order' of coordinates plugin 'test'", "found 6.5", "expected a whole number from 1 to 64"});
}

TEST(Options, NumbersOutOfRangeAreRefusedWithTheRange) {
  expect_says(refusal({order()}, {{"order", {std::int64_t{65}}}}), {"found 65", "out of range", "from 1 to 64"});
  expect_says(refusal({radius()}, {{"radius", {0.0}}}), {"found 0", "expected a number > 0 m"});
  EXPECT_NO_THROW(resolve({order()}, {{"order", {std::int64_t{64}}}}));
}

TEST(Options, NumbersThatAreNotFiniteAreRefused) {
  const OptionSchema schema{{.name = "weight", .type = OptionType::real}};
  expect_says(refusal(schema, {{"weight", {std::numeric_limits<double>::quiet_NaN()}}}),
              {"nan", "not a finite number"});
  expect_says(refusal(schema, {{"weight", {std::numeric_limits<double>::infinity()}}}), {"inf", "not a finite number"});
}

TEST(Options, TextIsReadWithItsUnitAndMadeDimensionless) {
  const Scale scale{0.1, 4.9e-4};
  EXPECT_EQ(resolve({radius()}, {{"radius", {std::string("8 mm")}}}, scale).real("radius"), 0.08);
}

TEST(Options, DefaultsAreScaledLikeGivenValues) {
  OptionSpec spec = radius();
  spec.required = false;
  spec.default_value = 0.02;
  EXPECT_EQ(resolve({spec}, {}, Scale{0.1, 1.0}).real("radius"), 0.2);
}

TEST(Options, TheRangeIsCheckedInSi) {
  OptionSpec spec = radius();
  spec.maximum = 0.05;
  // 0.02 m is 20 in units of a 1 mm rod: still inside the range of 0.05 m.
  EXPECT_EQ(resolve({spec}, {{"radius", {0.02}}}, Scale{1e-3, 1.0}).real("radius"), 20.0);
}

TEST(Options, AWrongUnitIsRefusedWithTheReason) {
  expect_says(refusal({radius()}, {{"radius", {std::string("8 kg")}}}), {"'8 kg'", "not a length in mm", "> 0 m"});
}

TEST(Options, TextIsRefusedForNumbersWhereNobodyReadsUnits) {
  expect_says(refusal({radius()}, {{"radius", {std::string("8 mm")}}}, QuantityReader{}), {"'8 mm'", "cannot be read"});
}

TEST(Options, AnUnknownNameIsAnsweredWithTheNearest) {
  expect_says(refusal({order()}, {{"ordre", {std::int64_t{4}}}}),
              {owner, "no option 'ordre'", "4", "did you mean 'order'?"});
  expect_says(refusal({order()}, {{"stiffness", {1.0}}}), {"no option 'stiffness'", "known: order"});
}

TEST(Options, AMissingRequiredOptionIsNamedWithWhatIsExpected) {
  expect_says(refusal({radius()}, {}), {owner, "needs option 'radius'", "a number > 0 m"});
}

TEST(Options, TheErrorKnowsTheOptionAndItsPosition) {
  try {
    resolve({order()}, {{"order", {true, {7, 3}}}});
    FAIL() << "a boolean was taken for an integer";
  } catch (const OptionError& error) {
    EXPECT_EQ(error.option(), "order");
    EXPECT_EQ(error.position().line, 7);
    EXPECT_EQ(error.position().column, 3);
  }
}

TEST(Options, BooleansAreOnlyTrueAndFalse) {
  const OptionSchema schema{{.name = "exact", .type = OptionType::boolean, .default_value = true}};
  EXPECT_TRUE(resolve(schema, {}).boolean("exact"));
  EXPECT_FALSE(resolve(schema, {{"exact", {false}}}).boolean("exact"));
  expect_says(refusal(schema, {{"exact", {std::int64_t{1}}}}), {"found 1", "expected true or false"});
}

TEST(Options, OnlyDeclaredWordsAreTaken) {
  const OptionSchema schema{{.name = "form",
                             .type = OptionType::text,
                             .default_value = std::string("square"),
                             .choices = {"square", "linear"}}};
  EXPECT_EQ(resolve(schema, {}).text("form"), "square");
  EXPECT_EQ(resolve(schema, {{"form", {std::string("linear")}}}).text("form"), "linear");
  expect_says(refusal(schema, {{"form", {std::string("linaer")}}}),
              {"'linaer'", "did you mean 'linear'?", "one of 'square', 'linear'"});
}

TEST(Options, ListsHaveOneRow) {
  const OptionSchema schema{{.name = "lengths", .type = OptionType::list, .minimum = 0, .minimum_excluded = true}};
  const Options options = resolve(schema, {{"lengths", {List{{std::int64_t{1}}, {2.5}}}}});
  EXPECT_EQ(options.table("lengths").rows, 1);
  EXPECT_EQ(options.table("lengths").columns, 2);
  EXPECT_EQ(options.table("lengths")(0, 1), 2.5);
}

TEST(Options, ListsAreCheckedEntryByEntryAndForTheirSize) {
  const OptionSchema schema{
      {.name = "point", .type = OptionType::list, .minimum = 0, .dimension = dimension::length, .size = 2}};
  EXPECT_EQ(resolve(schema, {{"point", {List{{std::string("5 mm")}, {0.0}}}}}).table("point")(0, 0), 5e-3);
  expect_says(refusal(schema, {{"point", {List{{1.0}}}}}), {"[1.0]", "1 entries", "a list of 2 numbers"});
  expect_says(refusal(schema, {{"point", {List{{1.0}, {-1.0}}}}}), {"found -1", "out of range"});
  expect_says(refusal(schema, {{"point", {1.0}}}), {"found 1", "a list of 2 numbers"});
  expect_says(refusal(schema, {{"point", {List{}}}}), {"empty"});
}

TEST(Options, AListEntryWithoutPositionIsReportedAtTheList) {
  const OptionSchema schema{{.name = "point", .type = OptionType::list, .minimum = 0}};
  try {
    resolve(schema, {{"point", {List{{1.0}, {-1.0}}, {4, 9}}}});
    FAIL() << "a negative entry was taken";
  } catch (const OptionError& error) {
    EXPECT_EQ(error.position().line, 4);
  }
}

TEST(Options, MatricesAreGivenAsRowsDiagonalOrNumber) {
  const OptionSchema schema{{.name = "weights", .type = OptionType::matrix}};
  const Options rows = resolve(schema, {{"weights", {List{{List{{1.0}, {2.0}}}, {List{{3.0}, {4.0}}}}}}});
  EXPECT_EQ(rows.table("weights").rows, 2);
  EXPECT_EQ(rows.table("weights")(1, 0), 3.0);
  const Options diagonal = resolve(schema, {{"weights", {List{{5.0}, {std::int64_t{6}}}}}});
  EXPECT_EQ(diagonal.table("weights").values, (std::vector<double>{5, 0, 0, 6}));
  const Options number = resolve(schema, {{"weights", {7.0}}});
  EXPECT_EQ(number.table("weights").rows, 1);
  EXPECT_EQ(number.table("weights")(0, 0), 7.0);
}

TEST(Options, RaggedMatricesAreRefused) {
  const OptionSchema schema{{.name = "weights", .type = OptionType::matrix}};
  expect_says(refusal(schema, {{"weights", {List{{List{{1.0}, {2.0}}}, {List{{3.0}}}}}}}),
              {"rows of different or no length"});
  expect_says(refusal(schema, {{"weights", {List{{List{{1.0}}}, {2.0}}}}}), {"rows of different or no length"});
  expect_says(refusal(schema, {{"weights", {List{{List{}}}}}}), {"rows of different or no length"});
  expect_says(refusal(schema, {{"weights", {List{{1.0}, {List{{3.0}}}}}}}), {"found [3.0]"});
}

TEST(Options, AnUnlistedOptionPassesOnlyWhereTheSchemaSaysSo) {
  const OptionSchema schema{order(), {.name = std::string(any_option)}};
  const Options options = resolve(schema, {{"mu_init", {1e-3}}, {"print_level", {std::int64_t{0}}}});
  EXPECT_EQ(options.integer("order"), 6);
  EXPECT_EQ(options.real("mu_init"), 1e-3);
  EXPECT_EQ(options.integer("print_level"), 0);
  expect_says(refusal(schema, {{"mu_init", {List{{1.0}}}}}), {"option 'mu_init'", "a number, a word"});
  expect_says(refusal(schema, {{"order", {1.5}}}), {"a whole number from 1 to 64"});
}

TEST(NearestName, FindsMisspellingsSwapsBeginningsAndCapitals) {
  const std::vector<std::string> known{"ipopt", "nlopt", "ceres"};
  EXPECT_EQ(nearest_name("nolpt", known), "nlopt");
  EXPECT_EQ(nearest_name("NLOPT", known), "nlopt");
  EXPECT_EQ(nearest_name("cer", known), "ceres");
  EXPECT_EQ(nearest_name("ipop", known), "ipopt");
}

TEST(NearestName, IsSilentWhenNothingIsNear) {
  const std::vector<std::string> known{"ipopt", "nlopt", "ceres"};
  EXPECT_EQ(nearest_name("gurobi", known), "");
  EXPECT_EQ(nearest_name("x", known), "");
  EXPECT_EQ(nearest_name("", known), "");
  EXPECT_EQ(nearest_name(std::string(1000000, 'a'), known), "");
}

TEST(DidYouMean, ListsWhatIsKnownWhenNothingIsNear) {
  EXPECT_EQ(did_you_mean("gurobi", std::vector<std::string>{"ipopt", "nlopt"}), " (known: ipopt, nlopt)");
  EXPECT_EQ(did_you_mean("gurobi", std::vector<std::string>{}), " (none is known)");
  EXPECT_EQ(did_you_mean("nlop", std::vector<std::string>{"ipopt", "nlopt"}), "; did you mean 'nlopt'?");
}

}  // namespace
}  // namespace tendril

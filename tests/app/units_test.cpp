#include "tendril/app/units.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "scene/common_units.hpp"
#include "support/contains.hpp"

namespace tendril::app {
namespace {

struct Reading {
  const char* text;
  Dimension dimension;
  double si;
};

void PrintTo(const Reading& reading, std::ostream* out) { *out << reading.text; }

class UnitsRead : public testing::TestWithParam<Reading> {};

TEST_P(UnitsRead, GivesTheSiValue) {
  const Units units;
  // A unit's factor and the product are each rounded once or twice.
  EXPECT_NEAR(units.read(GetParam().text, GetParam().dimension), GetParam().si,
              4.0 * std::numeric_limits<double>::epsilon() * std::abs(GetParam().si));
}

// Written in another way a unit is none of the usual ones, and UDUNITS is asked.
TEST(CommonUnits, AreToTheLastBitThoseOfTheDatabase) {
  const Units units;
  for (const CommonUnit& common : common_units) {
    const std::string unit(common.unit);
    const std::string asked = unit.starts_with("1/") ? unit.substr(2) + "^-1" : "(" + unit + ")";
    const Dimension dimension{0, 0, common.dimension};
    EXPECT_EQ(units.read("1 " + asked, dimension), common.size) << unit;
    EXPECT_EQ(units.read("1 " + unit, dimension), common.size) << unit;
  }
}

TEST(UnitsUsed, AreThoseOfMostTextsTheEarlierOfTwo) {
  const Units units;
  EXPECT_TRUE(units.most_used().empty());
  for (const char* text : {"1 m", "10 cm", "20 cm"}) units.read(text, dimension::length);
  for (const char* text : {"1 bar", "100 kPa"}) units.read(text, dimension::pressure);
  units.read("3 N mm", dimension::moment);
  EXPECT_THROW(units.read("3 kg", dimension::moment), QuantityError);
  const auto most = units.most_used();
  ASSERT_EQ(most.size(), 3U);
  EXPECT_EQ(most.at("m").name, "cm");
  EXPECT_NEAR(most.at("m").size, 0.01, 1e-17);
  EXPECT_EQ(most.at("Pa").name, "bar");
  EXPECT_NEAR(most.at("Pa").size, 1e5, 1e-10);
  EXPECT_EQ(most.at("N m").name, "N mm");
}

INSTANTIATE_TEST_SUITE_P(
    Quantities, UnitsRead,
    testing::Values(Reading{"60 mm", dimension::length, 0.06}, Reading{"60mm", dimension::length, 0.06},
                    Reading{" +60 mm ", dimension::length, 0.06}, Reading{"0 mm", dimension::length, 0.0},
                    Reading{"1 in", dimension::length, 0.0254}, Reading{"60 \u00b5m", dimension::length, 60e-6},
                    Reading{"2.5 N mm", dimension::moment, 2.5e-3}, Reading{"2.5 N*mm", dimension::moment, 2.5e-3},
                    Reading{"1 lbf in", dimension::moment, 4.4482216152605 * 0.0254},
                    Reading{"4.9e-4 N m^2", dimension::stiffness, 4.9e-4},
                    Reading{"490 N mm2", dimension::stiffness, 4.9e-4},
                    Reading{"84 g/m", dimension::linear_density, 0.084},
                    Reading{"30 deg", dimension::angle, std::numbers::pi / 6.0},
                    Reading{"0.5 rad", dimension::angle, 0.5}, Reading{"5 1/m", dimension::curvature, 5.0},
                    Reading{"5 m^-1", dimension::curvature, 5.0}, Reading{"5 rad/m", dimension::curvature, 5.0},
                    Reading{"18 deg/cm", dimension::curvature, 10.0 * std::numbers::pi},
                    Reading{"-9.81 m/s^2", dimension::acceleration, -9.81}, Reading{"2 min", dimension::time, 120.0},
                    Reading{"1 N mm/kPa", dimension::moment_per_pressure, 1e-6}, Reading{"0.5", dimension::none, 0.5}));

struct Refusal {
  const char* text;
  Dimension dimension;
  const char* reason;  ///< part of the message
};

void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.text; }

class UnitsRefuse : public testing::TestWithParam<Refusal> {};

TEST_P(UnitsRefuse, WithTheReason) {
  const Units units;
  try {
    const double value = units.read(GetParam().text, GetParam().dimension);
    FAIL() << "read as " << value;
  } catch (const QuantityError& error) {
    const std::string message = error.what();
    EXPECT_TRUE(contains_text(message, GetParam().reason));
    EXPECT_EQ(message.rfind("found \"", 0), 0U) << message;
    EXPECT_TRUE(contains_text(message, ", expected "));
  }
}

// UDUNITS alone would take several of these: it inverts "1/m", multiplies "3 4 m", and shifts by "@ 3".
INSTANTIATE_TEST_SUITE_P(Traps, UnitsRefuse,
                         testing::Values(Refusal{"100 1/m", dimension::length, "whose unit is not that of a length"},
                                         Refusal{"3 4 m", dimension::length, "\"4 m\" is not a unit"},
                                         Refusal{"100 mm @ 3", dimension::length, "is not a unit"},
                                         Refusal{"5 m since 1970", dimension::length, "is not a unit"},
                                         Refusal{"5 rad m", dimension::length, "whose unit is not that of a length"},
                                         Refusal{"5 %", dimension::length, "whose unit is not that of a length"},
                                         Refusal{"5 degC", dimension::length, "whose unit is not that of a length"},
                                         Refusal{"5 lg(re m)", dimension::length, "whose unit is not that of a length"},
                                         Refusal{"1,5 mm", dimension::length, "is not a unit"},
                                         Refusal{"0x10 m", dimension::length, "is not a known unit"},
                                         Refusal{"nan m", dimension::length, "not finite"},
                                         Refusal{"-inf m", dimension::length, "not finite"},
                                         Refusal{"1e400 m", dimension::length, "too large"},
                                         Refusal{"1e300 Ym", dimension::length, "too large"},
                                         Refusal{"60", dimension::length, "without a unit"},
                                         Refusal{"", dimension::length, "does not begin with a number"},
                                         Refusal{"mm", dimension::length, "does not begin with a number"},
                                         Refusal{"\u22125 mm", dimension::length, "does not begin with a number"},
                                         Refusal{"5 m^99999999999", dimension::length, "is not"},
                                         Refusal{"0.5 m", dimension::none, "has a unit"},
                                         Refusal{"2.5 Nm", dimension::moment, "did you mean 'N m'?"},
                                         Refusal{"2.5 Nmm", dimension::moment, "did you mean 'N mm'?"},
                                         Refusal{"4.9e-4 Nm^2", dimension::stiffness, "did you mean 'N m^2'?"},
                                         Refusal{"2.5 N", dimension::moment, "whose unit is not that of a moment"}));

// A capital letter too many, or one too few, is a factor of 1e9: it is asked back, whatever the quantity.
INSTANTIATE_TEST_SUITE_P(Prefixes, UnitsRefuse,
                         testing::Values(Refusal{"100 Mm", dimension::length,
                                                 "whose unit is 1e+06 m, too large for a rod"},
                                         Refusal{"100 Mm", dimension::length, "did you mean 'mm'?"},
                                         Refusal{"100 nm", dimension::length, "too small for a rod"},
                                         Refusal{"0.5 MN", dimension::force, "did you mean 'mN'?"},
                                         Refusal{"2 MN m", dimension::moment, "did you mean 'mN m'?"},
                                         Refusal{"5 GN m^2", dimension::stiffness, "too large for a rod"},
                                         Refusal{"20 Mg", dimension::mass, "did you mean 'mg'?"},
                                         Refusal{"84 Mg/m", dimension::linear_density, "did you mean 'mg/m'?"},
                                         Refusal{"10 Ms", dimension::time, "did you mean 'ms'?"},
                                         Refusal{"50 mPa", dimension::pressure, "did you mean 'MPa'?"},
                                         Refusal{"3 Mrad", dimension::angle, "did you mean 'mrad'?"},
                                         Refusal{"5 1/Mm", dimension::curvature, "too small for a rod"}));

// "kilogr am" is a grain times an attometre to the database.
TEST(Units, NoneIsSuggestedThatNobodyUses) {
  try {
    Units().read("2.5 kilogram^1 meter^1 second^-2", dimension::moment);
    FAIL() << "a force was read as a moment";
  } catch (const QuantityError& error) {
    EXPECT_EQ(std::string(error.what()).find("did you mean"), std::string::npos) << error.what();
  }
}

TEST(Units, OfEveryRodAreTaken) {
  const Units units;
  for (const char* text : {"1 um", "1 mm", "1 cm", "1 inch", "1 m", "1 km"}) {
    EXPECT_NO_THROW(units.read(text, dimension::length)) << text;
  }
  for (const char* text : {"1 nN", "1 uN", "1 mN", "1 N", "1 kN", "1 dyne", "1 lbf"}) {
    EXPECT_NO_THROW(units.read(text, dimension::force)) << text;
  }
  for (const char* text : {"1 nN um", "1 uN m", "1 N mm", "1 kN m"}) {
    EXPECT_NO_THROW(units.read(text, dimension::moment)) << text;
  }
  for (const char* text : {"1 nN um^2", "1 N mm^2", "1 kN m^2"}) {
    EXPECT_NO_THROW(units.read(text, dimension::stiffness)) << text;
  }
  for (const char* text : {"1 Pa", "1 kPa", "1 bar", "1 psi", "1 MPa"}) {
    EXPECT_NO_THROW(units.read(text, dimension::pressure)) << text;
  }
  for (const char* text : {"1 us", "1 ms", "1 s", "1 h", "1 day"}) {
    EXPECT_NO_THROW(units.read(text, dimension::time)) << text;
  }
  for (const char* text : {"1 urad", "1 mrad", "1 deg", "1 arcmin", "1 turn"}) {
    EXPECT_NO_THROW(units.read(text, dimension::angle)) << text;
  }
}

TEST(Units, RefuseAVeryLongUnit) {
  const Units units;
  EXPECT_THROW(units.read("1 " + std::string(100'000, '('), dimension::length), QuantityError);
}

}  // namespace
}  // namespace tendril::app

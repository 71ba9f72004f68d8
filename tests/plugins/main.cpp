#include <gtest/gtest.h>

#include "tendril/plugins/probe.hpp"

int main(int argc, char** argv) {
  if (const auto exit_code = tendril::plugins::answer_probe(argc, argv)) return *exit_code;
  testing::InitGoogleTest(&argc, argv);
  // Plugins that crash are opened in a copy of the program that starts anew.
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  return RUN_ALL_TESTS();
}

#include <gtest/gtest.h>

#include <cstdio>

#include "solvers.hpp"

/// ValuesIn() is evaluated inside InitGoogleTest, so the plugins have to be there before.
int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv, argv + argc);
  try {
    tendril::conformance::load_solvers(arguments);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
  std::vector<char*> rest;
  for (std::string& argument : arguments) rest.push_back(argument.data());
  int count = static_cast<int>(rest.size());
  rest.push_back(nullptr);
  testing::InitGoogleTest(&count, rest.data());
  return RUN_ALL_TESTS();
}

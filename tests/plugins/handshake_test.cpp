#include "tendril/plugins/handshake.hpp"

#include "support.hpp"

namespace tendril::plugins {
namespace {

TEST(Handshake, EqualOnesHaveNoDifferences) {
  EXPECT_TRUE(differences(detail::this_handshake(), detail::this_handshake()).empty());
}

TEST(Handshake, EachFieldThatDiffersIsToldInWords) {
  const tendril_handshake program{sizeof(tendril_handshake), 1, 1017, 1, 0, 30400, 16, 1, 0};
  const tendril_handshake plugin{sizeof(tendril_handshake), 2, 1016, 0, 1, 30300, 32, 0, 5};
  const std::vector<std::string> found = differences(plugin, program);
  ASSERT_EQ(found.size(), 8U);
  expect_says(found[0],
              {"interface version: 2, this program: 1", "the plugin is newer: use the tendril it was built for"});
  expect_says(found[1], {"__GXX_ABI_VERSION", "1016", "1017"});
  expect_says(found[2], {"_GLIBCXX_USE_CXX11_ABI: 0, this program: 1"});
  expect_says(found[3], {"_GLIBCXX_DEBUG", "yes, this program: no"});
  expect_says(found[4], {"Eigen version: 3.3.0, this program: 3.4.0"});
  expect_says(found[5], {"Eigen alignment in bytes: 32, this program: 16", "-march"});
  expect_says(found[6], {"EIGEN_MALLOC_ALREADY_ALIGNED: 0, this program: 1"});
  expect_says(found[7], {"sanitizers: address and memory, this program: none"});
}

TEST(Handshake, AShorterOneIsReadNoFurtherThanItGoes) {
  tendril_handshake plugin = detail::this_handshake();
  plugin.size = 2 * sizeof(std::uint32_t);
  plugin.interface_version = 0;
  // Behind the end of the shorter struct: whatever stands there means nothing.
  plugin.sanitizers = 7;
  const std::vector<std::string> found = differences(plugin, detail::this_handshake());
  ASSERT_EQ(found.size(), 2U);
  expect_says(found[0], {"handshake size: 8"});
  expect_says(found[1], {"interface version: 0", "the plugin is older: rebuild it against this tendril"});
}

}  // namespace
}  // namespace tendril::plugins

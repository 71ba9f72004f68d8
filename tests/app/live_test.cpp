// The page's server is a library that a build or a machine may lack.

#include "live/live.hpp"

#include <gtest/gtest.h>

#include "support/contains.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::app {
namespace {

std::string refusal(const std::string& server) {
  LiveArguments arguments;
  arguments.scene.scene = "/does/not/exist.toml";
  arguments.server = server;
  try {
    run_live(arguments);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Live, WithoutItsServerSaysWhatIsMissing) {
  EXPECT_TRUE(contains_text(refusal(""),
                            "live: this tendril was built without the server of the page, which needs "
                            "cpp-httplib (Debian: libcpp-httplib-dev)"));
  EXPECT_TRUE(contains_text(refusal("libtendril-no-such-server.so.1"),
                            "live: the page's server cannot be loaded, expected libtendril-no-such-server.so.1 and, of "
                            "Debian, libcpp-httplib0.11: "));
  // Some library that is no server.
  EXPECT_EQ(refusal("libm.so.6"), "live: libm.so.6 holds no server");
}

}  // namespace
}  // namespace tendril::app

// What ends a search: the user, the clock, or the looks that a part of it is allowed.

#include <gtest/gtest.h>

#include <atomic>

#include "base/deadline.hpp"

namespace tendril {
namespace {

constexpr double far_away = 1e6;  ///< s

TEST(Deadline, IsNotOverBeforeItsTime) {
  const Deadline deadline(nullptr, far_away);
  EXPECT_FALSE(deadline.over());
  EXPECT_FALSE(deadline.cut());
  EXPECT_GT(deadline.seconds_left(), 0.5 * far_away);
}

TEST(Deadline, CutsOnlyASearchThatWouldGoOn) {
  const Deadline deadline(nullptr, -1.0);
  EXPECT_FALSE(deadline.cut());  // nobody asked: the search was done
  EXPECT_TRUE(deadline.over());
  EXPECT_TRUE(deadline.cut());
}

TEST(Deadline, AnInterruptionIsNoCut) {
  std::atomic<bool> stop{false};
  const Deadline deadline(&stop, far_away);
  EXPECT_FALSE(deadline.interrupted());
  stop = true;
  EXPECT_TRUE(deadline.interrupted());
  EXPECT_TRUE(deadline.over());
  EXPECT_FALSE(deadline.cut());
}

TEST(Allowance, GivesSoManyLooks) {
  const Deadline deadline(nullptr, far_away);
  Allowance allowance(deadline, 3);
  for (int look = 0; look < 3; ++look) EXPECT_FALSE(allowance.spent()) << "look " << look;
  EXPECT_TRUE(allowance.spent());
  EXPECT_TRUE(allowance.spent());
  EXPECT_FALSE(deadline.cut());
}

TEST(Allowance, EndsWithTheSearch) {
  std::atomic<bool> stop{true};
  const Deadline deadline(&stop, far_away);
  Allowance allowance(deadline, 1000);
  EXPECT_TRUE(allowance.spent());
}

}  // namespace
}  // namespace tendril

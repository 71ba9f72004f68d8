// tendril-estimate-campaign [RUNS [FIRST_SEED]]: how good estimates are, over many seeds of the noise. The tests run
// the same with fewer seeds.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "estimate/truth.hpp"

int main(int argc, char** argv) {
  using namespace tendril;
  if (argc > 1 && std::string(argv[1]) == "points") {
    std::fputs(test::measurement_file().c_str(), stdout);
    return 0;
  }
  const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  struct Case {
    const char* name;
    test::Truth truth;
  };
  const Case cases[] = {{"braced arm", test::braced_arm()},
                        {"held from above", test::held_from_above()},
                        {"stepped finger", test::stepped_finger()},
                        {"two pegs", test::two_pegs()},
                        {"close pegs", test::close_pegs()}};
  for (const Case& c : cases) {
    const auto solution = c.truth.solve();
    const Eigen::VectorXd right = test::parameters(c.truth, solution);
    const auto contacts = static_cast<int>(c.truth.circles.size());
    std::printf("%s\n", c.name);
    for (const double relative : {2e-4, 2e-3}) {
      const double noise = relative * c.truth.length();
      const Eigen::MatrixXd bound = test::cramer_rao(c.truth, 20, noise);
      for (int k = 0; k < contacts; ++k) {
        std::printf(
            "  noise %.2g L: contact %d: force %.5g, place %.5g, bounds %.3g %% and %.3g %% L, correlation %.4f\n",
            relative, k + 1, right[2 * k], right[2 * k + 1],
            100.0 * std::sqrt(bound(2 * k, 2 * k)) / std::abs(right[2 * k]),
            100.0 * std::sqrt(bound(2 * k + 1, 2 * k + 1)) / c.truth.length(),
            bound(2 * k, 2 * k + 1) / std::sqrt(bound(2 * k, 2 * k) * bound(2 * k + 1, 2 * k + 1)));
      }
      for (const int allowed : {contacts, 2}) {
        if (allowed == 2 && contacts == 2 && relative > 0.0 && allowed != contacts) continue;
        for (const bool given : {true, false}) {
          const auto begin = std::chrono::steady_clock::now();
          const test::Campaign campaign = test::run_campaign(c.truth, 20, noise, given, allowed, runs, seed);
          const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
          std::printf("  noise %.2g L%s, at most %d contacts, %.1f ms each: %s", relative, given ? "" : " (not told)",
                      allowed, 1e3 * seconds / runs, campaign.text().c_str());
          std::fflush(stdout);
        }
        if (allowed == 2) break;
      }
    }
  }
  return 0;
}

#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

namespace tendril::bench {

/// How much is measured. `quick` finishes in well under two minutes and shows that everything works; its times decide
/// nothing.
struct Extent {
  bool quick = false;
  int repetitions = 0;              ///< 0: as the extent has it
  std::uint64_t seed = 1;           ///< of random starts
  std::uint64_t held_out = 0;       ///< of the extreme cases: seed of other numbers than those of the table; 0: its own
  std::string only;                 ///< of the extreme cases: those whose group or name holds this
  std::vector<std::string> scenes;  ///< files, put to the solvers besides the bench's own scenes
  const std::atomic<bool>* stop = nullptr;

  int repetitions_of_timed() const { return repetitions > 0 ? repetitions : quick ? 3 : 20; }
  bool stopped() const { return stop != nullptr && stop->load(); }
};

}  // namespace tendril::bench

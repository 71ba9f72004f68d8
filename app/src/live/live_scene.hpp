#pragma once

#include <atomic>
#include <mutex>
#include <optional>

#include "live/controls.hpp"

namespace tendril::app {

/// What a page got wrong, or asked for too late.
struct LiveAnswer {
  int status = 200;  ///< as in HTTP: 200, 400 (what was asked for cannot be done, "error" says why), 409 (out of date)
  Json body;
};

/// The scene behind a live page. Every plan is made as the command makes it: the scene's text, settings on top, a
/// session. For use by several threads: one plans at a time, and what is asked for last wins.
class LiveScene {
 public:
  /// Reads the scene. Throws InputError where `tendril plan` would.
  explicit LiveScene(const SceneArguments& arguments);

  /// What the page begins with: controls and an empty drawing.
  Json beginning() const { return beginning_; }
  /// Plans, follows from what was planned last, or executes. Whatever runs is ended, and its answer is out of date.
  LiveAnswer run(const Json& request);
  /// The scene's text with the settings of `request`.
  LiveAnswer scene_text(const Json& request) const;
  /// The result that was made last, if it is still the one that `request` means.
  LiveAnswer result_text(const Json& request);
  /// Ends whatever runs; nothing more is begun.
  void end();

 private:
  SceneArguments arguments_with(const Json& request) const;
  /// What was made for a request: the answer, the result behind it, and the plan to follow from.
  struct Made {
    Json body, result;
    std::optional<Plan> plan{};
  };
  Made make(Session& session, const Json& request) const;

  SceneArguments arguments_;
  std::vector<Control> controls_;
  std::string file_;  ///< as messages name it
  Json beginning_;
  std::atomic<std::int64_t> newest_{0};
  std::atomic<bool> stop_{false}, ended_{false};
  std::mutex running_;
  // Of the thread that holds running_.
  Json result_;
  std::int64_t result_number_ = 0;
  std::optional<Plan> last_;
};

}  // namespace tendril::app

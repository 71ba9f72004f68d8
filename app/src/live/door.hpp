#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "live/http.hpp"
#include "live/live_scene.hpp"

namespace tendril::app {

/// Decides what a live page's server answers: who may ask, how much, how often, and for what (docs/drawing.md).
class Door {
 public:
  static constexpr std::size_t largest_body = std::size_t{64} << 10;
  static constexpr double requests_per_second = 240.0;

  /// `token`: the first part of every path that is answered.
  Door(LiveScene& scene, std::string token) : scene_(scene), token_(std::move(token)) {}

  /// From now on; before, nobody is let in.
  void open(int port);
  http::Answer answer(const http::Request& request);

 private:
  bool too_fast();
  std::optional<http::Answer> refusal(const http::Request& request);
  http::Answer page() const;

  LiveScene& scene_;
  std::string token_;
  std::vector<std::string> hosts_;
  std::mutex counting_;
  double allowed_ = requests_per_second;
  std::chrono::steady_clock::time_point counted_ = std::chrono::steady_clock::now();
};

}  // namespace tendril::app

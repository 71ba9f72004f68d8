#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>

#include "scene/curves.hpp"
#include "tendril/error.hpp"

namespace tendril::app {

namespace {

class PathReader {
 public:
  explicit PathReader(std::string_view data) : data_(data) {}

  std::vector<CurvedLine> read() {
    skip();
    while (at_ < data_.size()) {
      const char letter = data_[at_];
      if (std::string_view("MmLlHhVvCcSsQqTtAaZz").find(letter) == std::string_view::npos) {
        fail("a command such as M, L, C, Q, A or Z");
      }
      if (!begun_ && letter != 'M' && letter != 'm') fail("M, with which a path begins");
      ++at_;
      skip();
      take(letter);
    }
    finish();
    return std::move(lines_);
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    const std::string found = at_ < data_.size() ? fmt::format("'{}'", data_.substr(at_, 12)) : "its end";
    throw Error(fmt::format("found {} at character {} of a path, expected {}", found, at_ + 1, expected));
  }

  void skip() {
    while (at_ < data_.size() && std::string_view(" \t\r\n\f,").find(data_[at_]) != std::string_view::npos) ++at_;
  }

  bool more() const {
    return at_ < data_.size() && std::string_view("0123456789+-.").find(data_[at_]) != std::string_view::npos;
  }

  double number() {
    std::size_t begin = at_;
    if (begin < data_.size() && data_[begin] == '+') ++begin;
    double value = 0.0;
    const auto [end, error] = std::from_chars(data_.data() + begin, data_.data() + data_.size(), value);
    if (error != std::errc{} || !std::isfinite(value)) fail("a number");
    at_ = static_cast<std::size_t>(end - data_.data());
    skip();
    return value;
  }

  /// Flags of an arc may stand without anything between them.
  bool flag() {
    if (at_ >= data_.size() || (data_[at_] != '0' && data_[at_] != '1')) fail("a flag of an arc, 0 or 1");
    const bool set = data_[at_++] == '1';
    skip();
    return set;
  }

  Vec2 point(bool relative) {
    const double x = number();
    const double y = number();
    return relative ? now_ + Vec2{x, y} : Vec2{x, y};
  }

  void go(const Cubic& c) {
    line_.push_back(c);
    now_ = c[3];
  }

  void finish() {
    if (!line_.empty()) lines_.push_back(std::move(line_));
    line_.clear();
  }

  void take(char letter) {
    const bool relative = letter >= 'a';
    const char command = relative ? static_cast<char>(letter - 'a' + 'A') : letter;
    if (command == 'Z') {
      if (!line_.empty() && !(now_ == first_)) go(straight(now_, first_));
      finish();
      now_ = first_;
      last_ = 'Z';
      return;
    }
    bool first = true;
    do {
      take_one(first || command != 'M' ? command : 'L', relative);
      first = false;
    } while (more());
  }

  void take_one(char command, bool relative) {
    // The control point that S and T mirror: that of the curve before, if it was of their kind.
    const Vec2 mirrored = now_ + (now_ - control_);
    switch (command) {
      case 'M':
        finish();
        now_ = first_ = point(relative);
        begun_ = true;
        break;
      case 'L':
        go(straight(now_, point(relative)));
        break;
      case 'H': {
        const double x = number();
        go(straight(now_, {relative ? now_.x + x : x, now_.y}));
        break;
      }
      case 'V': {
        const double y = number();
        go(straight(now_, {now_.x, relative ? now_.y + y : y}));
        break;
      }
      case 'C':
      case 'S': {
        const Vec2 from = now_;
        const Vec2 a = command == 'C' ? point(relative) : last_ == 'C' || last_ == 'S' ? mirrored : now_;
        const Vec2 b = point(relative);
        const Vec2 to = point(relative);
        go({from, a, b, to});
        control_ = b;
        break;
      }
      case 'Q':
      case 'T': {
        const Vec2 from = now_;
        const Vec2 a = command == 'Q' ? point(relative) : last_ == 'Q' || last_ == 'T' ? mirrored : now_;
        const Vec2 to = point(relative);
        go({from, from + (2.0 / 3.0) * (a - from), to + (2.0 / 3.0) * (a - to), to});
        control_ = a;
        break;
      }
      default:
        arc(relative);
    }
    last_ = command;
  }

  /// From where it stands to a point on an ellipse (SVG 1.1, F.6.5).
  void arc(bool relative) {
    double rx = std::abs(number());
    double ry = std::abs(number());
    const double turn = number() * std::numbers::pi / 180.0;
    const bool large = flag();
    const bool sweep = flag();
    const Vec2 from = now_;
    const Vec2 to = point(relative);
    if (from == to) return;
    if (rx == 0.0 || ry == 0.0) return go(straight(from, to));
    const Vec2 axis{std::cos(turn), std::sin(turn)};
    const Vec2 half = 0.5 * (from - to);
    Vec2 p{dot(axis, half) / rx, cross(axis, half) / ry};
    const double square = dot(p, p);
    if (square > 1.0) {
      // An ellipse that is too small is grown until it reaches.
      rx *= std::sqrt(square);
      ry *= std::sqrt(square);
      p = (1.0 / std::sqrt(square)) * p;
    }
    const double away = std::sqrt(std::max(0.0, 1.0 / dot(p, p) - 1.0)) * (large == sweep ? -1.0 : 1.0);
    const Vec2 c{away * p.y, -away * p.x};
    const double begin = std::atan2(p.y - c.y, p.x - c.x);
    double end = std::atan2(-p.y - c.y, -p.x - c.x);
    if (sweep && end < begin) end += 2.0 * std::numbers::pi;
    if (!sweep && end > begin) end -= 2.0 * std::numbers::pi;
    const Vec2 center = 0.5 * (from + to) + (c.x * rx) * axis + (c.y * ry) * turned(axis);
    CurvedLine curves;
    add_arc(curves, center, rx * axis, ry * turned(axis), begin, end);
    curves.front()[0] = from;
    curves.back()[3] = to;
    for (const Cubic& curve : curves) go(curve);
  }

  std::string_view data_;
  std::size_t at_ = 0;
  bool begun_ = false;
  char last_ = 'M';
  Vec2 now_{}, first_{}, control_{};
  CurvedLine line_;
  std::vector<CurvedLine> lines_;
};

}  // namespace

std::vector<CurvedLine> lines_of_path(std::string_view data) { return PathReader(data).read(); }

}  // namespace tendril::app

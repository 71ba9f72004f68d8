#include "scene/stl_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "system/input_file.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/numbers.hpp"

namespace tendril::app {

namespace {

using Point = std::array<double, 3>;
using Triangle = std::array<Point, 3>;

constexpr std::size_t header = 80, count_size = 4, facet_size = 50, normal_size = 12, block_size = 1 << 16;

/// Tells `take` each facet of a binary file, of which the count of facets was read.
template <class Take>
void binary_facets(InputFile& file, const std::filesystem::path& path, const Take& take) {
  std::vector<char> block(block_size / facet_size * facet_size);
  while (const std::size_t size = file.read(block)) {
    if (size % facet_size != 0) throw InputError(path.string() + ": the file ends within a facet");
    for (std::size_t at = 0; at < size; at += facet_size) {
      std::array<float, 9> numbers{};
      std::memcpy(numbers.data(), block.data() + at + normal_size, sizeof numbers);
      Triangle facet;
      for (std::size_t k = 0; k < 9; ++k) facet[k / 3][k % 3] = static_cast<double>(numbers[k]);
      take(facet);
    }
  }
}

/// The words of a text that is read piece by piece.
class Words {
 public:
  /// `begin`: what was read already.
  Words(InputFile& file, std::string begin) : file_(file), block_(std::move(begin)) {}

  /// Empty at the end.
  const std::string& next() {
    word_.clear();
    std::optional<char> c = character();
    for (; c && is_blank(*c); c = character()) line_ += *c == '\n' ? 1 : 0;
    for (; c && !is_blank(*c); c = character()) word_ += *c;
    if (c) --at_;
    return word_;
  }
  int line() const { return line_; }

 private:
  static bool is_blank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
  std::optional<char> character() {
    if (at_ == block_.size()) {
      block_.resize(block_size);
      block_.resize(file_.read(block_));
      at_ = 0;
      if (block_.empty()) return std::nullopt;
    }
    return block_[at_++];
  }

  InputFile& file_;
  std::string block_, word_;
  std::size_t at_ = 0;
  int line_ = 1;
};

template <class Take>
void text_facets(Words words, const std::filesystem::path& path, const Take& take) {
  Triangle facet;
  std::size_t vertices = 0;
  for (const std::string* word = &words.next(); !word->empty(); word = &words.next()) {
    if (*word != "vertex") continue;
    for (double& number : facet[vertices % 3]) {
      const std::string& found = words.next();
      std::string_view digits = found;
      if (digits.starts_with('+')) digits.remove_prefix(1);
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
      if (error != std::errc{} || end != digits.data() + digits.size()) {
        throw InputError(
            fmt::format("{}:{}: found '{}', expected a number of a vertex", path.string(), words.line(), found));
      }
    }
    if (++vertices % 3 == 0) take(facet);
  }
  if (vertices % 3 != 0) {
    throw InputError(fmt::format("{}: found {} vertices, expected three for each facet", path.string(), vertices));
  }
}

template <class Take>
void each_facet(const std::filesystem::path& path, const Take& take) {
  InputFile file(path, "obstacle.file", largest_body);
  std::string begin(header + count_size, '\0');
  begin.resize(file.read(begin));
  // A binary file says how many facets follow, which is the only thing that tells it from a text that begins alike.
  if (begin.size() == header + count_size) {
    std::uint32_t count = 0;
    std::memcpy(&count, begin.data() + header, count_size);
    if (file.size() == begin.size() + std::size_t{count} * facet_size) return binary_facets(file, path, take);
  }
  if (!begin.starts_with("solid")) {
    throw InputError(path.string() +
                     ": found neither an STL in text, which begins with \"solid\", nor a binary one of the length that "
                     "its number of facets asks for");
  }
  text_facets({file, std::move(begin)}, path, take);
}

/// Where triangles cross the plane: stretches with the body on their left.
class Section {
 public:
  Section(char axis, double height, double unit)
      : up_(static_cast<std::size_t>(axis - 'x')), height_(height), unit_(unit) {}

  void add(const Triangle& triangle) {
    std::optional<Vec2> upwards;
    std::optional<Vec2> downwards;
    for (std::size_t i = 0; i < 3; ++i) {
      const Point& a = triangle[i];
      const Point& b = triangle[(i + 1) % 3];
      // A point on the plane counts as above it, so that every triangle around it agrees.
      const bool a_above = above(a);
      if (a_above == above(b)) continue;
      // Both triangles at an edge get the same point to the last digit.
      (a_above ? downwards : upwards) = a_above ? crossing(b, a) : crossing(a, b);
    }
    // Corners run counterclockwise as seen from outside: the body lies on the left of the way from where an edge goes
    // down to where one goes up.
    if (!upwards || !downwards || *upwards == *downwards) return;
    ends_[key(*downwards)].push_back(*upwards);
  }

  std::vector<Outline> outlines(const std::filesystem::path& path) {
    std::vector<Outline> all;
    for (auto& [from, ends] : ends_) {
      while (!ends.empty()) {
        Outline line;
        Vec2 at{from.first, from.second};
        do {
          const auto next = ends_.find(key(at));
          if (next == ends_.end() || next->second.empty()) {
            throw InputError(fmt::format("{}: the body is not closed at the section: a side ends at ({} m, {} m)",
                                         path.string(), shown(at.x), shown(at.y)));
          }
          line.push_back(at);
          at = next->second.back();
          next->second.pop_back();
        } while (key(at) != from);
        all.push_back(std::move(line));
      }
    }
    return all;
  }

 private:
  static std::pair<double, double> key(Vec2 p) { return {p.x, p.y}; }
  bool above(const Point& p) const { return unit_ * p[up_] >= height_; }

  Vec2 crossing(const Point& low, const Point& high) const {
    const double t = (height_ - unit_ * low[up_]) / (unit_ * high[up_] - unit_ * low[up_]);
    const std::size_t x = (up_ + 1) % 3;
    const std::size_t y = (up_ + 2) % 3;
    if (t == 1.0) return {unit_ * high[x], unit_ * high[y]};  // all edges to a point on the plane meet there
    return {unit_ * (low[x] + t * (high[x] - low[x])), unit_ * (low[y] + t * (high[y] - low[y]))};
  }

  std::size_t up_;
  double height_, unit_;
  std::map<std::pair<double, double>, std::vector<Vec2>> ends_;
};

}  // namespace

std::vector<Outline> read_stl_section(const std::filesystem::path& path, char axis, double height, double unit) {
  Section section(axis, height, unit);
  double low = infinity;
  double high = -infinity;
  std::size_t facets = 0;
  each_facet(path, [&](const Triangle& triangle) {
    ++facets;
    for (const Point& p : triangle) {
      const double along = unit * p[static_cast<std::size_t>(axis - 'x')];
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
        throw InputError(
            fmt::format("{}: facet {} has a vertex that is not finite, expected numbers", path.string(), facets));
      }
      low = std::min(low, along);
      high = std::max(high, along);
    }
    section.add(triangle);
  });
  if (!(low <= high)) throw InputError(path.string() + ": found no facets, expected those of a closed body");
  std::vector<Outline> lines = section.outlines(path);
  std::erase_if(lines, [](const Outline& line) { return line.size() < 3; });
  if (lines.empty()) {
    throw InputError(fmt::format("{}: found nothing at {} = {} m, expected a height between {} m and {} m",
                                 path.string(), axis, shown(height), shown(low), shown(high)));
  }
  return lines;
}

}  // namespace tendril::app

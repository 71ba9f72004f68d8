#include "figure/movie.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "figure/frame_figure.hpp"
#include "system/progress.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/input_error.hpp"
#include "tendril/app/interrupt.hpp"
#include "tendril/app/picture.hpp"
#include "tendril/app/process.hpp"

namespace tendril::app {

namespace {

constexpr std::size_t most_frames = 5000;
constexpr const char* frame_mark = "frame drawn";

/// As fast as a page plays, but a few frames are each looked at for a while.
double frames_per_second(std::size_t frames) { return std::clamp(static_cast<double>(frames) / 3.0, 1.0, 12.0); }

/// The script that draws all frames: into one file that moves, or into numbered ones.
std::string script_of(const FrameFigure& figure, std::size_t frames, const std::string& gif) {
  std::string script = "set encoding utf8\n" + figure.settings();
  const char* const terminal = gif.empty() ? "pngcairo" : "gif";
  script += fmt::format(
      "if (strstrt(GPVAL_TERMINALS, ' {0} ') == 0) {{ print 'this gnuplot cannot write {0}'; exit status 1 }}\n",
      terminal);
  script +=
      gif.empty()
          ? fmt::format(
                "set terminal pngcairo size {},{} font 'sans-serif,16' fontscale 2 linewidth 2 pointscale 2 "
                "rounded background '#ffffff'\n",
                2 * figure.width(), 2 * figure.height())
          : fmt::format(
                "set terminal gif animate delay {:.0f} loop 0 size {},{} font 'sans-serif,12' background "
                "'#ffffff'\nset output {}\n",
                std::round(100.0 / frames_per_second(frames)), figure.width(), figure.height(), gnuplot_file(gif));
  for (std::size_t i = 0; i < frames; ++i) {
    if (gif.empty()) script += fmt::format("set output './frame-{:05}.png'\n", i);
    script += figure.draw(i, true) + fmt::format("print '{}'\n", frame_mark);
  }
  return script + "unset output\n";
}

/// Runs a program that makes the movie, or its frames.
void run_program(const std::string& program, const std::vector<std::string>& arguments, const StagedFiles& files,
                 std::size_t frames, const ProcessWatch& watch) {
  const ProcessResult result =
      run_process(program, arguments, files.staging(), 60.0 + static_cast<double>(frames), watch);
  if (watch.stop != nullptr && *watch.stop) throw InputError("no movie: interrupted");
  if (!result.started) throw InputError("no movie: " + program + " cannot be started");
  if (result.timed_out) throw InputError("no movie: " + program + " did not end in time");
  if (result.exit_code == 0) return;
  std::string said;
  for (std::size_t at = 0; at < result.output.size();) {
    const std::size_t end = std::min(result.output.find('\n', at), result.output.size());
    const std::string line = result.output.substr(at, end - at);
    if (line != frame_mark) said += '\n' + line;
    at = end + 1;
  }
  throw InputError("no movie: " + program + " failed" + (said.empty() ? "" : ":") + said);
}

}  // namespace

bool is_movie(const std::filesystem::path& file) { return file.extension() == ".gif" || file.extension() == ".mp4"; }

void require_movie(const std::filesystem::path& file) {
  require_name(file, "movie");
  if (!is_movie(file)) {
    throw InputError("found the movie '" + file.filename().string() + "', expected a name that ends in .gif or .mp4");
  }
  if (!program_found("gnuplot")) throw InputError("no movie: gnuplot, which draws it, is not installed");
  if (file.extension() == ".mp4" && !program_found("ffmpeg")) {
    throw InputError("no movie: ffmpeg, which writes .mp4, is not installed; expected it, or a name that ends in .gif");
  }
}

void write_movie(const std::filesystem::path& file, const Json& drawing, const std::atomic<bool>* stop) {
  require_movie(file);
  const std::size_t frames = drawing["frames"].size();
  if (frames < 2) {
    throw InputError(
        "no movie: the result has one frame, expected a trajectory, an execution of way points or with snaps, or a "
        "study");
  }
  if (frames > most_frames) {
    throw InputError(fmt::format("no movie: found {} frames, expected at most {}", frames, most_frames));
  }
  const std::string name = file.filename().string();
  const bool gif = file.extension() == ".gif";
  std::vector<std::size_t> all(frames);
  for (std::size_t i = 0; i < frames; ++i) all[i] = i;
  const FrameFigure figure(drawing, all, "'./movie.dat'");
  StagedFiles files(file.parent_path());
  files.write_aside("movie.dat", figure.data());
  files.write_aside("movie.gnuplot", script_of(figure, frames, gif ? name : ""));
  std::optional<InterruptGuard> interrupt;
  std::optional<Progress> progress;
  if (stop == nullptr) {
    stop = &interrupt.emplace().flag();
    progress.emplace("movie", "frames", frames, 0);
  }
  std::string unread;
  ProcessWatch watch{{}, stop};
  watch.on_output = [&](std::string_view text) {
    unread += text;
    for (std::size_t end = unread.find('\n'); end != std::string::npos; end = unread.find('\n')) {
      if (progress && unread.compare(0, end, frame_mark) == 0) progress->step(false);
      unread.erase(0, end + 1);
    }
  };
  // -d: a user's own start-up file would change the picture.
  run_program("gnuplot", {"-d", "./movie.gnuplot"}, files, frames, watch);
  if (!gif) {
    watch.on_output = {};
    run_program("ffmpeg",
                {"-loglevel", "error", "-y", "-framerate", fmt::format("{:.3f}", frames_per_second(frames)), "-i",
                 "./frame-%05d.png", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "./" + name},
                files, frames, watch);
  }
  files.adopt(name);
  files.publish();
}

}  // namespace tendril::app

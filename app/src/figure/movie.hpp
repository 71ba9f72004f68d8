#pragma once

#include <atomic>
#include <filesystem>

#include "result/result_object.hpp"

namespace tendril::app {

/// Whether a file name asks for a movie.
bool is_movie(const std::filesystem::path& file);
/// Throws InputError if the file's name asks for none, or what makes it is not installed.
void require_movie(const std::filesystem::path& file);
/// Writes the frames of a drawing one after the other: .gif by gnuplot alone, .mp4 by ffmpeg from gnuplot's pictures.
/// Throws InputError, and leaves no file behind, where that cannot be done. `stop` ends it; without one Ctrl-C does,
/// and a terminal shows how far it is.
void write_movie(const std::filesystem::path& file, const Json& drawing, const std::atomic<bool>* stop = nullptr);

}  // namespace tendril::app

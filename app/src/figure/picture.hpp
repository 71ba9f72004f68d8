#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "result/result_object.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/picture.hpp"

namespace tendril::app {

/// Pictures of a drawing by gnuplot: all steps of a trajectory, the last frame of anything else. Writes `stem`.svg,
/// .png or .pdf, and beside them the script `stem`.gnuplot and its data `stem`.dat. Throws InputError if gnuplot is
/// missing or fails, or the drawing is of a study, whose figure is made of more.
void draw_pictures(const Json& drawing, StagedFiles& files, const std::string& stem,
                   const std::vector<Picture>& pictures);

/// Writes the one picture, page or movie that a file name asks for. `stop`: as for write_movie().
void write_picture(const std::filesystem::path& file, const Json& drawing, const std::atomic<bool>* stop = nullptr);

}  // namespace tendril::app

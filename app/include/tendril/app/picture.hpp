#pragma once

#include <filesystem>
#include <string>

namespace tendril::app {

/// A page holds the drawing and what shows it (figure/page.hpp); the others are made by gnuplot.
enum class Picture { svg, png, pdf, page };

/// `text` as a string of a gnuplot script: in single quotes, where nothing is expanded. Control characters become
/// blanks and quotes typographic ones: gnuplot 5.4 ends a string too early where doubled quotes stand at its beginning
/// or in a row.
std::string gnuplot_string(const std::string& text);

/// The kind of picture that a file name asks for. Throws InputError if it ends in none of .svg, .png, .pdf and .html or
/// cannot be written down in a script.
Picture picture_of(const std::filesystem::path& file);
/// Throws InputError if the name of the file, a `what`, cannot be written down in a script.
void require_name(const std::filesystem::path& file, const std::string& what);

}  // namespace tendril::app

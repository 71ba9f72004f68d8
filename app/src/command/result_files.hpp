#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tendril/app/commands.hpp"
#include "tendril/app/files.hpp"
#include "tendril/app/picture.hpp"

namespace tendril::app {

/// A result in its forms, each made when it is needed.
struct ResultForms {
  std::function<std::string()> json;
  std::function<std::string()> report;
  std::string no_shape{};  ///< what is said where nothing is there to be drawn
  /// Draws what is no drawing's, or says that there is no shape; empty: the drawing of the JSON is drawn.
  std::function<bool(StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures)> draw{};
};

/// What cannot be written had better be known before the work begins. Throws InputError.
void try_places(const ResultPlaces& places);
/// Writes the result's files. Without its picture it is still a result: why there is none is returned.
std::vector<std::string> write_result(const ResultPlaces& places, const ResultForms& forms, Session& session);
/// Writes and prints the result.
void give_result(const ResultPlaces& places, const ResultForms& forms, Session& session);

}  // namespace tendril::app

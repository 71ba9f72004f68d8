#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tendril/app/commands.hpp"
#include "tendril/app/figure.hpp"

namespace tendril::app {

/// A result in its forms, each made when it is needed. An empty `draw`: there is no shape, as `no_shape` says.
struct ResultForms {
  std::function<std::string()> json;
  std::function<std::string()> report;
  std::function<void(StagedFiles& files, const std::string& stem, const std::vector<Picture>& pictures)> draw;
  std::string no_shape{};
};

/// What cannot be written had better be known before the work begins. Throws InputError.
void try_places(const ResultPlaces& places);
/// Writes and prints the result. Without its picture it is still a result: that is only noted.
void give_result(const ResultPlaces& places, const ResultForms& forms, Session& session);

}  // namespace tendril::app

#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tendril/app/document.hpp"
#include "tendril/app/units.hpp"
#include "tendril/scene.hpp"
#include "tendril/sensitivity.hpp"

namespace tendril::app {

/// The keys of numbers that a result may depend on, in the order of the document.
std::vector<std::string> number_keys(const Document& document);

/// How a key of the document moves the numbers of its scene, per SI unit of the key; its deviation is 0. Found by
/// reading the scene with other values: what a reader makes of a number is a polynomial of it, fourth powers of
/// diameters at most, whose derivative a difference of five points gives exactly. Throws InputError where the key is no
/// number, or none that a result depends on.
Spread spread_of(const Document& document, const Scene& scene, const std::string& key);

/// Under held inputs a moment follows its law: adds what a number of such a law does to "moments[i]". `moments`: N m,
/// one per actuator.
void follow_held_inputs(const Scene& scene, const std::vector<double>& moments, Spread& spread);

/// All numbers of the document with error bars. Throws InputError with the place.
std::vector<Spread> error_bars(const Document& document, const Scene& scene);

/// What a table calls the value of a key: its text.
std::string written_value(const Document& document, const std::string& key);

}  // namespace tendril::app

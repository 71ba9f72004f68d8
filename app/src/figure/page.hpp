#pragma once

#include <string>

#include "result/result_object.hpp"

namespace tendril::app {

/// A page that shows a drawing: one file with everything in it, which asks for nothing from anywhere.
std::string drawing_page(const Json& drawing);

}  // namespace tendril::app

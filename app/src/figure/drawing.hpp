#pragma once

#include <string>

#include "result/result_object.hpp"
#include "tendril/plugins/registry.hpp"

namespace tendril::app {

/// What there is to see of a result, as one JSON document (docs/drawing.md): a frame for each step, state beside a
/// snap, or case. Of the result alone: obstacles are made anew, by the components of `registry`. `file` names the
/// result in messages. Throws InputError where it is not such a result.
Json drawing_of(const Json& result, const std::string& file, plugins::Registry& registry);

/// Whether a frame of the drawing has a rod.
bool has_shape(const Json& drawing);

}  // namespace tendril::app

#pragma once

#include <optional>

#include "tendril/app/session.hpp"
#include "tendril/estimate_sequence.hpp"

namespace tendril::app {

/// The frames of a scene whose file of points has several; nothing: a single shape. Throws InputError.
std::optional<SequenceSpec> sequence_of(const Session& session);

/// Follows contacts through them until the time limit. No plugin is opened. Throws InputError.
SequenceEstimate estimate_sequence(const Session& session, const SequenceSpec& spec, const std::atomic<bool>& stop,
                                   const SequenceProgress& progress = {});

}  // namespace tendril::app

#include "session/sequence.hpp"

#include "scene/measurement_reader.hpp"
#include "tendril/error.hpp"

namespace tendril::app {

std::optional<SequenceSpec> sequence_of(const Session& session) {
  return read_sequence(session.document(), session.units(), session.scene());
}

SequenceEstimate estimate_sequence(const Session& session, const SequenceSpec& spec, const std::atomic<bool>& stop,
                                   const SequenceProgress& progress) {
  PlanControl control;
  control.stop = &stop;
  try {
    SequenceEstimate out = tendril::estimate_sequence(session.scene(), spec, control, progress);
    out.left_out.insert(out.left_out.end(), session.dropped().begin(), session.dropped().end());
    return out;
  } catch (const SceneError& error) {
    session.document().fail(session.document().find(error.path()), error.what());
  }
}

}  // namespace tendril::app

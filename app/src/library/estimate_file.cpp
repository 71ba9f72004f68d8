#include "tendril/files/estimate_file.hpp"

#include <optional>

#include "library/arguments.hpp"
#include "result/estimate_report.hpp"
#include "result/sequence_report.hpp"
#include "session/sequence.hpp"

namespace tendril::files {

std::string estimate_json(const SceneSource& source, const Run& run) {
  app::Session session(arguments_of(source));
  session.stop_by(stop_of(run.stop));
  if (const std::optional<SequenceSpec> sequence = app::sequence_of(session)) {
    const SequenceEstimate estimate = app::estimate_sequence(session, *sequence, stop_of(run.stop));
    return app::sequence_json(session.scene(), *sequence, estimate, session.run_info());
  }
  const Estimate estimate = session.estimate();
  return app::estimate_json(session.scene(), estimate, session.run_info());
}

}  // namespace tendril::files

#include "tendril/files/study_file.hpp"

#include "library/arguments.hpp"
#include "study/run.hpp"
#include "tendril/app/input_error.hpp"

namespace tendril::files {

class StudyCases::Opened {
 public:
  explicit Opened(const SceneSource& source) : cases(arguments_of(source)) {}
  app::StudyCases cases;
};

StudyCases::StudyCases(const SceneSource& source) : opened_(std::make_unique<Opened>(source)) {}
StudyCases::~StudyCases() = default;

std::string StudyCases::answer(int index, const std::atomic<bool>* stop) {
  opened_->cases.session().stop_by(stop_of(stop));
  std::string answer = opened_->cases.answer(index);
  if (stop_of(stop)) throw app::InputError("study: interrupted");
  return answer;
}

class Study::Opened {
 public:
  Opened(const SceneSource& source, const StudyPlaces& places) : run(arguments_of(source), places) {}
  app::StudyRun run;
};

Study::Study(const SceneSource& source, const StudyPlaces& places)
    : opened_(std::make_unique<Opened>(source, places)) {}
Study::~Study() = default;

std::vector<std::string> Study::warnings() const { return opened_->run.cases().scene().warnings; }
std::vector<int> Study::waiting() const { return opened_->run.waiting(); }
std::size_t Study::finished() const { return opened_->run.finished(); }
void Study::take(int index, const std::string& answer) { opened_->run.take(index, answer); }
void Study::lost(int index, const std::string& reason) { opened_->run.lost(index, reason); }
bool Study::one_shard() const { return opened_->run.shard().count == 1; }

Study::Finished Study::finish(const std::atomic<bool>* stop) {
  app::StudyRun::Finished finished = opened_->run.finish(&stop_of(stop));
  return {std::move(finished.json), std::move(finished.notes)};
}

}  // namespace tendril::files

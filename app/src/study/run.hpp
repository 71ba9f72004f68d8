#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "study/journal.hpp"
#include "tendril/app/session.hpp"
#include "tendril/app/study.hpp"
#include "tendril/app/study_command.hpp"

namespace tendril::app {

/// The cases of the study that a scene declares, and what each of them comes to.
class StudyCases {
 public:
  /// Throws InputError where the scene is wrong.
  explicit StudyCases(const SceneArguments& arguments);
  /// Throws InputError for cases that no scene could hold: they are better found before any is begun.
  void check();

  Session& session() { return session_; }
  const Scene& scene() const { return scene_; }  ///< of the file
  const StudySpec& study() const { return study_; }
  const std::vector<StudyCase>& all() const { return cases_; }
  /// Of everything that the numbers depend on and a user can change.
  std::uint64_t fingerprint() const { return fingerprint_; }
  /// Plans and executes a case; what came of it as one line, without its line feed, for StudyRun::take().
  std::string answer(int index);

 private:
  std::uint64_t fingerprint_;
  Session session_;
  Scene scene_;
  StudySpec study_;
  std::vector<StudyCase> cases_;
};

/// Which of `count` parts of the cases.
struct Shard {
  int number = 1;
  int count = 1;
  bool holds(int index) const { return index % count == number - 1; }
};

/// A study under way: which cases are finished, where they are kept, and what is made of them in the end. Who computes
/// the waiting ones, here or in other processes, is not its business.
class StudyRun {
 public:
  /// Takes up what an earlier run has left in the output directory. Throws InputError, also for what cannot be written.
  StudyRun(const SceneArguments& arguments, const StudyPlaces& places);

  StudyCases& cases() { return cases_; }
  /// Those of this shard that are not finished.
  std::vector<int> waiting() const;
  std::size_t finished() const { return records_.size(); }
  /// Keeps an answer(). Throws InputError if it is none of this case.
  void take(int index, const std::string& answer);
  /// Keeps that a case came to nothing.
  void lost(int index, const std::string& reason);
  const Shard& shard() const { return shard_; }

  /// What a study has come to.
  struct Finished {
    std::string json, report;
    bool solved = false;             ///< every case has a certified plan
    std::vector<std::string> notes;  ///< why there is no picture
  };
  /// Writes the final files, once no case of any shard is waiting. `stop` ends a movie.
  Finished finish(const std::atomic<bool>* stop = nullptr);

 private:
  void keep(StudyRecord record);

  StudyPlaces places_;
  Shard shard_;
  StudyCases cases_;
  std::optional<Journal> journal_;
  std::map<int, StudyRecord> records_;
};

}  // namespace tendril::app

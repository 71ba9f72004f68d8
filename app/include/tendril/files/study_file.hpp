#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tendril/files/scene_file.hpp"

namespace tendril::files {

/// Which part of a study is asked for, and where it goes.
struct StudyPlaces {
  std::optional<std::filesystem::path> output{};  ///< a directory; without it nothing can be resumed
  std::optional<std::filesystem::path> figure{};  ///< file of the figure alone
  std::optional<std::filesystem::path> movie{};   ///< file of a movie, a frame for each case
  std::string shard{};                            ///< "i/N"; empty: all cases
  bool merge = false;                             ///< only join the shards in `output`
};

/// The cases of the study that a scene declares, to be computed. Several processes may each have one. Not for
/// concurrent use.
class TENDRIL_API StudyCases {
 public:
  explicit StudyCases(const SceneSource& source);  ///< Throws Error.
  ~StudyCases();
  StudyCases(const StudyCases&) = delete;
  StudyCases& operator=(const StudyCases&) = delete;

  /// Plans and executes a case of Study::waiting(); one line for Study::take(). What a case throws becomes its answer.
  /// Throws Error where `stop` ended it.
  std::string answer(int index, const std::atomic<bool>* stop = nullptr);

 private:
  class Opened;
  std::unique_ptr<Opened> opened_;
};

/// `tendril study`: which cases are finished, where they are kept, and what is made of them. Whoever has it computes
/// the waiting ones, here or in other processes, in any order.
class TENDRIL_API Study {
 public:
  /// Takes up what an earlier run has left in the output directory. Throws Error.
  Study(const SceneSource& source, const StudyPlaces& places);
  ~Study();
  Study(const Study&) = delete;
  Study& operator=(const Study&) = delete;

  std::vector<std::string> warnings() const;        ///< Of the scene.
  std::vector<int> waiting() const;                 ///< Cases of this shard that are not finished.
  std::size_t finished() const;                     ///< How many cases are.
  void take(int index, const std::string& answer);  ///< Keeps an answer. Throws Error if it is none of this case.
  void lost(int index, const std::string& reason);  ///< Keeps that a case came to nothing.
  bool one_shard() const;                           ///< Else others hold the rest, and a merge finishes the study.

  /// What a study has come to.
  struct Finished {
    std::string json;                ///< the document of docs/results.md
    std::vector<std::string> notes;  ///< why there is no picture
  };
  /// Writes the final files, once nothing waits. `stop` ends a movie. Throws Error.
  Finished finish(const std::atomic<bool>* stop = nullptr);

 private:
  class Opened;
  std::unique_ptr<Opened> opened_;
};

}  // namespace tendril::files

#pragma once

#include <stdexcept>
#include <string>

#include "tendril/export.hpp"

namespace tendril {

/// What core throws when it is given something that it cannot work with. The message is for a user: it says what was
/// found and what was expected.
class TENDRIL_API Error : public std::runtime_error {
 public:
  /// `message` is for a user.
  explicit Error(const std::string& message);
  Error(const Error&) = default;  ///< as exceptions are
  ~Error() override;
};

/// A defect in the data of a scene. `path` names the key, for instance "obstacle[0].radius"; whoever read the scene
/// from a file adds file, line and column.
class TENDRIL_API SceneError : public Error {
 public:
  /// `path` names the key.
  SceneError(std::string path, const std::string& message);
  SceneError(const SceneError&) = default;  ///< as exceptions are
  ~SceneError() override;

  /// The key.
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace tendril

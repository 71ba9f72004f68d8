#pragma once

#include <stdexcept>
#include <string>

#include "tendril/export.hpp"

namespace tendril {

/// What core throws when it is given something that it cannot work with. The message is for a user: it says what was
/// found and what was expected.
class TENDRIL_API Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message);
  Error(const Error&) = default;
  ~Error() override;
};

/// A defect in the data of a scene. `path` names the key, for instance "obstacle[0].radius"; whoever read the scene
/// from a file adds file, line and column.
class TENDRIL_API SceneError : public Error {
 public:
  SceneError(std::string path, const std::string& message);
  SceneError(const SceneError&) = default;
  ~SceneError() override;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace tendril

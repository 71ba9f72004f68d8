#include "tendril/error.hpp"

#include <utility>

namespace tendril {

Error::Error(const std::string& message) : std::runtime_error(message) {}
Error::~Error() = default;

SceneError::SceneError(std::string path, const std::string& message) : Error(message), path_(std::move(path)) {}
SceneError::~SceneError() = default;

}  // namespace tendril

#include "trust.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace tendril::plugins {

namespace {

std::string distrust_one(const std::filesystem::path& path, bool sticky_is_enough) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return path.string() + ": " + std::strerror(errno);
  // In a sticky directory nobody but its owner can replace what others put there, so the owner counts there as well.
  if (status.st_uid != 0 && status.st_uid != ::geteuid()) {
    return path.string() + " belongs to user " + std::to_string(status.st_uid) + ", neither to root nor to you";
  }
  const bool sticky = sticky_is_enough && (status.st_mode & S_ISVTX) != 0;
  if ((status.st_mode & S_IWOTH) != 0 && !sticky) return path.string() + " can be written by everybody";
  return "";
}

}  // namespace

std::string distrust(const std::filesystem::path& path, const std::filesystem::path& trusted_above) {
  std::string reason = distrust_one(path, false);
  // The directory that holds a library counts like the library itself: who may write there may replace it.
  bool may_be_sticky = std::filesystem::is_directory(path);
  for (auto above = path; reason.empty() && above != above.root_path();) {
    above = above.parent_path();
    if (above == trusted_above) break;
    reason = distrust_one(above, may_be_sticky);
    may_be_sticky = true;
  }
  return reason;
}

}  // namespace tendril::plugins

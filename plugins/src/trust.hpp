#pragma once

#include <filesystem>
#include <string>

namespace tendril::plugins {

/// Why a library or directory is not to be trusted: it, or a directory above it, can be written by everybody or belongs
/// to neither root nor the caller. Directories above may have the sticky bit instead, as a temporary directory has.
/// `path` must be free of links. The look upwards ends at `trusted_above` (not looked at itself) if that is a directory
/// above. Empty: trusted.
///
/// This guards against accidents. It is no border against an attacker: files can change after the look.
std::string distrust(const std::filesystem::path& path, const std::filesystem::path& trusted_above = {});

}  // namespace tendril::plugins

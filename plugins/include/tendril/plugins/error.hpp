#pragma once

#include <string>
#include <utility>

#include "tendril/error.hpp"

/// How plugins are found, opened and asked for components.
namespace tendril::plugins {

/// Why a plugin cannot be had.
enum class Failure {
  not_found,           ///< no file of that name on the search path
  untrusted,           ///< the file, its directory or one above may be changed by others
  not_a_plugin,        ///< not a shared library, or one without tendril's two symbols
  missing_dependency,  ///< a library that the plugin needs is not there
  other_interface,     ///< built for another interface, compiler, Eigen or sanitizer
  wrong_component,     ///< registers nothing, several components, or another one than its file name says
  threw,               ///< an exception left the plugin while it registered or made its component
  failed               ///< the loader gave another reason
};

/// A plugin that is missing, refused or broken. The message names the file or every place tried, and the reason.
class PluginError : public Error {
 public:
  /// `message` is the reason too.
  PluginError(Failure failure, const std::string& message) : PluginError(failure, message, message) {}
  /// `reason` is the message without the file.
  PluginError(Failure failure, const std::string& message, std::string reason)
      : Error(message), failure_(failure), reason_(std::move(reason)) {}
  /// The kind of failure.
  Failure failure() const { return failure_; }
  /// The reason alone, where the file is named beside it.
  const std::string& reason() const { return reason_; }

 private:
  Failure failure_;
  std::string reason_;
};

}  // namespace tendril::plugins

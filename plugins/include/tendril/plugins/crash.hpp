#pragma once

#include <pthread.h>

namespace tendril::plugins {

/// From now on a crash of this process names the plugin in whose code it happens, if there is one, before the process
/// ends as it would have. Signals that somebody handles already stay theirs.
void name_plugin_in_crashes();

/// Ends the process with exit code 1 after so many seconds, naming the plugin that is running then.
void end_after(unsigned seconds);

/// Ends the process with exit code 1 now, naming the plugin that `thread` is running.
[[noreturn]] void end_while_running(pthread_t thread);

}  // namespace tendril::plugins

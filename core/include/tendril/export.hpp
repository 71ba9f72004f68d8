#pragma once

/// Marks a symbol that crosses the border of libtendril or of a plugin. Everything else is hidden.
#define TENDRIL_API __attribute__((visibility("default")))

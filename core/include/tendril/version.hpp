#pragma once

/// Version of the plugin interface and SOVERSION of libtendril. Rises when a plugin must be rebuilt.
#define TENDRIL_INTERFACE_VERSION 5
#define TENDRIL_VERSION "0.5.0"

#pragma once

/// Version of the plugin interface and SOVERSION of libtendril. Rises when a plugin must be rebuilt.
#define TENDRIL_INTERFACE_VERSION 6
#define TENDRIL_VERSION "0.6.0"

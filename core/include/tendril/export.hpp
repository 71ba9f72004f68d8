#pragma once

/// Plans poses, trajectories and grasps for planar elastic rods in contact.
namespace tendril {}

/// Marks a symbol that crosses the border of libtendril or of a plugin. Everything else is hidden.
#define TENDRIL_API __attribute__((visibility("default")))

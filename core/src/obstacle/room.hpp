#pragma once

#include "tendril/numbers.hpp"
#include "tendril/obstacle.hpp"

namespace tendril {

/// What an obstacle is besides that keeps room for a rod within its walls.
class Room {
 public:
  virtual ~Room() = default;
  /// How far `point` lies outside of the room, where walls stand in between; 0 in the room and where the way there is
  /// open; infinity: there is no room.
  virtual double outside_room(Vec2 point) const = 0;
};

/// The same of any obstacle.
inline double outside_room(const Obstacle& obstacle, Vec2 point) {
  const auto* room = dynamic_cast<const Room*>(&obstacle);
  return room == nullptr ? infinity : room->outside_room(point);
}

}  // namespace tendril

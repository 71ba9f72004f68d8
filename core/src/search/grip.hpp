#pragma once

#include <string>

#include "program/pose_program.hpp"
#include "tendril/plan.hpp"

namespace tendril {

struct Mode;
struct Task;

/// What a search asks about a rod that holds an object with its contact. The room `grasp` answers.
class Grip {
 public:
  virtual ~Grip() = default;
  /// How many starts of its own there are for each way of being in contact.
  virtual int starts() const = 0;
  /// One of them.
  virtual StartShape start(const Task& task, const Mode& mode, int index) const = 0;
  /// Why no contact of a rod whose part reaches up to `reach` (s/L) can hold the object; empty: nothing is known.
  virtual std::string obstruction(const Task& task, double reach) const = 0;
  /// Brings a plan of the program's frame into the world, and adds what only a grasp has. `program` is moved to x.
  virtual void finish(const Task& task, PoseProgram& program, ConstVectorRef x, Plan& plan) const = 0;
};

}  // namespace tendril

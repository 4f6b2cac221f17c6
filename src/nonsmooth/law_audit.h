// SPDX-License-Identifier: BSD-3-Clause
// Holds the forces that outputs show against the laws of friction, limits and contacts. It knows these laws only by
// their bounds, not how modes are decided, so that a wrong decision is found here.
#pragma once

#include <optional>
#include <span>

#include "dynamics/switching_forces.h"

namespace gelenk {

// Forces are solved for to some 1e-13 of the largest (ForceRounding::slack), and modes are decided within 1e-9 of a
// limit. What is wrong by a decision is wrong by far more than this fraction of a limit, or of the forces beside it.
inline constexpr double audited_fraction = 1e-6;
// Natural units: where hardly any forces act, all are rounding.
inline constexpr double least_audited_force = 1e-9;

struct BrokenLaw {
  enum class Kind {
    friction_exceeded,      // found: the friction; bound: what the law permits
    friction_along_motion,  // found: the friction; bound: the velocity
    latch_moves,            // found: the velocity of what an engaged lock of a joint holds
    limit_pulls,            // found: the force of the limit
    limit_not_reached,      // found: the force of the limit; bound: the distance from it
    limit_passed,           // bound: how far beyond it
    contact_pulls,          // found: the normal force
    contact_friction,       // found: the friction; bound: what the law permits
    contact_moment,         // found: the moment of friction; bound: what the law permits
    contact_approaches,     // found: the speed at which closed surfaces approach each other
  };
  Kind kind;
  int index;                    // of the force with modes; of the contact in the scene
  double found = 0, bound = 0;  // natural units, in the user's signs
};

// What goes furthest beyond its law.
class LawAudit {
 public:
  // excess: what is beyond the law, relative to what rounding and tolerances explain.
  void add(double excess, const BrokenLaw& law) {
    if (excess <= excess_) return;
    excess_ = excess;
    worst_ = law;
  }
  void add(const LawAudit& other) {
    if (other.worst_) add(other.excess_, *other.worst_);
  }
  double excess() const { return excess_; }
  // The law that is broken, if any is.
  std::optional<BrokenLaw> broken() const { return excess_ > 1 ? worst_ : std::nullopt; }

 private:
  double excess_ = 0;
  std::optional<BrokenLaw> worst_;
};

// Of the forces along joints. `switching_forces`: at the state, with velocities v (nv) and with inputs set. forces: by
// force with modes, in the user's signs, as output.
LawAudit audit_locks(const SwitchingForces& switching_forces, std::span<const double> forces, const double* v, int nv);
// Of an engaged lock of a joint in a time step, whose impulses have left its coordinate this speed; v: all velocities.
LawAudit audit_latch(const SwitchingForces& switching_forces, int lock, double speed, std::span<const double> v);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Whether a mechanism that comes near a singular configuration reaches it or narrowly misses it.
//
// At a singular configuration two branches of motion cross, and accelerations extrapolated from before keep to one of
// them (projection.cpp). A mechanism that misses it by little, as a four-bar whose links lie almost in line, moves on a
// hyperbola between the branches, whose asymptotes the extrapolation would follow: at the pivot fraction p their
// accelerations differ by something proportional to p^-3. The errors of an extrapolation grow less quickly, and
// rounding, which grows as quickly, is known in size. Three accepted states on the way in decide, each with half the
// pivot fraction of the one before, or less.
#pragma once

#include "util/archive.h"

namespace gelenk {

class SingularApproach {
 public:
  // No state is known.
  void clear() { *this = SingularApproach(); }
  // A state with this pivot fraction has been accepted at t.
  void pass(double t, double fraction);
  // The accelerations of the equations and the extrapolated ones differ by `deviation` at the accepted state; size: of
  // the latter; rounding: what may come from it.
  void compare(double fraction, double deviation, double size, double rounding);
  // After compare(): the projection onto the constraint equations has changed the kinetic energy of the accepted state
  // [J]. What contradicts the equations by more than rounding and loses energy misses the singular configuration.
  // tolerance: of the run.
  void remove_energy(double before, double after, double tolerance);
  // Where a step from t should end so that the next state can be compared [s].
  double end_of_step(double t) const;
  // Whether the mechanism narrowly misses the singular configuration.
  bool misses() const { return misses_; }

  void serialize(Archive& archive);

 private:
  static constexpr int needed = 3;

  double time_ = 0, fraction_ = 1, rate_ = 0;  // of the last accepted state; rate of the fraction before it [1/s]
  bool known_ = false;                         // there is one
  int compared_ = 0;
  double fractions_[needed] = {}, deviations_[needed] = {};
  bool decided_ = false, misses_ = false;
  bool contradicts_ = false;          // at the last state compared
  double removed_ = 0, largest_ = 0;  // kinetic energies [J]: in all; before
};

}  // namespace gelenk

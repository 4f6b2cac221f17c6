// SPDX-License-Identifier: BSD-3-Clause
// What limits do where something else displaces a mechanism, such as a prescribed motion whose value jumps: the least
// displacement and change of velocities, in the metric of the mass, by which no coordinate is beyond its limits, or
// moves beyond one that it touches.
#pragma once

#include <span>
#include <vector>

#include "dynamics/switching_forces.h"

namespace gelenk {

class LimitCorrection {
 public:
  explicit LimitCorrection(SwitchingForces& forces);

  bool empty() const { return limits_.empty(); }
  // Call before the displacement, with the velocities v then: what struck a limit then does so afterwards.
  void begin(const double* v);
  // dv (nv) <- the displacement that corrects the position, after a solve() there with nothing held; false: no
  // coordinate is beyond its limits.
  bool correct_position(std::span<double> dv);
  // Changes v, after a solve() at the position with nothing held.
  void correct_velocity(std::span<double> v);

 private:
  struct Limit {
    int lock = 0;
    bool approaches[2] = {};  // its lower, its upper limit before the displacement
  };
  bool strike(const std::vector<int>& locks, const std::vector<int>& sides, const std::vector<double>& beyond,
              std::span<double> change);

  SwitchingForces& forces_;
  std::vector<Limit> limits_;
};

}  // namespace gelenk

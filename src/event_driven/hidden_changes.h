// SPDX-License-Identifier: BSD-3-Clause
// Modes that end and begin again within a step, because of the time: conditions of expressions that read it, and what
// friction, limits and contacts hold against loads that depend on it. The error test does not see the time in them as
// long as they are without effect, so that steps may be longer than whole periods.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "dynamics/dynamics.h"
#include "event_driven/mode_equations.h"
#include "event_driven/state_course.h"

namespace gelenk {

// What is looked at within a step.
class ModeProbe {
 public:
  virtual ~ModeProbe() = default;
  virtual std::size_t count() const = 0;
  // How far the state y at t is from the ends of the held modes; negative: beyond them.
  virtual void distances(double t, const double* y, double* out) = 0;
  // Whether it is beyond one of them by more than rounding, of these last distances.
  virtual bool is_beyond(const double* distances) = 0;
};

class HiddenChanges {
 public:
  // size: of the state. largest: number of distances at most.
  HiddenChanges(Dynamics& dynamics, ModeEquations& equations, int size, std::size_t largest)
      : equations_(equations), course_(dynamics, size) {
    for (auto& distances : distances_) distances.reserve(largest);
  }

  // The first time found within a step at which a held mode has ended; infinite: none. fewest: number of places at
  // which to look at least. The state of `dynamics` is not that of an end of the step afterwards.
  double first(ModeProbe& probe, int fewest, double t0, const double* y0, double t1, const double* y1);

 private:
  // Of a search with n places: the fraction of the step at which a mode has ended, or infinite; and whether that may
  // have happened between places.
  struct Found {
    double place = 0;
    bool is_doubtful = false;
  };
  double search(ModeProbe& probe, int fewest, double t0, double t1);
  Found look(ModeProbe& probe, int places, double t0, double t1);
  bool may_change_between() const;

  ModeEquations& equations_;
  StateCourse course_;
  std::array<std::vector<double>, 3> distances_;  // at the last three places
};

}  // namespace gelenk

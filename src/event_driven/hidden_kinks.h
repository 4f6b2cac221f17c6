// SPDX-License-Identifier: BSD-3-Clause
// Conditions of expressions that read the time, and that change and change back within a step. The error test does not
// see the time in them as long as they are without effect, so that steps may be longer than whole periods.
#pragma once

#include <array>
#include <vector>

#include "dynamics/dynamics.h"
#include "event_driven/mode_equations.h"
#include "event_driven/state_course.h"

namespace gelenk {

class HiddenKinks {
 public:
  // size: of the state.
  HiddenKinks(Dynamics& dynamics, ModeEquations& equations, int nq, int size);

  // The first time found within a step at which the state is on other branches than the held ones; infinite: none.
  // Leaves `dynamics` at (t1, y1).
  double first(double t0, const double* y0, double t1, const double* y1);

 private:
  // Of a search with n places: the fraction of the step at which branches have changed, or infinite; and whether the
  // conditions may have changed between places.
  struct Found {
    double place = 0;
    bool is_doubtful = false;
  };
  double search(double t0, double t1);
  Found look(int places, double t0, double t1);
  void go_to(double t, const double* y);
  bool may_change_between() const;

  Dynamics& dynamics_;
  LawKinks& kinks_;
  ModeEquations& equations_;
  int nq_;
  StateCourse course_;
  std::array<std::vector<double>, 3> distances_;  // by kink: at the last three places
};

}  // namespace gelenk

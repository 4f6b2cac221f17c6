// SPDX-License-Identifier: BSD-3-Clause
// Where a mechanism stands still under given inputs.
#pragma once

#include <stdexcept>
#include <vector>

#include "analysis/tangent.h"

namespace gelenk {

// None was found; what stays at best.
class NoEquilibrium : public std::runtime_error {
 public:
  NoEquilibrium(int speed, double acceleration)
      : std::runtime_error("no equilibrium"), speed(speed), acceleration(acceleration) {}
  int speed;  // of the mechanism
  double acceleration;
};

struct Rest {
  std::vector<double> q;
  int steps = 0;
};

// Searched for from q, closed: the accelerations at rest are made small by Levenberg-Marquardt steps of the independent
// coordinates with exact derivatives, the loops closed after each (Nocedal & Wright, ch. 10). Whether what is found is
// stable is not asked. u: all inputs. cut_q: coordinates of cut joints, turns counted. targets: of the coordinate rows.
// Throws NoEquilibrium, and Undetermined and SingularMass from where derivatives do not exist.
Rest find_rest(const Mechanism& mechanism, const Loads& loads, const Structure& structure,
               const Independent& independent, const std::vector<double>& q, const std::vector<double>& cut_q,
               const std::vector<double>& u, const std::vector<MotionLaw::Derivatives>& targets);

}  // namespace gelenk

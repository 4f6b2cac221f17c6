// SPDX-License-Identifier: BSD-3-Clause
// Steps of methods whose errors do not show how fast friction turns what slides slowly.
//
// Friction c N against the sliding velocity u turns it at the rate c N w / |u|, where w is the mobility across u. This
// rate grows without limit as sliding comes to its end. Longer steps pass by the stop, with friction in some other
// direction, and a body that must come to rest creeps on from step to step.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "event/event_source.h"
#include "event_driven/contact_equations.h"

namespace gelenk {

class SlidingSteps {
 public:
  SlidingSteps(ContactEquations& equations, Dynamics& dynamics) : equations_(equations), dynamics_(dynamics) {}

  // At the last accelerate(): whether something slides so slowly that such a method may miss how friction turns it.
  bool any(const EventSource::SlowSliding& by) const;
  // The length of a step [s] within which that does not happen, with the accelerations vdot of the last accelerate();
  // `dynamics` has the factors of that position. Methods whose steps stability limits need the rate itself; of others
  // velocities may neither pass by zero nor turn too far.
  double longest(std::span<const double> vdot, const EventSource::SlowSliding& by);

 private:
  // A group of an entry that slides slowly, with its rows: the velocity along its motion, and across it.
  struct Slow {
    std::size_t entry = 0;
    int group = 0;
    Eigen::Index first = 0;
    int across = 1;       // number of rows
    double friction = 0;  // N, N m
  };
  void find(const EventSource::SlowSliding& by);
  void add_rows(const Slow& of);

  ContactEquations& equations_;
  Dynamics& dynamics_;
  std::vector<Slow> slow_;
  ContactEquations::RowMatrix R_, Z_;  // the rows, by velocity, and the responses to them
  Eigen::VectorXd rates_;              // of these velocities
};

}  // namespace gelenk

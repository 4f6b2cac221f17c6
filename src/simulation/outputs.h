// SPDX-License-Identifier: BSD-3-Clause
// Where each output of a scene comes from, and its value.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "simulation/signals.h"

namespace gelenk {

class Outputs {
 public:
  Outputs(const Scene& scene, const Mechanism& mechanism, const std::vector<Signal>& signals);

  // What must be up to date in `dynamics` before value() may be called.
  enum class Needs { state, velocities, accelerations };
  Needs needs(int output) const { return sources_[output].needs; }

  // y = (q, v), vdot of the tree; cut_q: coordinates of cut joints, turns counted.
  double value(int output, const Dynamics& dynamics, const double* y, const double* vdot,
               const std::vector<double>& cut_q) const;

 private:
  enum class Kind { none, tree, cut_q, cut_v, cut_a, reaction, pose, energy };
  struct Source {
    Kind kind = Kind::none;
    Needs needs = Needs::state;
    int index = 0;      // tree: in (q, v, vdot); cut and sensors: which
    int component = 0;  // within a cut joint or sensor
    double sign = 1;
  };
  // A frame on a link; reactions: M's origin and F's axes.
  struct Place {
    int joint = -1;
    BodyPlace frame, resolved_in;
  };

  Source joint_source(const Signal& signal) const;
  double reaction(const Place& place, int component, const Dynamics& dynamics) const;
  double pose(const Place& place, int component, const Dynamics& dynamics) const;
  void add_sensor(const Scene& scene, const Sensor& sensor);

  const Mechanism& mechanism_;
  std::vector<Source> sources_;
  std::vector<Place> places_;
};

}  // namespace gelenk

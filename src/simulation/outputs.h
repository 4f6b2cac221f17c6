// SPDX-License-Identifier: BSD-3-Clause
// Where each output of a scene comes from, and its value.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "scene/signals.h"
#include "simulation/reaction.h"

namespace gelenk {

// What outputs of an island are computed from: q, v, vdot of the tree; cut_q: coordinates of cut joints, turns counted;
// cut_v: their speeds, where they are known as double.
// T: double, or numbers that carry derivatives.
template <class T>
struct ReadingOf {
  const Readings<T>& dynamics;
  const T* q;
  const T* v;
  const T* vdot;
  const T* cut_q;
  const T* cut_v = nullptr;
};
using Reading = ReadingOf<double>;

class Outputs {
 public:
  Outputs(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& signals);

  // What must be up to date in the island before value() may be called.
  enum class Needs { state, velocities, accelerations };
  Needs needs(int output) const { return sources_[output].needs; }
  // The island the output comes from; none: it never changes, or is made of all of them.
  static constexpr int none = -1;
  int island(int output) const { return sources_[output].island; }
  // Part 0, 1, 2 (kinetic, potential, total) of the energy of all islands; none for other outputs.
  int energy_part(int output) const {
    return sources_[output].kind == Kind::energy ? sources_[output].component : none;
  }

  // Of an output that is sign times an entry of its island's (q, v, vdot): which. index none: of all others.
  struct Entry {
    int index;
    double sign;
  };
  Entry entry(int output) const;

  // reading: of the output's island.
  template <class T>
  T value(int output, const ReadingOf<T>& reading) const;
  // Of an output without island.
  double constant(int output) const;

 private:
  enum class Kind {
    constant,
    standing_pose,
    tree_q,
    tree_v,
    tree_a,
    cut_q,
    cut_v,
    cut_a,
    reaction,
    pose,
    energy,
    contact_force,
    contact_point,
    coordinate_force,
  };
  struct Source {
    Kind kind = Kind::constant;
    Needs needs = Needs::state;
    int island = none;
    int index = 0;      // tree: in q, v or vdot; in cut_q; other cuts and sensors: which; coordinate_force: row
    int component = 0;  // within a cut joint or sensor
    double sign = 1;    // constant: the value
  };
  Source joint_source(const Signal& signal) const;
  template <class T>
  T pose(const BodyPlace& frame, int component, const Readings<T>& dynamics) const;
  void add_sensor(const Scene& scene, const Sensor& sensor);
  void add_constraint(const Constraint& constraint, const ConstraintPlace& place);

  const ReducedScene& reduced_;
  std::vector<Source> sources_;
  std::vector<Reaction> reactions_;
  std::vector<BodyPlace> frames_;
};

}  // namespace gelenk

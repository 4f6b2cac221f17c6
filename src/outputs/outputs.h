// SPDX-License-Identifier: BSD-3-Clause
// Where each output of a scene comes from, and its value.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "outputs/port_readings.h"
#include "scene/signals.h"

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

  // What must be realized in the island before value() may be called.
  Stage stage(int output) const { return sources_[output].stage; }
  // The island the output comes from; none: it never changes, or is made of all of them.
  static constexpr int none = -1;
  int island(int output) const { return sources_[output].island; }
  // It is made of the energies of all islands, by of_energy().
  bool is_of_whole(int output) const { return sources_[output].kind == Kind::whole; }
  template <class T>
  T of_energy(int output, const EnergyOf<T>& energy) const;

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
    tree_q,
    tree_v,
    tree_a,
    cut_q,
    cut_v,
    cut_a,
    sensor,
    whole,  // a sensor of the whole mechanism
    constraint,
  };
  struct Source {
    Kind kind = Kind::constant;
    Stage stage = Stage::position;
    int island = none;
    int index = 0;      // tree: in q, v or vdot; in cut_q; other cuts, sensors and constraints: which
    int group = 0;      // of an element's outputs
    int component = 0;  // within a cut joint, or a group
    double sign = 1;    // constant: the value
  };
  Source joint_source(const Signal& signal) const;
  // Not inline: value() is called for each state of a joint, and is short without them.
  // dynamics: null where all its ports stand still.
  template <class T>
  [[gnu::noinline]] T sensor_value(const Source& source, const Readings<T>* dynamics) const;
  template <class T>
  [[gnu::noinline]] T constraint_value(const Source& source, const Readings<T>& dynamics) const;
  Source element_source(const Scene& scene, const Signal& signal) const;

  const ReducedScene& reduced_;
  std::vector<Source> sources_;
  std::vector<AnySensor> sensors_;  // by sensor of the scene
  std::vector<PortPlaces> ports_;
  std::vector<AnyConstraint> constraints_;  // by constraint of the scene
};

}  // namespace gelenk

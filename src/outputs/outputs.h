// SPDX-License-Identifier: BSD-3-Clause
// Source, required stage and value of each output of a scene.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "kinematics/switching_force.h"
#include "mechanism/mechanism.h"
#include "outputs/port_readings.h"
#include "scene/signals.h"

namespace gelenk {

struct Scene;

// Data from which the outputs of an island are computed: q, v, vdot of the tree joints; cut_q: coordinates of the cut
// joints with counted turns; cut_v: their velocities, or nullptr if they are to be computed. T: double or a scalar type
// for automatic differentiation.
template <class T>
struct ReadingOf {
  const Readings<T>& dynamics;
  const T* q;
  const T* v;
  const T* vdot;
  const T* cut_q;
  const T* cut_v = nullptr;
  const T* states = nullptr;       // of elements, in the order of Mechanism::states
  const T* state_rates = nullptr;  // after velocities
  const T* expressions = nullptr;  // values of those of the island that name no forces, after velocities
  // For those that name forces: all signals (kinematics/loads.h), and the expressions of the island.
  const T* signals = nullptr;
  const Formula* formulas = nullptr;
  // Of each force with modes (SwitchingForces) its force in the user's sign and its mode; null: there is none.
  const T* forces = nullptr;
  const int* modes = nullptr;
  ContactReadings* contacts = nullptr;  // null: nothing touches
  // For derivatives: by contact of the scene, its force on the bodies with the first surface, along the axes of the
  // root frame; null: nothing touches.
  const Vector3<T>* contact_forces = nullptr;
  const T* contact_gaps = nullptr;  // for derivatives, by contact of the scene
};
using Reading = ReadingOf<double>;

class Outputs {
 public:
  // scene: must outlive it. switching_forces: the forces with modes of each island.
  Outputs(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& signals,
          const std::vector<std::vector<SwitchingForce>>& switching_forces);

  // Stage up to which the island must be evaluated before value() is called.
  Stage stage(int output) const { return sources_[output].stage; }
  // Island from which the output is computed; `none` if it is constant or a sum over all islands.
  static constexpr int none = -1;
  int island(int output) const { return sources_[output].island; }
  // True if the output is computed from the energies of all islands, by of_energy().
  bool is_of_whole(int output) const { return sources_[output].kind == Kind::whole; }
  template <class T>
  T of_energy(int output, const EnergyOf<T>& energy) const;

  // For outputs that are `sign` times an entry of (q, v, vdot, element states) of their island: the index of the entry.
  // For all others the index is `none`.
  struct Entry {
    int index;
    double sign;
  };
  Entry entry(int output) const;

  // Returns the value of an output in the unit system of the scene. reading: data of the output's island.
  template <class T>
  T value(int output, const ReadingOf<T>& reading) const;
  // The rates of the element states of an island that name forces or accelerations, into `out`, by state; the others
  // are left as they are. rates: its formulas; reading: after set_acceleration and set_root_poses.
  template <class T>
  void rates_of_forces(int island, const std::vector<Formula>& rates, const ReadingOf<T>& reading, T* out) const;
  // Returns the value of an output that does not belong to an island.
  double constant(int output) const;

 private:
  enum class Kind {
    constant,
    tree_q,
    tree_v,
    tree_a,
    state,
    state_rate,
    expression,
    expression_of_forces,
    cut_q,
    cut_v,
    cut_a,
    joint_force,
    joint_mode,
    sensor,
    whole,  // a sensor of the whole mechanism
    constraint,
    contact,
    force,
  };
  struct Source {
    Kind kind = Kind::constant;
    Stage stage = Stage::position;
    int island = none;
    // In q, v or vdot (tree), cut_q, the element states or the forces with modes; or of the cut, sensor or constraint.
    int index = 0;
    int group = 0;      // group among the outputs of an element; of an expression of forces: its index in named_forces_
    int component = 0;  // within a cut joint, or a group
    double sign = 1;    // the value, for a constant
  };
  using SwitchingForces = std::vector<std::vector<SwitchingForce>>;
  Source source_of(const Scene& scene, const Signal& signal, const SwitchingForces& switching_forces) const;
  void find_named_forces(const Scene& scene, const SwitchingForces& switching_forces);
  std::vector<Source> sources_of(const Formula& formula, const std::vector<Signal>& forces, const Scene& scene,
                                 const SwitchingForces& switching_forces) const;
  template <class T>
  T value_of(const Source& source, const ReadingOf<T>& reading) const;
  template <class T>
  [[gnu::noinline]] T value_of_forces(const Formula& formula, const std::vector<Source>& sources,
                                      const ReadingOf<T>& reading) const;
  Source joint_source(const Signal& signal) const;
  Source joint_force_source(const Signal& signal,
                            const std::vector<std::vector<SwitchingForce>>& switching_forces) const;
  // Not inline, so that value(), which is called for each joint state, remains short. dynamics: nullptr if all ports
  // are fixed in the world.
  template <class T>
  [[gnu::noinline]] T sensor_value(const Source& source, const ReadingOf<T>* reading) const;
  template <class T>
  SeenWrench<T> wrench_of_laws(const Source& sensor, const ReadingOf<T>& reading) const;
  template <class T>
  T friction_value(const Source& source, const LinkFriction& of, const ReadingOf<T>& reading) const;
  template <class T>
  [[gnu::noinline]] T contact_value(const Source& source, const ReadingOf<T>& reading) const;
  template <class T>
  [[gnu::noinline]] T constraint_value(const Source& source, const Readings<T>& dynamics) const;
  template <class T>
  [[gnu::noinline]] T force_value(const Source& source, const Readings<T>* dynamics) const;
  Source named_source(const Signal& signal) const;
  double constant(const Source& source) const;
  Source element_source(const Scene& scene, const Signal& signal) const;

  const Scene& scene_;  // of elements, which may be tunable
  const ReducedScene& reduced_;
  std::vector<Source> sources_;
  std::vector<std::vector<Source>> named_forces_;  // by expression that names forces: what it names
  struct RateOfForces {
    int state = 0;  // among those of the island
    std::vector<Source> named;
  };
  std::vector<std::vector<RateOfForces>> rates_of_forces_;  // by island
  std::vector<PortPlaces> ports_;
  // Laws of the joint whose reaction a sensor reads that are contacts to the equations (scene/touching_laws.h), whose
  // forces are loads there.
  struct LawOfSensor {
    int contact = 0;
    bool turns = true;
  };
  std::vector<std::vector<LawOfSensor>> laws_of_sensors_;  // by sensor
  std::vector<PortPlaces> force_ports_;
};

}  // namespace gelenk

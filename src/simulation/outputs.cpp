// SPDX-License-Identifier: BSD-3-Clause
// Where outputs come from, and their values as double. Numbers with derivatives are read in outputs_extended.cpp.
#include "simulation/outputs_impl.h"

#include <algorithm>

namespace gelenk {
namespace {

constexpr int reaction_size = 6;
constexpr int frame_size = 13;  // r, Q, v, w
constexpr int energy_size = 3;

}  // namespace

Outputs::Outputs(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& signals)
    : reduced_(reduced) {
  for (const Signal& signal : signals) {
    if (signal.joint >= 0) sources_.push_back(joint_source(signal));
  }
  for (const Sensor& sensor : scene.sensors) add_sensor(scene, sensor);
  for (std::size_t c = 0; c < scene.constraints.size(); ++c) {
    add_constraint(scene.constraints[c], reduced.constraints[c]);
  }
}

Outputs::Entry Outputs::entry(int output) const {
  const Source& s = sources_[output];
  switch (s.kind) {
    case Kind::tree_q:
      return {s.index, s.sign};
    case Kind::tree_v:
      return {reduced_.islands[s.island].nq + s.index, s.sign};
    case Kind::tree_a:
      return {reduced_.islands[s.island].nq + reduced_.islands[s.island].nv + s.index, s.sign};
    default:
      return {none, 0};
  }
}

Outputs::Source Outputs::joint_source(const Signal& signal) const {
  const JointPlace& place = reduced_.joints[signal.joint];
  const int c = signal.component;
  Source source;
  if (place.role == JointPlace::Role::merged) {
    source.sign = signal.level == 0 ? place.q[c] : 0;
    return source;
  }
  source.island = place.island;
  const Mechanism& mechanism = reduced_.islands[place.island];
  source.sign = signal.level == 0 ? place.q_sign[c] : place.v_sign[c];
  if (place.role == JointPlace::Role::tree) {
    static constexpr Kind kinds[] = {Kind::tree_q, Kind::tree_v, Kind::tree_a};
    static constexpr Needs needs[] = {Needs::state, Needs::state, Needs::accelerations};
    source.kind = kinds[signal.level];
    source.needs = needs[signal.level];
    source.index = (signal.level == 0 ? place.iq : place.iv) + c;
    return source;
  }
  static constexpr Kind kinds[] = {Kind::cut_q, Kind::cut_v, Kind::cut_a};
  static constexpr Needs cut_needs[] = {Needs::state, Needs::state, Needs::accelerations};
  source.kind = kinds[signal.level];
  source.needs = cut_needs[signal.level];
  source.index = signal.level == 0 ? place.iq + c : place.index;
  source.component = place.iv - mechanism.cuts[place.index].iv + c;
  return source;
}

void Outputs::add_sensor(const Scene& scene, const Sensor& sensor) {
  int size = 0;
  Source source;
  switch (sensor.type) {
    case SensorType::reaction: {
      const auto found = std::ranges::find(scene.joints, sensor.joint, &Joint::name);
      const int joint = static_cast<int>(found - scene.joints.begin());
      source = {Kind::reaction, Needs::accelerations, reduced_.joints[joint].island,
                static_cast<int>(reactions_.size())};
      reactions_.emplace_back(scene, reduced_, joint);
      size = reaction_size;
      break;
    }
    case SensorType::frame: {
      const BodyPlace frame = place(scene, reduced_, none, sensor.frame);
      source = {frame.island < 0 ? Kind::standing_pose : Kind::pose, Needs::velocities, frame.island,
                static_cast<int>(frames_.size())};
      frames_.push_back(frame);
      size = frame_size;
      break;
    }
    case SensorType::energy:
      source = {Kind::energy, Needs::velocities};
      size = energy_size;
      break;
  }
  for (source.component = 0; source.component < size; ++source.component) sources_.push_back(source);
}

void Outputs::add_constraint(const Constraint& constraint, const ConstraintPlace& place) {
  const auto add = [&](int count, Kind kind, Needs needs, int index) {
    for (int i = 0; i < count; ++i) {
      Source source{.sign = 0};
      if (place.island >= 0) source = {kind, needs, place.island, index, i};
      sources_.push_back(source);
    }
  };
  switch (constraint.type) {
    case ConstraintType::motion:
    case ConstraintType::gear:
    case ConstraintType::rack:
      return add(1, Kind::coordinate_force, Needs::accelerations, place.row);
    case ConstraintType::knife_edge:
      return add(KnifeEdge::row_count, Kind::contact_force, Needs::accelerations, place.cut);
    case ConstraintType::rolling:
      add(Rolling::row_count, Kind::contact_force, Needs::accelerations, place.cut);
      return add(3, Kind::contact_point, Needs::velocities, place.cut);
  }
}

double Outputs::constant(int output) const {
  const Source& s = sources_[output];
  if (s.kind == Kind::constant) return s.sign;
  const Pose3& X_WS = frames_[s.index].X_LB;
  if (s.component < 3) return X_WS.p[s.component];
  return s.component < 7 ? quaternion_component(X_WS.R, s.component - 3) : 0;
}

template double Outputs::value(int, const Reading&) const;

}  // namespace gelenk

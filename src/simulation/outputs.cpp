// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/outputs.h"

#include <algorithm>

namespace gelenk {
namespace {

using Eigen::Vector3d;

constexpr int reaction_size = 6;
constexpr int frame_size = 13;  // r, Q, v, w
constexpr int energy_size = 3;

// Q[1..4] with the scalar part not negative: one of the two that mean the same.
double quaternion_component(const Eigen::Matrix3d& R, int i) {
  Eigen::Quaterniond Q(R);
  if (Q.w() < 0) Q.coeffs() = -Q.coeffs();
  return Q.coeffs()[i];
}

}  // namespace

Outputs::Outputs(const Scene& scene, const Mechanism& mechanism, const std::vector<Signal>& signals)
    : mechanism_(mechanism) {
  for (const Signal& signal : signals) {
    if (signal.joint >= 0) sources_.push_back(joint_source(signal));
  }
  for (const Sensor& sensor : scene.sensors) add_sensor(scene, sensor);
}

Outputs::Source Outputs::joint_source(const Signal& signal) const {
  const JointPlace& place = mechanism_.joints[signal.joint];
  Source source;
  if (place.role == JointPlace::Role::merged) return source;
  const int c = signal.component;
  source.sign = signal.level == 0 ? place.q_sign[c] : place.v_sign[c];
  static constexpr Needs needs[] = {Needs::state, Needs::state, Needs::accelerations};
  if (place.role == JointPlace::Role::tree) {
    source.kind = Kind::tree;
    source.needs = needs[signal.level];
    source.index = signal.level == 0 ? place.iq + c : mechanism_.nq + (signal.level - 1) * mechanism_.nv + place.iv + c;
    return source;
  }
  static constexpr Kind kinds[] = {Kind::cut_q, Kind::cut_v, Kind::cut_a};
  static constexpr Needs cut_needs[] = {Needs::state, Needs::velocities, Needs::accelerations};
  source.kind = kinds[signal.level];
  source.needs = cut_needs[signal.level];
  source.index = signal.level == 0 ? place.iq + c : place.index;
  source.component = c;
  return source;
}

void Outputs::add_sensor(const Scene& scene, const Sensor& sensor) {
  Place place;
  int size = 0;
  Source source;
  switch (sensor.type) {
    case SensorType::reaction: {
      const auto joint = std::ranges::find(scene.joints, sensor.joint, &Joint::name);
      place.joint = static_cast<int>(joint - scene.joints.begin());
      place.frame = gelenk::place(scene, mechanism_, joint->child);
      place.resolved_in = gelenk::place(scene, mechanism_, joint->parent);
      source = {Kind::reaction, Needs::accelerations, static_cast<int>(places_.size())};
      size = reaction_size;
      break;
    }
    case SensorType::frame:
      place.frame = gelenk::place(scene, mechanism_, sensor.frame);
      source = {Kind::pose, Needs::velocities, static_cast<int>(places_.size())};
      size = frame_size;
      break;
    case SensorType::energy:
      source = {Kind::energy, Needs::velocities};
      size = energy_size;
      break;
  }
  places_.push_back(place);
  for (source.component = 0; source.component < size; ++source.component) sources_.push_back(source);
}

double Outputs::value(int output, const Dynamics& dynamics, const double* y, const double* vdot,
                      const std::vector<double>& cut_q) const {
  const Source& s = sources_[output];
  double joint[6] = {};
  switch (s.kind) {
    case Kind::none:
      return 0;
    case Kind::tree: {
      const int states = mechanism_.nq + mechanism_.nv;
      return s.sign * (s.index < states ? y[s.index] : vdot[s.index - states]);
    }
    case Kind::cut_q:
      return s.sign * cut_q[s.index];
    case Kind::cut_v:
      dynamics.cut_speeds(s.index, joint);
      return s.sign * joint[s.component];
    case Kind::cut_a:
      dynamics.cut_accelerations(s.index, joint);
      return s.sign * joint[s.component];
    case Kind::reaction:
      return reaction(places_[s.index], s.component, dynamics);
    case Kind::pose:
      return pose(places_[s.index], s.component, dynamics);
    case Kind::energy: {
      const Energy e = dynamics.energy();
      return s.component == 0 ? e.kinetic : s.component == 1 ? e.potential : e.kinetic + e.potential;
    }
  }
  return 0;
}

// The joint's wrench on one of its links, taken to the child's side, to M's origin, into F's axes.
double Outputs::reaction(const Place& place, int component, const Dynamics& dynamics) const {
  const JointPlace& joint = mechanism_.joints[place.joint];
  const bool cut = joint.role == JointPlace::Role::cut;
  Pose3 X_0J;  // where the wrench is known, and its axes
  Spatial::Force F;
  double side = 1;
  if (cut) {
    const Cut& c = mechanism_.cuts[joint.index];
    X_0J = dynamics.link_pose(c.link_b) * c.X_BM;
    F = dynamics.cut_reaction(joint.index);
  } else {
    X_0J = dynamics.link_pose(joint.index);
    F = dynamics.tree_reaction(joint.index);
    if (mechanism_.links[joint.index].reversed) side = -1;
  }
  const Pose3 X_0M = dynamics.link_pose(place.frame.link) * place.frame.X_LB;
  const Eigen::Matrix3d R_0F = dynamics.link_pose(place.resolved_in.link).R * place.resolved_in.X_LB.R;
  const Vector3d f = side * (X_0J.R * F.f);
  const Vector3d n = side * (X_0J.R * F.n) + (X_0J.p - X_0M.p).cross(f);
  return component < 3 ? R_0F.col(component).dot(f) : R_0F.col(component - 3).dot(n);
}

double Outputs::pose(const Place& place, int component, const Dynamics& dynamics) const {
  const Pose3& X_LS = place.frame.X_LB;
  const Pose3 X_0L = dynamics.link_pose(place.frame.link);
  const Eigen::Matrix3d R_WL = mechanism_.X_W0.R * X_0L.R;
  if (component < 3) return mechanism_.X_W0.point(X_0L.point(X_LS.p))[component];
  if (component < 7) return quaternion_component(R_WL * X_LS.R, component - 3);
  const Spatial::Motion V = dynamics.link_velocity(place.frame.link);
  if (component < 10) return (R_WL * (V.v + V.w.cross(X_LS.p)))[component - 7];
  return X_LS.R.col(component - 10).dot(V.w);
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Access of sensors and constraints to the state of a simulation (element/sensors/sensor.h,
// element/constraints/constraint.h).
#pragma once

#include <optional>
#include <vector>

#include "dynamics/dynamics.h"
#include "element/constraints/constraint.h"
#include "element/forces/force.h"
#include "element/sensors/sensor.h"
#include "math/pose_in.h"
#include "mechanism/mechanism.h"
#include "scene/scene.h"

namespace gelenk {

// Where the wrench of a joint is computed, and the frames of the joint.
struct JointWrench {
  // joint: index in the scene of a tree joint or a cut joint.
  JointWrench(const Scene& scene, const ReducedScene& reduced, int joint);

  bool cut;
  int index;       // link or cut
  BodyPlace at;    // frame at which it is computed: that of the link, or M of the cut
  double side;     // -1 if it is computed on the parent
  BodyPlace F, M;  // the frames of the joint in the scene
};

// The ports of an element in a reduced scene.
struct PortPlaces {
  // Finds the ports in the island that has a moving port, if any. with_wrench: also locate the wrench of its joint.
  PortPlaces(const Scene& scene, const ReducedScene& reduced, const ElementPlace& element, bool with_wrench);

  int island = -1;                // -1 if all ports are fixed in the world
  std::vector<BodyPlace> frames;  // frames of bodies, then F and M of each joint
  Eigen::Vector3d gravity;        // of the scene, uniform
  std::optional<JointWrench> wrench;
};

// Pose in the root frame of the link or rod on which a place in a moving island is.
template <class T>
typename SpatialAlgebra<T>::Pose carrier_pose(const BodyPlace& at, const Readings<T>& dynamics) {
  return at.rod >= 0 ? dynamics.rod_pose(at.rod) : dynamics.link_pose(at.link);
}
// Pose of a body in the world. dynamics: of its island, not read if it is immobile.
Pose3 pose_in_world(const ReducedScene& reduced, const BodyPlace& body, const Readings<double>& dynamics);

template <class T>
struct SeenWrench {
  Vector3<T> f, n;
};

// Poses, velocities and reactions at the ports of a sensor. T: double or a scalar type for automatic differentiation.
template <class T>
class SeenPorts {
 public:
  using Pose = typename SpatialAlgebra<T>::Pose;

  // dynamics: of the island of the ports; nullptr if they are fixed in the world.
  SeenPorts(const PortPlaces& places, const ReducedScene& reduced, const Readings<T>* dynamics)
      : SeenPorts(places,
                  places.island < 0 ? at_origin() : reduced.islands[static_cast<std::size_t>(places.island)].X_W0,
                  dynamics) {}
  // Makes reaction() show `wrench`, on the child at the origin of M in the axes of the root frame, too: what the
  // reactions of the equations leave out.
  void add_to_reaction(const SeenWrench<T>& wrench) { added_ = wrench; }
  // X_W0: of that island, which must outlive it.
  SeenPorts(const PortPlaces& places, const Pose3& X_W0, const Readings<T>* dynamics)
      : places_(places), X_W0_(X_W0), dynamics_(dynamics) {}

  Pose pose(int k) const {
    const BodyPlace& at = place(k);
    const Pose X_LP = pose_in<SpatialAlgebra<T>>(at.X_LB);
    return dynamics_ == nullptr ? X_LP : pose_of(at) * X_LP;
  }
  SeenFrame<T> frame(int k) const {
    const BodyPlace& at = place(k);
    const Pose X_LP = pose_in<SpatialAlgebra<T>>(at.X_LB);
    if (dynamics_ == nullptr) return {X_LP, Vector3<T>::Zero(), Vector3<T>::Zero()};
    const Pose X_0L = pose_of(at);
    const auto V = at.rod >= 0 ? dynamics_->rod_velocity(at.rod) : dynamics_->link_velocity(at.link);
    return {X_0L * X_LP, X_0L.R * (V.v + V.w.cross(X_LP.p)), X_0L.R * V.w};
  }
  SeenAcceleration<T> acceleration(int k) const {
    const BodyPlace& at = place(k);
    if (dynamics_ == nullptr || at.link == 0) return {Vector3<T>::Zero(), Vector3<T>::Zero()};
    const Vector3<T> p = pose_in<SpatialAlgebra<T>>(at.X_LB).p;
    const auto V = dynamics_->link_velocity(at.link);
    const auto A = dynamics_->link_acceleration(at.link);
    const Vector3<T> a = A.v + V.w.cross(V.v) + A.w.cross(p) + V.w.cross(V.w.cross(p));
    const auto& R = pose_of(at).R;
    return {R * a, R * A.w};
  }
  Vector3<T> gravity() const { return X_W0().R.transpose() * places_.gravity.template cast<T>(); }
  // As a port of a force (element/forces/force.h).
  RecordingPort<T> port(int k) const {
    const SeenFrame<T> seen = frame(k);
    RecordingPort<T> out{seen.X_0P.p, seen.v, seen.w, seen.X_0P.R, X_W0().R.transpose()};
    if (dynamics_ != nullptr) out.p_W0 = X_W0_.p;
    return out;
  }
  Pose X_W0() const {
    if (dynamics_ == nullptr) return {};
    return pose_in<SpatialAlgebra<T>>(X_W0_);
  }
  SeenWrench<T> reaction() const {
    const JointWrench& joint = *places_.wrench;
    const Pose X_0J = pose_of(joint.at) * pose_in<SpatialAlgebra<T>>(joint.at.X_LB);
    const auto F = joint.cut ? dynamics_->cut_reaction(joint.index) : dynamics_->tree_reaction(joint.index);
    const Vector3<T> p_M = pose_of(joint.M).point(pose_in<SpatialAlgebra<T>>(joint.M.X_LB).p);
    const Vector3<T> f = T(joint.side) * (X_0J.R * F.f);
    return {f + added_.f, T(joint.side) * (X_0J.R * F.n) + Vector3<T>(X_0J.p - p_M).cross(f) + added_.n};
  }

 private:
  const BodyPlace& place(int k) const { return places_.frames[static_cast<std::size_t>(k)]; }
  Pose pose_of(const BodyPlace& at) const { return carrier_pose(at, *dynamics_); }

  static const Pose3& at_origin() {
    static const Pose3 out;
    return out;
  }

  const PortPlaces& places_;
  const Pose3& X_W0_;
  const Readings<T>* dynamics_;
  SeenWrench<T> added_{Vector3<T>::Zero(), Vector3<T>::Zero()};
};

// Energy of the mechanism, or of a part of it.
template <class T>
struct SeenEnergy {
  EnergyOf<T> of_whole;
  const EnergyOf<T>& energy() const { return of_whole; }
};

// Forces and poses of a constraint in its island.
template <class T>
class SeenConstraint {
 public:
  SeenConstraint(const ConstraintPlace& place, const ReducedScene& reduced, const Readings<T>& dynamics)
      : place_(place), reduced_(reduced), dynamics_(dynamics) {}

  T coordinate_force() const { return dynamics_.coordinate_force(place_.row); }
  T contact_force(int row) const { return dynamics_.contact_force(place_.cut, row); }
  auto X_WF() const {
    const Mechanism& mechanism = reduced_.islands[static_cast<std::size_t>(place_.island)];
    return pose_in<SpatialAlgebra<T>>(mechanism.X_W0) * dynamics_.plane_pose(place_.cut);
  }
  auto X_FM() const { return dynamics_.pose_on_plane(place_.cut); }

 private:
  const ConstraintPlace& place_;
  const ReducedScene& reduced_;
  const Readings<T>& dynamics_;
};

}  // namespace gelenk

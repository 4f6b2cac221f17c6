// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "dynamics/model.h"

namespace gelenk {
namespace {

Attachment attach(const Scene& scene, const Mechanism& mechanism, const BodyFrame& frame) {
  const BodyPlace found = place(scene, mechanism, frame);
  return {found.link, found.X_LB.p, mechanism.planar ? mechanism.heights[found.link] : 0};
}

Wrench make_wrench(const Scene& scene, const Mechanism& mechanism, const Force& force) {
  Wrench out;
  out.at = attach(scene, mechanism, force.at);
  out.in_link = force.in_body;
  out.R_user = force.in_body ? place(scene, mechanism, force.at).X_LB.R : Eigen::Matrix3d(mechanism.X_W0.R.transpose());
  out.force = out.R_user * force.force;
  out.torque = out.R_user * force.torque;
  return out;
}

struct LoadMaker {
  const Scene& scene;
  const Mechanism& mechanism;
  Loads& out;

  void motor(const Motor& motor, int input) const {
    const JointPlace& place = place_of(motor.joint);
    const bool cut = place.role == JointPlace::Role::cut;
    const double gain = motor.gear_ratio * place.v_sign[0];
    if (cut) {
      out.cuts[place.index].actuations.push_back({0, input, gain});
    } else {
      out.tree.actuations.push_back({place.iv, input, gain});
      out.reflected_inertia[place.iv] += motor.gear_ratio * motor.gear_ratio * motor.rotor_inertia;
    }
  }

  void joint(int j) const {
    const Joint& joint = scene.joints[j];
    const JointPlace& place = mechanism.joints[j];
    if (place.role == JointPlace::Role::merged) return;
    const bool cut = place.role == JointPlace::Role::cut;
    const int iq = cut ? 0 : place.iq;
    const int iv = cut ? 0 : place.iv;
    // Damping works on every speed, stiffness only where the coordinate is the speed's integral.
    const bool springs = find_joint_kind(joint.type)->springs();
    for (int i = 0; i < static_cast<int>(joint.damping.size()); ++i) {
      const double k = springs ? joint.stiffness[i] : 0;
      if (k == 0 && joint.damping[i] == 0) continue;
      const double reference = springs ? place.q_sign[i] * joint.spring_reference[i] : 0;
      (cut ? out.cuts[place.index] : out.tree).springs.push_back({iq + i, iv + i, k, joint.damping[i], reference});
    }
  }

  void force(const Force& force) const {
    if (force.type == ForceType::spring_damper) {
      out.springs.push_back({attach(scene, mechanism, force.from), attach(scene, mechanism, force.to), force.stiffness,
                             force.damping, force.length});
      return;
    }
    Wrench wrench = make_wrench(scene, mechanism, force);
    if (force.input) {
      wrench.input = out.inputs;
      out.inputs += 6;
    }
    out.wrenches.push_back(wrench);
  }

 private:
  const JointPlace& place_of(const std::string& name) const {
    const auto found = std::ranges::find(scene.joints, name, &Joint::name);
    return mechanism.joints[found - scene.joints.begin()];
  }
};

}  // namespace

Loads make_loads(const Scene& scene, const Mechanism& mechanism) {
  Loads out;
  out.gravity = mechanism.X_W0.R.transpose() * scene.gravity;
  for (std::size_t i = 1; i < mechanism.links.size(); ++i) {
    const Spatial::Inertia& G = mechanism.links[i].G;
    out.potential_offset -= G.m * scene.gravity.dot(mechanism.X_W0.p);
    if (mechanism.planar) out.potential_offset -= out.gravity.z() * (G.m * mechanism.heights[i] + G.h.z());
  }
  out.cuts.resize(mechanism.cuts.size());
  out.reflected_inertia.assign(mechanism.nv, 0);
  const LoadMaker maker{scene, mechanism, out};
  for (const Motor& motor : scene.motors) maker.motor(motor, out.inputs++);
  for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) maker.joint(j);
  for (const Force& force : scene.forces) maker.force(force);
  return out;
}

}  // namespace gelenk

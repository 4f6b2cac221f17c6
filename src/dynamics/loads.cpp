// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "dynamics/model.h"

namespace gelenk {
namespace {

// A stop on sign * q.
Stop in_sign(double sign, Stop stop) {
  if (sign > 0) return stop;
  std::swap(stop.lower, stop.upper);
  stop.lower = -stop.lower;
  stop.upper = -stop.upper;
  return stop;
}

// What is there is forgotten, its room kept.
void empty(JointLoads& loads) {
  loads.springs.clear();
  loads.actuations.clear();
  loads.stops.clear();
}

void empty(Loads& loads) {
  empty(loads.tree);
  for (JointLoads& cut : loads.cuts) empty(cut);
  loads.springs.clear();
  loads.wrenches.clear();
  loads.inputs.clear();
  loads.potential_offset = 0;
}

// Adds the loads of one scene to `out`, an island each, which are empty().
struct LoadAdder {
  const Scene& scene;
  const ReducedScene& reduced;
  const std::unordered_map<std::string_view, int>&body_number, &joint_number;
  std::vector<Loads>& out;
  int inputs = 0;

  void prepare() {
    out.resize(reduced.islands.size());
    for (std::size_t i = 0; i < out.size(); ++i) prepare(reduced.islands[i], out[i]);
  }

  void prepare(const Mechanism& mechanism, Loads& loads) const {
    empty(loads);
    loads.gravity = mechanism.X_W0.R.transpose() * scene.gravity;
    for (std::size_t i = 1; i < mechanism.links.size(); ++i) {
      const Spatial::Inertia& G = mechanism.links[i].G;
      loads.potential_offset -= G.m * scene.gravity.dot(mechanism.X_W0.p);
      if (mechanism.planar) loads.potential_offset -= loads.gravity.z() * (G.m * mechanism.heights[i] + G.h.z());
    }
    // Springs of no stiffness and damping are left out, and may be asked for later.
    loads.tree.springs.reserve(mechanism.nv);
    loads.cuts.resize(mechanism.cuts.size());
    for (std::size_t c = 0; c < mechanism.cuts.size(); ++c) loads.cuts[c].springs.reserve(mechanism.cuts[c].nv);
    loads.reflected_inertia.assign(mechanism.nv, 0);
  }

  void motor(const Motor& motor) {
    const int input = inputs++;
    const JointPlace& place = reduced.joints[joint_number.at(motor.joint)];
    if (place.role == JointPlace::Role::merged) return;
    Loads& loads = out[place.island];
    loads.inputs.push_back(input);
    const double gain = motor.gear_ratio * place.v_sign[0];
    if (place.role == JointPlace::Role::cut) {
      loads.cuts[place.index].actuations.push_back({0, input, gain});
    } else {
      loads.tree.actuations.push_back({place.iv, input, gain});
      loads.reflected_inertia[place.iv] += motor.gear_ratio * motor.gear_ratio * motor.rotor_inertia;
    }
  }

  void joint(int j) {
    const Joint& joint = scene.joints[j];
    const JointPlace& place = reduced.joints[j];
    if (place.role == JointPlace::Role::merged || place.role == JointPlace::Role::rod) return;
    Loads& loads = out[place.island];
    const bool cut = place.role == JointPlace::Role::cut;
    const int iq = cut ? 0 : place.iq;
    const int iv = cut ? 0 : place.iv;
    // Damping works on every speed, stiffness only where the coordinate is the speed's integral.
    const bool springs = find_joint_kind(joint.type)->springs();
    JointLoads& along = cut ? loads.cuts[place.index] : loads.tree;
    if (joint.stop) along.stops.push_back({iq, iv, in_sign(place.q_sign[0], *joint.stop)});
    for (int i = 0; i < static_cast<int>(joint.damping.size()); ++i) {
      const double k = springs ? joint.stiffness[i] : 0;
      if (k == 0 && joint.damping[i] == 0) continue;
      const double reference = springs ? place.q_sign[i] * joint.spring_reference[i] : 0;
      along.springs.push_back({iq + i, iv + i, k, joint.damping[i], reference});
    }
  }

  // Those that are inputs.
  void motions() {
    for (std::size_t i = 0; i < reduced.islands.size(); ++i) {
      for (const CoordinateRow& row : reduced.islands[i].coordinate_rows) {
        if (row.input >= 0) out[i].inputs.push_back(row.input);
      }
    }
  }

  void force(const Force& force) {
    if (force.type == ForceType::spring_damper) {
      const int island = std::max(island_of(force.from), island_of(force.to));
      if (island < 0) return;
      out[island].springs.push_back({attach(island, force.from), attach(island, force.to), force.stiffness,
                                     force.damping, force.length, static_cast<int>(&force - scene.forces.data())});
      return;
    }
    const int first_input = inputs;
    if (force.input) inputs += 6;
    const int island = island_of(force.at);
    if (island < 0) return;
    Wrench wrench = make_wrench(island, force);
    if (force.input) {
      wrench.input = first_input;
      for (int i = 0; i < 6; ++i) out[island].inputs.push_back(first_input + i);
    }
    out[island].wrenches.push_back(wrench);
  }

 private:
  // -1: stands still.
  int island_of(const BodyFrame& frame) const {
    return frame.body == ground ? -1 : reduced.bodies[body_number.at(frame.body)].island;
  }

  Attachment attach(int island, const BodyFrame& frame) const {
    const BodyPlace found = place(scene, reduced, island, frame);
    const Mechanism& mechanism = reduced.islands[island];
    return {found.link, found.X_LB.p, mechanism.planar ? mechanism.heights[found.link] : 0};
  }

  Wrench make_wrench(int island, const Force& force) const {
    Wrench out;
    out.at = attach(island, force.at);
    out.in_link = force.in_body;
    const Eigen::Matrix3d& R_W0 = reduced.islands[island].X_W0.R;
    out.R_user = force.in_body ? place(scene, reduced, island, force.at).X_LB.R : Eigen::Matrix3d(R_W0.transpose());
    out.force = out.R_user * force.force;
    out.torque = out.R_user * force.torque;
    return out;
  }
};

}  // namespace

LoadMaker::LoadMaker(const Scene& scene, const ReducedScene& reduced) : scene_(scene), reduced_(reduced) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) body_number_[scene.bodies[b].name] = static_cast<int>(b);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) joint_number_[scene.joints[j].name] = static_cast<int>(j);
}

void LoadMaker::fill(std::vector<Loads>& loads) const {
  LoadAdder adder{scene_, reduced_, body_number_, joint_number_, loads};
  adder.prepare();
  for (const Motor& motor : scene_.motors) adder.motor(motor);
  for (int j = 0; j < static_cast<int>(scene_.joints.size()); ++j) adder.joint(j);
  for (const Force& force : scene_.forces) adder.force(force);
  adder.motions();
}

std::vector<Loads> make_loads(const Scene& scene, const ReducedScene& reduced) {
  std::vector<Loads> loads;
  LoadMaker(scene, reduced).fill(loads);
  return loads;
}

double standing_energy(const Scene& scene, const ReducedScene& reduced) {
  double sum = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const BodyPlace& place = reduced.bodies[b];
    if (place.island < 0) sum -= scene.bodies[b].mass * scene.gravity.dot(place.X_LB.point(scene.bodies[b].com));
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const std::vector<double>& q = reduced.joints[j].q;
    for (std::size_t i = 0; i < q.size() && i < joint.stiffness.size(); ++i) {
      sum += joint.stiffness[i] / 2 * (q[i] - joint.spring_reference[i]) * (q[i] - joint.spring_reference[i]);
    }
    if (joint.stop && !q.empty()) sum += energy_of(*joint.stop, q[0]);
  }
  for (const Force& force : scene.forces) {
    if (force.type != ForceType::spring_damper) continue;
    const BodyPlace from = place(scene, reduced, -1, force.from);
    const BodyPlace to = place(scene, reduced, -1, force.to);
    if (from.island >= 0 || to.island >= 0) continue;
    const double stretch = (to.X_LB.p - from.X_LB.p).norm() - force.length;
    sum += force.stiffness / 2 * stretch * stretch;
  }
  return sum;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/start.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string_view>
#include <unordered_set>

#include "joint/turns.h"
#include "kinematics/coordinate_rows.h"
#include "mechanism/mechanism.h"
#include "scene/component_parts.h"
#include "scene/formulas.h"
#include "scene/scene.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Weight of coordinates without a start value: these change by 1 m rather than those with a start value (weight 1 by
// default) by 1 cm. It is that of all joints, so that the assembly does not depend on which of them are cut.
constexpr double default_guess_weight = 1e-4;

InitialGuess zero_guess(int nq, int nv) {
  InitialGuess w;
  w.q.assign(nq, 0);
  w.v.assign(nv, 0);
  w.q_fixed.assign(nv, false);
  w.v_fixed.assign(nv, false);
  w.q_weight.assign(nv, 0);
  w.v_weight.assign(nv, 0);
  w.q_given.assign(nv, false);
  w.v_given.assign(nv, false);
  w.turns.assign(nv, false);
  w.rank.assign(nv, 0);
  w.user_sign.assign(nv, 1);
  return w;
}

// Returns the coordinate of a joint that belongs to velocity i: for a quaternion the first one for all three rotations.
int position_index(const JointKind& kind, int i) { return kind.has_quaternion() ? std::min(i, kind.nq - 4) : i; }

// Sets q (nq numbers) to the start values of a joint, in the signs of the mechanism.
void preferred_coordinates(const Joint& joint, const JointPlace& place, double* q) {
  const JointStart& start = joint.start;
  const JointKind& kind = *find_joint_kind(joint.type);
  for (int i = 0; i < kind.nq; ++i) q[i] = place.q_sign[i] * (start.q_given[i] ? start.q[i] : kind.q_zero[i]);
}

// The places of the joints in alphabetical order, by joint of the scene.
std::vector<int> alphabetical_ranks(const Scene& scene) {
  std::vector<int> order(scene.joints.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int j) -> const std::string& { return scene.joints[j].name; });
  std::vector<int> out(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) out[order[k]] = static_cast<int>(k);
  return out;
}

void add_guesses(const Joint& joint, int rank, const JointPlace& place, InitialGuess& out) {
  const JointKind& kind = *find_joint_kind(joint.type);
  const JointStart& start = joint.start;
  preferred_coordinates(joint, place, &out.q[place.iq]);
  for (int i = 0; i < kind.nv; ++i) {
    const int c = position_index(kind, i);
    out.q_fixed[place.iv + i] = start.q_fixed[c];
    out.q_weight[place.iv + i] = start.q_given[c] ? start.q_weight[c] : default_guess_weight;
    out.q_given[place.iv + i] = start.q_given[c];
    out.turns[place.iv + i] = repeats_each_turn(*joint.is, c);
    out.rank[place.iv + i] = rank;
    out.user_sign[place.iv + i] = place.q_sign[c];
    out.v_given[place.iv + i] = start.v_given[i];
    out.v[place.iv + i] = start.v_given[i] ? place.v_sign[i] * start.v[i] : 0;
    out.v_fixed[place.iv + i] = start.v_fixed[i];
    out.v_weight[place.iv + i] = start.v_given[i] ? start.v_weight[i] : default_guess_weight;
  }
}

}  // namespace

StartGuesses start_guesses(const Scene& scene, const ReducedScene& reduced, int island) {
  const Mechanism& mechanism = reduced.islands[island];
  StartGuesses out{zero_guess(mechanism.nq, mechanism.nv), zero_guess(mechanism.cut_nq, mechanism.cut_nv)};
  const std::vector<int> ranks = alphabetical_ranks(scene);
  for (const int j : mechanism.joints) {
    const Joint& joint = scene.joints[j];
    const JointPlace& place = reduced.joints[j];
    if (place.role == JointPlace::Role::tree) add_guesses(joint, ranks[j], place, out.tree);
    if (place.role == JointPlace::Role::cut) add_guesses(joint, ranks[j], place, out.cuts);
    // Guesses of joints at a rod are used while it is still a body (preparation.cpp); only its side and turns remain.
    if (place.role == JointPlace::Role::rod) preferred_coordinates(joint, place, &out.cuts.q[place.iq]);
  }
  return out;
}

std::vector<bool> preferred_velocities(const Scene& scene, const ReducedScene& reduced, int island) {
  const Mechanism& mechanism = reduced.islands[island];
  std::vector<bool> out(mechanism.nv, false);
  std::unordered_set<std::string_view> driven;
  for (const DrivenJoint& at : driven_joints(scene)) driven.insert(at.joint);
  for (const Constraint& c : scene.constraints) {
    if (!c.joints.empty() && !holds_positions(*c.is))
      driven.insert(c.joints.front());  // its coordinate is not constrained
  }
  const bool contacts = std::ranges::any_of(mechanism.cuts, &Cut::is_contact);
  for (const int j : mechanism.joints) {
    const JointPlace& place = reduced.joints[j];
    if (place.role != JointPlace::Role::tree) continue;
    const Joint& joint = scene.joints[j];
    const JointKind& kind = *find_joint_kind(joint.type);
    for (int i = 0; i < kind.nv; ++i) {
      out[place.iv + i] =
          driven.contains(joint.name) || joint.start.v_fixed[i] || joint.start.q_fixed[position_index(kind, i)];
      // A quaternion is independent as a whole or not at all.
      if (contacts && kind.has_quaternion() && i >= kind.nv - 3) out[place.iv + i] = true;
    }
  }
  return out;
}

std::vector<double> coordinates_of(const Scene& scene, const ReducedScene& reduced, int joint,
                                   const std::vector<double>& q, const Dynamics& dynamics) {
  const JointPlace& place = reduced.joints[joint];
  const JointKind& kind = *find_joint_kind(scene.joints[joint].type);
  const JointStart& start = scene.joints[joint].start;
  std::vector<double> out(kind.nq);
  if (place.role == JointPlace::Role::tree) {
    for (int i = 0; i < kind.nq; ++i) out[i] = place.q_sign[i] * q[place.iq + i];
    return out;
  }
  const Cut& cut = reduced.islands[place.island].cuts[place.index];
  double found[max_cut_nq];
  for (const int j : cut.scene_joints) {
    preferred_coordinates(scene.joints[j], reduced.joints[j], found + reduced.joints[j].iq - cut.iq);
  }
  dynamics.cut_coordinates(place.index, found);
  for (int i = 0; i < kind.nq; ++i) {
    out[i] = place.q_sign[i] * found[place.iq - cut.iq + i];
    if (!repeats_each_turn(*scene.joints[joint].is, i)) continue;
    const double wanted = start.q_given[i] ? start.q[i] : 0;
    out[i] += 2 * std::numbers::pi * std::round((wanted - out[i]) / (2 * std::numbers::pi));
  }
  return out;
}

std::vector<double> velocities_of(const ReducedScene& reduced, int joint, const std::vector<double>& v,
                                  const Dynamics& dynamics) {
  const JointPlace& place = reduced.joints[joint];
  double of_cut[max_cut_nv];
  const double* of_joint = v.data() + place.iv;
  if (place.role != JointPlace::Role::tree) {
    dynamics.readings().cut_speeds(place.index, of_cut);
    of_joint = of_cut + place.iv - reduced.islands[place.island].cuts[place.index].iv;
  }
  std::vector<double> out(place.v_sign.size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = place.v_sign[k] * of_joint[k];
  return out;
}

std::vector<double> states_at_start(const Scene& scene, const Mechanism& mechanism) {
  std::vector<double> out;
  for (const int number : mechanism.states) {
    const ElementState& state = scene.states[static_cast<std::size_t>(number)];
    out.push_back(state.start / size_of(state, scene.units));
  }
  return out;
}

std::vector<double> signals_at_start(const Scene& scene, const Mechanism& mechanism, const Inputs& inputs) {
  std::vector<double> out(inputs.now());
  for (const double state : states_at_start(scene, mechanism)) out.push_back(state);
  return out;
}

void check_prescribed_motions(const Scene& scene, const Mechanism& mechanism, double time) {
  constexpr std::string_view names[] = {"value", "speed", "acceleration"};
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    if (!row.law) continue;
    const MotionLaw::Derivatives at = row.law->at(time);
    for (std::size_t k = 0; k < std::size(names); ++k) {
      if (std::isfinite(at[k])) continue;
      throw SceneError({(scene.file.empty() ? "" : scene.file + ": ") + "constraints." +
                        scene.constraints[row.constraint].name + ": found no finite " + std::string(names[k]) +
                        " of its motion at t = " + text::rounded(time * scene.units.size_of("s")) +
                        " s, expected one with which the run can start"});
    }
  }
}

void check_relations(const Scene& scene, const Mechanism& mechanism, const std::vector<double>& q) {
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    if (!row.relation) continue;
    const kernels::RelationState<double> at(row, q.data(), nullptr);
    if (row.relation->is_regular(at.x, at.rates)) continue;
    throw SceneError({(scene.file.empty() ? "" : scene.file + ": ") + "constraints." +
                      scene.constraints[static_cast<std::size_t>(row.constraint)].name +
                      ": found no finite value of the relation, or derivatives that all vanish, at the start values; "
                      "expected ones that say how the joints move together"});
  }
}

}  // namespace gelenk

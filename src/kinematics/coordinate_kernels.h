// SPDX-License-Identifier: BSD-3-Clause
// Kernels between the coordinates of tree joints and their velocities.
#pragma once

#include "kinematics/model.h"
#include "kinematics/visit.h"

namespace gelenk::kernels {

// qdot <- the rates of the coordinates q at the velocities v.
template <class A, class T>
void coordinate_rates(const Model<A>& model, const T* q, const T* v, T* qdot) {
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const auto& link = model.links[i];
    visit_joint<A>(link.joint, [&](const auto& joint) { joint.qdot_from_v(q + link.iq, v + link.iv, qdot + link.iq); });
  }
}

// Moves q by the displacement dv, in velocity coordinates. rates_are_velocities: of all joints.
template <class A>
void displace(const Model<A>& model, bool rates_are_velocities, double* q, const double* dv) {
  if (rates_are_velocities) {
    for (int k = 0; k < model.nv; ++k) q[k] += dv[k];
    return;
  }
  double dq[7];
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const auto& link = model.links[i];
    double* q_i = q + link.iq;
    visit_joint<A>(link.joint, [&](const auto& joint) {
      joint.qdot_from_v(q_i, dv + link.iv, dq);
      for (int k = 0; k < link.nq; ++k) q_i[k] += dq[k];
      joint.normalize(q_i);
    });
  }
}

// Makes quaternions in q of length 1.
template <class A>
void normalize(const Model<A>& model, double* q) {
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const auto& link = model.links[i];
    if (link.nq == link.nv) continue;
    visit_joint<A>(link.joint, [&](const auto& joint) { joint.normalize(q + link.iq); });
  }
}

}  // namespace gelenk::kernels

// SPDX-License-Identifier: BSD-3-Clause
// Implementation of Model and Workspace for any number type.
#pragma once

#include "kinematics/model.h"

#include "kinematics/kernels.h"
#include "kinematics/revolute_kernels.h"

namespace gelenk {

template <class A>
Model<A>::Model(const Mechanism& mechanism)
    : coordinate_rows(mechanism.coordinate_rows),
      nq(mechanism.nq),
      nv(mechanism.nv),
      rows(mechanism.rows),
      cut_nq(mechanism.cut_nq),
      cut_nv(mechanism.cut_nv),
      first_coordinate_row(mechanism.first_coordinate_row()),
      mass_needs_rows(mechanism.mass_needs_rows) {
  for (const gelenk::Link& link : mechanism.links) {
    const bool constant_subspace = std::visit([](const auto& j) { return j.reverses_by_half_turn; }, *link.joint);
    const bool revolute =
        link.nv > 0 &&  // not the ground
        std::visit([](const auto& j) { return is_pure_turn<std::decay_t<decltype(j)>>; }, *link.joint);
    links.push_back({link.parent, link.iq, link.iv, link.nq, link.nv, constant_subspace, revolute, *link.joint,
                     pose_in<A>(link.X_PJ), inertia_in<A>(link.G)});
  }
  for (const gelenk::Cut& cut : mechanism.cuts) {
    cuts.push_back({cut.link_a, cut.link_b, cut.first_row, cut.rows, cut.rows == cut.joint_rows, cut.kept, cut.iq,
                    cut.iv, cut.nq, cut.nv, cut.is_angle, pose_in<A>(cut.X_AF), pose_in<A>(cut.X_BM), cut.path_a,
                    cut.path_b, path_links, *cut.joint});
    path_links += static_cast<int>(cut.path_a.size() + cut.path_b.size());
  }
}

template <class A>
Workspace<A>::Workspace(const Model<A>& model)
    : X_PL(model.links.size()),
      X_0L(model.links.size()),
      V(model.links.size()),
      A_bias(model.links.size()),
      A_full(model.links.size()),
      F(model.links.size()),
      F_ext(model.links.size()),
      G_tree(model.links.size()),
      S(model.nv),
      X_FM(model.cuts.size()),
      X_FL(model.path_links),
      V_FM(model.cuts.size()),
      A_cut(model.cuts.size()),
      F_cut(model.cuts.size()),
      row(model.rows),
      Phi(model.rows),
      rate(model.rows),
      gamma(model.rows),
      lambda(model.rows) {
  for (const auto& link : model.links) {
    if (link.is_revolute_about_z) kernels::add_turn<A>(typename A::Scalar(1), S[link.iv]);
  }
  // In the order in which loop_jacobian() writes them.
  for (const auto& cut : model.cuts) {
    std::vector<int> speeds;
    for (const std::vector<int>* path : {&cut.path_a, &cut.path_b}) {
      for (const int i : *path) {
        for (int k = 0; k < model.links[i].nv; ++k) speeds.push_back(model.links[i].iv + k);
      }
    }
    for (int r = 0; r < cut.rows; ++r) J.append(speeds);
  }
  for (const CoordinateRow& row : model.coordinate_rows) {
    std::vector<int> speeds;
    for (const CoordinateRow::Term& term : row.terms) speeds.push_back(term.v);
    J.append(speeds);
    factors.resize(factors.size() + speeds.size());
  }
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of ContactEquations by differences, without and with the directions of slow sliding. The slower sliding
// is, the faster its direction turns: friction c N acts along the unit vector of the sliding velocity u, which a change
// of u across it by du turns by du / |u|.
#include <algorithm>
#include <cmath>

#include "event_driven/contact_equations.h"
#include "mechanism/mechanism.h"

namespace gelenk {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Change of a sliding velocity, relative to it, up to which derivatives are kept.
constexpr double kept_fraction = 0.5;

}  // namespace

void ContactEquations::begin_differences(int components, const double* vdot, double elapsed) {
  const Eigen::Map<const VectorXd> a(vdot, mechanism_.nv);
  modes_before_ = modes_;
  slow_.clear();
  differenced_slips_.assign(contact_groups * modes_.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < rows_.entries.size(); ++i) {
    const Entry& entry = rows_.entries[i];
    for (std::size_t group = 0; group < contact_groups; ++group) {
      if (entry.moving[group] < 0) continue;
      const double speed = entry.slip[group].norm();
      differenced_slips_[contact_groups * static_cast<std::size_t>(entry.candidate) + group] = entry.slip[group];
      if (!(speed <= slow_sliding)) continue;
      Vector3d& before = modes_[static_cast<std::size_t>(entry.candidate)].groups[group].direction;
      const int row = entry.moving[group];
      const double rise = (rows_.S.row(row).dot(a) + rows_.moving_rates[row]) * elapsed;
      const double becomes = std::max(speed, rise);
      const bool turns = group != 1;  // spinning has an axis
      const auto add_across = [&](const Vector3d& across) {
        const bool is_mirrored = entry.slip[group].dot(before) < 0;
        slow_.push_back({.entry = i,
                         .group = group,
                         .slip = entry.slip[group],
                         .across = across,
                         .turns_with = is_mirrored ? Vector3d(across - 2 * across.dot(before) * before) : across,
                         .speed = becomes});
      };
      if (turns && becomes > 0) {
        const Vector3d& along = entry.along[group];
        const bool in_all_directions = entry.kept(static_cast<int>(group)) == 3;
        const Vector3d across =
            in_all_directions ? Vector3d(along.unitOrthogonal()) : Vector3d(entry.at.n.cross(along));
        add_across(across);
        if (in_all_directions) add_across(along.cross(across));
      }
      before = entry.along[group];
    }
  }
  turning_.setZero(static_cast<Index>(slow_.size()), components);
  keeps_directions_ = true;
  solved_at_ = -1;
}

bool ContactEquations::slides_otherwise() const {
  if (closed_.empty() || differenced_slips_.empty()) return false;
  for (const Entry& entry : rows_.entries) {
    for (std::size_t group = 0; group < contact_groups; ++group) {
      if (entry.moving[group] < 0) continue;
      const Vector3d& slip = entry.slip[group];
      const Vector3d& before = differenced_slips_[contact_groups * static_cast<std::size_t>(entry.candidate) + group];
      const double change = (slip - before).norm();
      if (change > kept_fraction * std::min(slip.norm(), before.norm())) return true;
    }
  }
  return false;
}

void ContactEquations::record_difference(int k, double dy) {
  for (std::size_t i = 0; i < slow_.size(); ++i) {
    const SlowMotion& slow = slow_[i];
    turning_(static_cast<Index>(i), k) =
        slow.turns_with.dot(rows_.entries[slow.entry].slip[slow.group] - slow.slip) / dy;
  }
}

void ContactEquations::end_differences(Eigen::Ref<Eigen::MatrixXd> vdot_y) {
  keeps_directions_ = false;
  set_modes(modes_before_);
  VectorXd force(mechanism_.nv);
  for (std::size_t i = 0; i < slow_.size(); ++i) {
    const SlowMotion& slow = slow_[i];
    const Entry& entry = rows_.entries[slow.entry];
    const auto group = static_cast<int>(slow.group);
    add_row(entry, slow.across, candidates_[entry.candidate].group_turns(group), force.data());
    force *= -coefficient(entry.candidate, group, true) * x_[entry.first] / slow.speed;
    vdot_y += constrained_response(force) * turning_.row(static_cast<Index>(i));
  }
}

// The accelerations due to a force, with the closed contacts of the last accelerate().
VectorXd ContactEquations::constrained_response(const VectorXd& force) {
  RowMatrix response;
  respond(force.transpose(), response);
  VectorXd out = response.col(0);
  const VectorXd left = -(rows_.R * out);
  VectorXd x;
  least_norm_.solve_weighted(G_, left, scale_, x);
  out += Z_ * x;
  return out;
}

}  // namespace gelenk

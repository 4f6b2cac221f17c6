// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of TouchEquations by differences, without and with the directions of slow sliding. The slower sliding is,
// the faster its direction turns: friction c N acts along the unit vector of the sliding velocity u, which a change of
// u across it by du turns by du / |u|.
#include <cmath>

#include "touch/touch_equations.h"
#include "touch/touch_solution.h"

namespace gelenk {

using Eigen::Index;
using Eigen::VectorXd;

void TouchEquations::begin_differences(int components) {
  modes_before_ = modes_;
  slow_.clear();
  for (std::size_t i = 0; i < rows_.entries.size(); ++i) {
    const Entry& entry = rows_.entries[i];
    for (std::size_t group = 0; group < contact_groups; ++group) {
      if (entry.moving[group] < 0) continue;
      modes_[static_cast<std::size_t>(entry.spot)].groups[group].direction = entry.along[group];
      const double speed = entry.slip[group].norm();
      const bool turns = group != 1;  // spinning has an axis
      if (turns && speed <= slow_sliding && speed > 0)
        slow_.push_back({i, group, entry.slip[group], entry.at.n.cross(entry.along[group])});
    }
  }
  turning_.setZero(static_cast<Index>(slow_.size()), components);
  keeps_directions_ = true;
}

void TouchEquations::record_difference(int k, double dy) {
  for (std::size_t i = 0; i < slow_.size(); ++i) {
    const SlowMotion& slow = slow_[i];
    turning_(static_cast<Index>(i), k) = slow.across.dot(rows_.entries[slow.entry].slip[slow.group] - slow.slip) / dy;
  }
}

void TouchEquations::end_differences(Eigen::Ref<Eigen::MatrixXd> vdot_y) {
  keeps_directions_ = false;
  set_modes(modes_before_);
  VectorXd force(mechanism_.nv);
  for (std::size_t i = 0; i < slow_.size(); ++i) {
    const SlowMotion& slow = slow_[i];
    const Entry& entry = rows_.entries[slow.entry];
    add_row(entry, slow.across, slow.group > 0, force.data());
    force *= -coefficient(entry.spot, static_cast<int>(slow.group), true) * x_[entry.first] / slow.slip.norm();
    vdot_y += constrained_response(force) * turning_.row(static_cast<Index>(i));
  }
}

// The accelerations due to a force, with the closed contacts of the last accelerate().
VectorXd TouchEquations::constrained_response(const VectorXd& force) {
  RowMatrix response;
  respond(force.transpose(), response);
  VectorXd out = response.col(0);
  const VectorXd left = -(rows_.R * out);
  out += Z_ * least_norm_solution(least_norm_, G_, left, scale_);
  return out;
}

}  // namespace gelenk

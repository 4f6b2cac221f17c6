// SPDX-License-Identifier: BSD-3-Clause
// The forces of closed contacts, by the multipliers that have been solved for: the part of ContactEquations that
// distributes them.
#include <algorithm>
#include <cmath>

#include "event_driven/contact_equations.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Of the sum of normal forces: what an evaluation may miss of a limit in its mode.
constexpr double overload_rounding = 1e-9;

}  // namespace

// Where friction is redundant, as at the corners of a box, it is shared in proportion to the normal forces.
const VectorXd& ContactEquations::shared() {
  if (closed_.empty() || rows_.entries.size() <= 1 || x_.size() <= static_cast<Index>(rows_.entries.size())) return x_;
  if (shared_is_current_) return shared_;
  shared_is_current_ = true;
  double largest = 0;
  for (const Entry& entry : rows_.entries) largest = std::max(largest, x_[entry.first]);
  weights_ = scale_;
  for (const Entry& entry : rows_.entries) {
    const double share = largest > 0 ? std::sqrt(std::max(1e-6, x_[entry.first] / largest)) : 1;
    for (int group = 0; group < contact_groups; ++group) {
      const int row = entry.rows[static_cast<std::size_t>(group)];
      if (row >= 0) weights_.segment(row, entry.kept(group)) *= share;
    }
  }
  weighted_ = G_;  // by columns alone
  for (Index j = 0; j < weighted_.cols(); ++j) weighted_.col(j) *= weights_[j];
  sharing_.solve_singular(weighted_, right_, shared_);
  shared_.array() *= weights_.array();
  set_given_forces(rows_, x_, shared_);
  return shared_;
}

const std::vector<ContactEquations::CandidateForce>& ContactEquations::forces_of(const VectorXd& x) {
  forces_.clear();
  if (closed_.empty()) return forces_;
  for (const Entry& entry : rows_.entries) {
    CandidateForce& out = forces_.emplace_back();
    out.normal = x[entry.first];
    out.force.setZero();
    out.moment.setZero();
    const ContactCandidate& candidate = candidates_[entry.candidate];
    if (!entry.is_given) (candidate.turns() ? out.moment : out.force) = out.normal * entry.at.n;
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      Vector3d& on = candidate.group_turns(group) ? out.moment : out.force;
      const int row = entry.rows[g];
      if (row >= 0) {
        const auto part = x.segment(row, entry.kept(group));
        out.held[g] = part.norm();
        for (Index k = 0; k < part.size(); ++k) on += part[k] * entry.axis(group, k);
      } else {
        on -= coefficient(entry.candidate, group, true) * out.normal * entry.along[g];
      }
    }
  }
  return forces_;
}

bool ContactEquations::are_overloaded() const {
  if (closed_.empty() || !least_norm_.was_unique()) return false;
  double slack = 0;
  for (const Entry& entry : rows_.entries) slack += overload_rounding * std::abs(x_[entry.first]);
  for (const Entry& entry : rows_.entries) {
    const double normal = x_[entry.first];
    if (normal < -slack) return true;
    for (int group = 0; group < contact_groups; ++group) {
      const int row = entry.rows[static_cast<std::size_t>(group)];
      if (row < 0) continue;
      if (x_.segment(row, entry.kept(group)).norm() > coefficient(entry.candidate, group, false) * normal + slack)
        return true;
    }
  }
  return false;
}

void set_given_forces(const ContactEquations::Rows& rows, const VectorXd& given, VectorXd& x) {
  for (const ContactEquations::Entry& entry : rows.entries) {
    if (entry.is_given) x[entry.first] = given[entry.first];
  }
}

void add_wrenches(const ContactEquations& contact_equations,
                  const std::vector<ContactEquations::CandidateForce>& forces, std::vector<Spatial::Force>& out) {
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const ContactEquations::Entry& entry = contact_equations.rows().entries[i];
    const ContactCandidate& candidate = contact_equations.candidates()[entry.candidate];
    const Spatial::Force on_tip{forces[i].moment + entry.at.p.cross(forces[i].force), forces[i].force};
    out[static_cast<std::size_t>(candidate.tip_link)] += on_tip;
    out[static_cast<std::size_t>(candidate.core_link)] -= on_tip;
  }
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/loop_geometry.h"

#include <algorithm>
#include <variant>

#include "element/constraints/cut_joint.h"
#include "joint/kinds.h"
#include "joint/rows.h"
#include "kinematics/coordinate_rows.h"
#include "math/rotations.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

template <class Joint>
bool has_one_axis(const Joint& joint) {
  return std::visit(
      [](const auto& j) {
        if constexpr (requires { j.axes; }) {
          return j.axes == 1;
        } else {
          return false;
        }
      },
      joint);
}

Pose3 link_pose(const TreeJoint& joint, const double* q) {
  return std::visit([&](const auto& j) { return j.template X_FM<Spatial>(q); }, joint);
}

// Column k of S, in M.
Spatial::Motion motion(const TreeJoint& joint, const double* q, int k) {
  double v[max_cut_nv] = {};
  v[k] = 1;
  return std::visit([&](const auto& j) { return j.template V_FM<Spatial>(q, v); }, joint);
}

Spatial::Motion unit_twist(int k) {
  Spatial::Motion out;
  (k < 3 ? out.w : out.v)[k % 3] = 1;
  return out;
}

}  // namespace

LoopGeometry::LoopGeometry(const Mechanism& mechanism) : mechanism_(mechanism), of_links_(mechanism.links.size()) {
  std::vector<bool> in_loop(mechanism.links.size(), false);
  for (const Cut& cut : mechanism.cuts) {
    Ends& ends = of_cuts_.emplace_back();
    if (cut.is_contact() || cut.is_rod()) continue;
    for (const auto* path : {&cut.path_a, &cut.path_b}) {
      for (const int link : *path) in_loop[link] = true;
    }
    const int j = cut.scene_joints.front();
    const bool axis = has_one_axis(*cut.joint);
    ends.inner = add_frame(j, false, axis, cut.link_a, cut.X_AF);
    ends.outer = add_frame(j, true, axis, cut.link_b, cut.X_BM);
    rows_ += cut.rows;
  }
  for (std::size_t i = 1; i < mechanism.links.size(); ++i) {
    if (!in_loop[i]) continue;
    const Link& link = mechanism.links[i];
    const bool axis = has_one_axis(*link.joint);
    of_links_[i].inner = add_frame(link.scene_joint, link.reversed, axis, link.parent, link.X_PJ);
    of_links_[i].outer = add_frame(link.scene_joint, !link.reversed, axis, static_cast<int>(i), Pose3());
  }
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    if (!row.moves() && row.holds_position) coordinate_rows_.push_back(&row);
  }
  if (rows_ > 0) rows_ += static_cast<Index>(coordinate_rows_.size());
}

int LoopGeometry::add_frame(int scene_joint, bool child, bool has_axis, int link, const Pose3& X) {
  frames_.push_back(
      {.scene_joint = scene_joint, .child = child, .has_axis = has_axis, .link = link, .X_given = X, .X = X});
  return static_cast<int>(frames_.size()) - 1;
}

double LoopGeometry::size() const {
  double out = 1;
  for (const Frame& frame : frames_) out = std::max(out, frame.X_given.p.norm());
  return out;
}

std::vector<Pose3> LoopGeometry::link_poses(const std::vector<double>& q) const {
  std::vector<Pose3> X_0L(mechanism_.links.size());
  for (std::size_t i = 1; i < X_0L.size(); ++i) {
    const Link& link = mechanism_.links[i];
    const Ends& ends = of_links_[i];
    const Pose3& X_PJ = ends.inner < 0 ? link.X_PJ : frames_[ends.inner].X;
    X_0L[i] = X_0L[link.parent] * X_PJ * link_pose(*link.joint, &q[link.iq]);
    if (ends.outer >= 0) X_0L[i] = X_0L[i] * frames_[ends.outer].X.inverse();
  }
  return X_0L;
}

void LoopGeometry::add_twist_columns(const Pose3& X, double sign, const Spatial::Force* wrenches, Index first,
                                     int count, int frame, MatrixXd& A) const {
  for (int k = 0; k < 6; ++k) {
    const Spatial::Motion V = X.to_parent(unit_twist(k));
    for (int r = 0; r < count; ++r) A(first + r, 6 * frame + k) += sign * Spatial::dot(V, wrenches[r]);
  }
}

void LoopGeometry::add_motion_columns(const std::vector<double>& q, const std::vector<Pose3>& X_0L, const Cut& cut,
                                      const Spatial::Force* wrenches, Index first, int count, Equations& out) const {
  for (const bool b : {false, true}) {
    const double sign = b ? 1 : -1;
    for (const int i : b ? cut.path_b : cut.path_a) {
      const Link& link = mechanism_.links[i];
      const Pose3 X_0M = X_0L[i] * frames_[of_links_[i].outer].X;
      for (int k = 0; k < link.nv; ++k) {
        const Spatial::Motion S = X_0M.to_parent(motion(*link.joint, &q[link.iq], k));
        for (int r = 0; r < count; ++r) out.J(first + r, link.iv + k) += sign * Spatial::dot(S, wrenches[r]);
      }
      const Pose3 X_0F = X_0L[link.parent] * frames_[of_links_[i].inner].X;
      add_twist_columns(X_0F, sign, wrenches, first, count, of_links_[i].inner, out.A);
      add_twist_columns(X_0M, -sign, wrenches, first, count, of_links_[i].outer, out.A);
    }
  }
}

LoopGeometry::Equations LoopGeometry::equations(const std::vector<double>& q) const {
  Equations out{.Phi = VectorXd::Zero(rows_),
                .J = MatrixXd::Zero(rows_, mechanism_.nv),
                .A = MatrixXd::Zero(rows_, static_cast<Index>(6 * frames_.size()))};
  const std::vector<Pose3> X_0L = link_poses(q);
  Index next = 0;
  for (std::size_t c = 0; c < mechanism_.cuts.size(); ++c) {
    const Ends& ends = of_cuts_[c];
    if (ends.inner < 0) continue;
    const Cut& cut = mechanism_.cuts[c];
    const Pose3 X_0F = X_0L[cut.link_a] * frames_[ends.inner].X;
    const Pose3 X_0M = X_0L[cut.link_b] * frames_[ends.outer].X;
    Row<Spatial> rows[6];
    const Pose3 X_FM = X_0F.inverse() * X_0M;
    std::visit([&](const auto& joint) { joint.template rows<Spatial>(X_FM, rows); }, *cut.joint);
    Spatial::Force wrenches[6];
    for (int r = 0; r < cut.rows; ++r) {
      const Row<Spatial>& row = rows[cut.kept[r]];
      out.Phi[next + r] = row.Phi;
      wrenches[r] = Pose3{X_0F.R, X_0M.p}.to_parent(row.w);  // along F's axes, about M's origin
    }
    add_motion_columns(q, X_0L, cut, wrenches, next, cut.rows, out);
    add_twist_columns(X_0F, -1, wrenches, next, cut.rows, ends.inner, out.A);
    add_twist_columns(X_0M, 1, wrenches, next, cut.rows, ends.outer, out.A);
    next += cut.rows;
  }
  for (std::size_t i = 0; i < coordinate_rows_.size() && next < rows_; ++i, ++next) {
    const CoordinateRow& row = *coordinate_rows_[i];
    if (row.relation) {
      double factors[RelationLaw::most_terms];
      out.Phi[next] = kernels::relation_value(row, q.data(), factors);
      for (std::size_t k = 0; k < row.terms.size(); ++k) out.J(next, row.terms[k].v) += factors[k];
      continue;
    }
    out.Phi[next] = -row.constant;
    for (const CoordinateRow::Term& term : row.terms) {
      out.Phi[next] += term.factor * q[term.q];
      out.J(next, term.v) += term.factor;
    }
  }
  return out;
}

std::vector<double> LoopGeometry::displaced(std::vector<double> q, const VectorXd& dv) const {
  double dq[max_cut_nq];
  for (std::size_t i = 1; i < mechanism_.links.size(); ++i) {
    const Link& link = mechanism_.links[i];
    double* q_i = q.data() + link.iq;
    std::visit(
        [&](const auto& joint) {
          joint.qdot_from_v(q_i, dv.data() + link.iv, dq);
          for (int k = 0; k < link.nq; ++k) q_i[k] += dq[k];
          joint.normalize(q_i);
        },
        *link.joint);
  }
  return q;
}

void LoopGeometry::move(const VectorXd& d) {
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const Vector3d turn = d.segment<3>(static_cast<Index>(6 * i));
    const Vector3d shift = d.segment<3>(static_cast<Index>(6 * i + 3));
    Pose3& X = frames_[i].X;
    X.p += X.R * shift;
    if (const double angle = turn.norm(); angle > 0) {
      X.R = orthonormalized(Eigen::Matrix3d(X.R * Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()));
    }
  }
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/rest_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/independent_columns.h"
#include "assembly/loop_closure.h"
#include "element/constraints/cut_joint.h"
#include "kinematics/branches.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Whether velocity i of a joint is an angular velocity. Rods rotate at both ends.
template <class Joint>
bool is_turn(const Joint& joint, int i) {
  return std::visit(
      [i](const auto& j) {
        if constexpr (requires { j.v_names; }) return j.v_names[static_cast<std::size_t>(i)].unit == "rad/s";
        return true;
      },
      joint);
}

}  // namespace

bool RestPose::is_on_bounds() const {
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    const int side = contacts[i];
    if (side != 0 && std::abs(depth(i, side).depth) > depth(i, side).tolerance) return false;
  }
  return true;
}

bool RestPose::is_balanced() const {
  const VectorXd terms = A.cwiseAbs().rowwise().sum();
  return (a.array().abs() <= equilibrium_rate_tolerance + equilibrium_rounding_tolerance * terms.array()).all();
}

RestPoses::RestPoses(const EquilibriumProblem& of)
    : of_(of),
      mechanism_(of.mechanism),
      dynamics_(make_dynamics(of.mechanism, of.loads)),
      zero_velocity_(mechanism_.nv, 0.0),
      sides_(forces().count(), branch_of_state),
      time_scale_squared_(of.time * of.time) {
  dynamics_->set_max_rank(of.mobility.rank);
  dynamics_->set_targets(with_two_derivatives(of.targets).data());
}

// Enters the modes of the pose.
void RestPoses::hold(const RestPose& at) {
  if (locks() == 0) return;
  for (int i = 0; i < locks(); ++i) {
    const Branching::Lock lock = forces().lock(i);
    const bool sticks = friction_holds_ && lock.sticking_limit.largest() > 0;
    if (lock.friction >= 0) sides_[static_cast<std::size_t>(lock.friction)] = sticks ? 0 : branch_released;
    if (lock.limit >= 0) sides_[static_cast<std::size_t>(lock.limit)] = at.contacts[i];
  }
  forces().hold(sides_.data());
}

void RestPoses::evaluate(RestPose& at) {
  at.contacts.resize(static_cast<std::size_t>(locks()));
  hold(at);
  dynamics_->set_cut_reference(at.cut_q.data());
  dynamics_->set_position(at.q.data());
  dynamics_->factorize();
  dynamics_->set_velocity(zero_velocity_.data());
  at.vdot.resize(mechanism_.nv);
  dynamics_->solve(of_.u.data(), at.vdot.data());
  at.vdot *= time_scale_squared_;
  for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) unwrap_angles(c, at.cut_q);
  at.depths.clear();
  for (int i = 0; i < locks(); ++i) at.depths.push_back({forces().depth(i, 1), forces().depth(i, -1)});
}

// Unwraps the angles of a cut joint: they are continued from their previous values.
void RestPoses::unwrap_angles(int c, std::vector<double>& cut_q) const {
  const Cut& cut = mechanism_.cuts[static_cast<std::size_t>(c)];
  double found[max_cut_nq];
  std::copy_n(cut_q.data() + cut.iq, cut.nq, found);
  dynamics_->cut_coordinates(c, found);
  for (int i = 0; i < cut.nq; ++i) {
    double& q = cut_q[cut.iq + i];
    q = cut.is_angle[static_cast<std::size_t>(i)] ? q + std::remainder(found[i] - q, 2 * std::numbers::pi) : found[i];
  }
}

void RestPoses::differentiate(RestPose& at) {
  const int nv = mechanism_.nv;
  const std::vector<bool> any(static_cast<std::size_t>(nv), false);
  const Independent by = independent_at(mechanism_, *dynamics_, of_.mobility, any, any);
  ConstrainedSensitivity sensitivity(mechanism_, of_.loads, of_.mobility, by, static_cast<int>(of_.u.size()));
  if (locks() > 0) sensitivity.hold(sides_);
  sensitivity.set_point(at.q.data(), zero_velocity_.data(), of_.u.data(), at.cut_q.data(), of_.targets);
  const auto n = static_cast<Index>(by.coordinates.size());
  const auto m = static_cast<Index>(by.speeds.size());
  MatrixXd dq = MatrixXd::Zero(mechanism_.nq, n + m);
  MatrixXd dv = MatrixXd::Zero(nv, n + m);
  for (Index k = 0; k < n; ++k) {
    const VectorXd z = VectorXd::Unit(nv, by.coordinates[static_cast<std::size_t>(k)]);
    dynamics_->qdot_from_v(at.q.data(), z.data(), dq.col(k).data());
  }
  for (Index k = 0; k < m; ++k) dv(by.speeds[static_cast<std::size_t>(k)], n + k) = 1;
  const MatrixXd moved =
      sensitivity.state_derivative(dq, dv, MatrixXd::Zero(static_cast<Index>(of_.u.size()), n + m)).y;
  at.speeds = by.speeds;
  at.a = at.vdot(by.speeds);
  at.A = time_scale_squared_ * moved.bottomRows(nv)(by.speeds, Eigen::seqN(0, n));
  at.displacement_jacobian = displacements(mechanism_, at.q.data(), moved.topLeftCorner(mechanism_.nq, n));
  at.velocity_jacobian = moved.block(mechanism_.nq, n, nv, m);
  at.coordinate_rates = at.velocity_jacobian(by.coordinates, Eigen::all);
  at.contact_rows.resize(std::ranges::count_if(at.contacts, [](int side) { return side != 0; }), n);
  at.contact_gaps.resize(at.contact_rows.rows());
  Index row = 0;
  for (int i = 0; i < locks(); ++i) {
    const int side = at.contacts[i];
    if (side == 0) continue;
    for (Index k = 0; k < n; ++k) at.contact_rows(row, k) = forces().speed(i, at.displacement_jacobian.col(k).data());
    at.contact_gaps[row++] = -side * at.depth(i, side).depth;
  }
}

std::optional<RestPose> RestPoses::closed_neighbor(const RestPose& here, const VectorXd& z) {
  RestPose there{.q = here.q, .cut_q = here.cut_q, .contacts = here.contacts};
  dynamics_->displace(there.q.data(), z.data());
  if (!close_rows(mechanism_, *dynamics_, there.q)) return {};
  try {
    evaluate(there);
  } catch (const SingularMass&) {
    return {};
  }
  return there;
}

bool RestPoses::touch(RestPose& at) {
  bool any = false;
  for (int i = 0; i < locks(); ++i) {
    for (const int side : {1, -1}) {
      const Branching::Depth& depth = at.depth(i, side);
      if (at.contacts[i] != 0 || depth.depth < -depth.tolerance) continue;
      at.contacts[i] = side;
      any = true;
    }
  }
  if (any) evaluate(at);
  return any;
}

VectorXd RestPoses::joint_rotations(const RestPose& here, const VectorXd& z) {
  std::vector<double> out;
  const auto add = [&](const auto& joint, int nv, const double* v) {
    for (int i = 0; i < nv; ++i) {
      if (is_turn(joint, i)) out.push_back(v[i]);
    }
  };
  for (const Link& link : mechanism_.links) add(*link.joint, link.nv, z.data() + link.iv);
  dynamics_->set_position(here.q.data());
  dynamics_->set_velocity(z.data());
  double v[max_cut_nv];
  for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
    dynamics_->readings().cut_speeds(c, v);
    add(*mechanism_.cuts[static_cast<std::size_t>(c)].joint, mechanism_.cuts[static_cast<std::size_t>(c)].nv, v);
  }
  return Eigen::Map<const VectorXd>(out.data(), static_cast<Index>(out.size()));
}

}  // namespace gelenk

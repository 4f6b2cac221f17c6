// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/constrained_sensitivity_impl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "analysis/dual_columns.h"
#include "decomposition/singular_values.h"
#include "joint/registry.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Relative to the smallest pivot of a regular position. Near a position where the constraint Jacobian loses rank,
// accelerations are quotients of two numbers that vanish there in proportion to this fraction s, and their derivatives
// have errors of some 1e-16 / s^3: 1e-7 here.
constexpr double near_singular_fraction = 1e-3;
// Iterations for friction of joints that follows the forces of contacts, and changes of these that are rounding.
constexpr int most_passes = 40;
constexpr double enough_passed = 1e-13;

}  // namespace

std::vector<double> with_two_derivatives(const std::vector<MotionLaw::Derivatives>& targets) {
  std::vector<double> out;
  for (const MotionLaw::Derivatives& s : targets) out.insert(out.end(), s.begin(), s.begin() + 3);
  return out;
}

MatrixXd displacements(const Mechanism& mechanism, const double* q, const MatrixXd& dq) {
  MatrixXd z = MatrixXd::Zero(mechanism.nv, dq.cols());
  for (Index k = 0; k < dq.cols(); ++k) {
    for (const Link& link : mechanism.links) {
      if (link.nv == 0 || dq.col(k).segment(link.iq, link.nq).isZero(0)) continue;
      std::visit(
          [&](const auto& joint) {
            joint.v_from_qdot(q + link.iq, dq.col(k).data() + link.iq, z.col(k).data() + link.iv);
          },
          *link.joint);
    }
  }
  return z;
}

ConstrainedSensitivity::ConstrainedSensitivity(const Mechanism& mechanism, const Loads& loads,
                                               const MobilityAnalysis& mobility, const Independent& independent,
                                               int inputs)
    : mechanism_(mechanism),
      rank_(mobility.rank),
      position_rank_(mobility.position_rank),
      best_pivot_ratio_(mobility.best_pivot_ratio),
      loads_(loads),
      inputs_(inputs),
      dynamics_(make_dynamics(mechanism, loads)),
      q_(mechanism.nq),
      v_(mechanism.nv),
      u_(inputs),
      vdot_(mechanism.nv),
      lambda_(mechanism.rows),
      rates_(loads.states()),
      x_in_time_(mechanism.nv) {
  for (int k = 0; k < mechanism.nv; ++k) {
    if (std::ranges::find(independent.coordinates, k) == independent.coordinates.end()) {
      of_positions_.dependent.push_back(k);
    }
    if (std::ranges::find(independent.speeds, k) == independent.speeds.end()) of_speeds_.dependent.push_back(k);
  }
  const std::vector<bool> holds = mechanism.position_rows();
  for (int r = 0; r < mechanism.rows; ++r) {
    of_speeds_.rows.push_back(r);
    if (holds[r]) of_positions_.rows.push_back(r);
  }
  dynamics_->set_max_rank(rank_);
  jacobians_.of_inputs = true;
  if (mechanism.touches() && !loads.contacts.empty())
    contacts_ = std::make_unique<HeldContacts>(mechanism, *dynamics_, loads);
  dual_state_.equations = make_residual_evaluator<Dual>(mechanism, loads);
  series_state_.equations = make_residual_evaluator<Series>(mechanism, loads);
}

void ConstrainedSensitivity::set_point(const double* q, const double* v, const double* u, const double* cut_q,
                                       const std::vector<MotionLaw::Derivatives>& targets) {
  stages_.realize(Stage::position);
  stages_.realize(Stage::velocity);
  std::copy_n(q, mechanism_.nq, q_.begin());
  std::copy_n(v, mechanism_.nv, v_.begin());
  std::copy_n(u, inputs_, u_.begin());
  cut_q_.assign(cut_q, cut_q + mechanism_.cut_nq);
  targets_ = targets;
  Dynamics& d = *dynamics_;
  d.set_cut_reference(cut_q);
  d.set_targets(with_two_derivatives(targets_).data());
  d.set_position(q);
  d.factorize();
  d.set_velocity(v);
  d.solve(u, vdot_.data());
  if (touches()) find_contact_forces(u);
  d.readings().state_rates(u, rates_.data());
  holding_ = d.switching_forces().holding_forces().values();
  if (!is_empty(*loads_.forces)) {
    d.readings().set_root_poses();
    const int force = undefined_force(*loads_.forces, d.readings());
    if (force >= 0) throw NotDifferentiablePoint(NotDifferentiablePoint::What::spring, force);
  }
  redundant_ = false;
  if (mechanism_.rows > 0) find_multipliers();
  if (touches()) contacts_->withdraw();
}

void ConstrainedSensitivity::find_multipliers() {
  Dynamics& d = *dynamics_;
  d.set_acceleration(vdot_.data());  // for lambda
  if (rank_ > 0 && d.pivot_ratio() < std::max(singular_pivot_ratio, near_singular_fraction * best_pivot_ratio_)) {
    throw NotDifferentiablePoint(NotDifferentiablePoint::What::rows);
  }
  lambda_ = Eigen::Map<const VectorXd>(d.lambda().data(), mechanism_.rows);
  J_ = d.J();
  redundant_ = rank_ < mechanism_.rows;
  if (redundant_) find_null_multipliers();
}

void ConstrainedSensitivity::hold(std::vector<int> sides, const ContactHold& contacts) {
  if (contacts_) contacts_->hold(contacts);
  sides_ = std::move(sides);
  const int* held = sides_.empty() ? nullptr : sides_.data();
  dynamics_->switching_forces().hold(held);
  dual_state_.equations->hold(held);
  series_state_.equations->hold(held);
  dual_state_.modes = series_state_.modes = held;
}

// The given velocities: those of the independent coordinates that are not locked.
MatrixXd ConstrainedSensitivity::given_velocities(const MatrixXd& dv) const {
  MatrixXd out = dv;
  for (const int k : of_speeds_.dependent) out.row(k).setZero();
  for (Index k = 0; k < dv.cols() && !sides_.empty(); ++k) dynamics_->switching_forces().clear(out.col(k).data());
  return out;
}

// The same velocities, but nothing that is locked moves.
MatrixXd ConstrainedSensitivity::stopped(MatrixXd dv) const {
  for (Index k = 0; k < dv.cols() && !sides_.empty(); ++k) dynamics_->switching_forces().stop(dv.col(k).data());
  return dv;
}

void ConstrainedSensitivity::find_null_multipliers() {
  const SingularValues svd(J_);
  const MatrixXd U = svd.U.leftCols(rank_);
  null_multipliers_ = MatrixXd::Identity(mechanism_.rows, mechanism_.rows) - U * U.transpose();
  inverse_ = svd.V.leftCols(rank_) * svd.sigma.head(rank_).cwiseInverse().asDiagonal() * U.transpose();
  x_ = inverse_ * lambda_;
}

// Solves [M J^T; J 0] [x; l] = -[r; c]; x is stored in r. holding: the change of the holding forces.
void ConstrainedSensitivity::solve(VectorXd& r, const VectorXd& c, VectorXd& l, VectorXd& holding) const {
  r = -r;
  const VectorXd target = -c;
  l.resize(mechanism_.rows);
  holding.setZero(dynamics_->switching_forces().locks());
  dynamics_->solve_linear(r.data(), target.data(), l.data(), holding.data());
}

void ConstrainedSensitivity::differentiate_targets(const MatrixXd& du) {
  std::array<MatrixXd, 3> changes;
  for (int order = 0; order < 3; ++order) changes[static_cast<std::size_t>(order)] = changes_of_targets(order, du);
  set_targets(dual_state_, [&](std::size_t i, int order) {
    Dual s(targets_[i][static_cast<std::size_t>(order)]);
    const MatrixXd& change = changes[static_cast<std::size_t>(order)];
    for (Index k = 0; k < du.cols(); ++k) s.derivatives()[k] = change(static_cast<Index>(i), k);
    return s;
  });
}

// Completes dq: the independent coordinates change by dq, the dependent ones as the constraints require.
MatrixXd ConstrainedSensitivity::complete_dq(const MatrixXd& dq, const MatrixXd& du) const {
  const Index n = dq.cols();
  MatrixXd z = displacements(mechanism_, q_.data(), dq);
  for (const int k : of_positions_.dependent) z.row(k).setZero();
  if (mechanism_.rows > 0) {
    MatrixXd residuals = J_ * z;  // minus the change of the targets
    residuals.bottomRows(static_cast<Index>(targets_.size())) -= changes_of_targets(0, du);
    z += of_positions_.solve(residuals, mechanism_.nv);
  }
  if (touches()) contacts_->close(z);
  MatrixXd moved(mechanism_.nq, n);
  for (Index k = 0; k < n; ++k) {
    if (z.col(k).isZero(0)) {
      moved.col(k).setZero();
    } else {
      dynamics_->qdot_from_v(q_.data(), z.col(k).data(), moved.col(k).data());
    }
  }
  return moved;
}

VectorXd ConstrainedSensitivity::point() const {
  VectorXd out(mechanism_.nq + 2 * mechanism_.nv);
  out << q_, v_, vdot_;
  return out;
}

VectorXd ConstrainedSensitivity::qdot() const {
  VectorXd out(mechanism_.nq);
  dynamics_->qdot_from_v(q_.data(), v_.data(), out.data());
  return out;
}

void ConstrainedSensitivity::update_partition() {
  if (mechanism_.rows == 0 || partition_.holds(stages_)) return;
  of_positions_.compute(J_, position_rank_);
  of_speeds_.compute(J_, rank_);
  partition_.set(stages_);
}

MovedState ConstrainedSensitivity::state_derivative(const MatrixXd& dq, const MatrixXd& dv, const MatrixXd& du) {
  if (touches()) return state_derivative_in_contact(dq, dv, du);
  update_partition();
  if (!jacobians_known_.holds(stages_)) {
    dynamics_->differentiate(u_.data(), inputs_, vdot_.data(), jacobians_, lambda_.data());
    jacobians_known_.set(stages_);
  }
  const Index nq = mechanism_.nq;
  const Index nv = mechanism_.nv;
  const Index n = dq.cols();
  MovedState out;
  const Index states = rates_.size();
  out.y.resize(nq + 2 * nv + states, n);
  out.y.bottomRows(states) = du.bottomRows(states);
  auto q = out.y.topRows(nq);
  auto v = out.y.middleRows(nq, nv);
  q = complete_dq(dq, du);
  v = given_velocities(dv);
  RowMatrix r = RowMatrix::Zero(nv, n);
  RowMatrix c(mechanism_.rows, n);
  if (mechanism_.rows > 0) {
    MatrixXd rates = jacobians_.rate_q * q + J_ * v;  // minus the change of the targets
    rates.bottomRows(static_cast<Index>(targets_.size())) -= changes_of_targets(1, du);
    v += of_speeds_.solve(rates, nv);
  }
  v = stopped(v);
  if (mechanism_.rows > 0) {
    c.noalias() = jacobians_.c * out.y.topRows(nq + nv);
    c.bottomRows(static_cast<Index>(targets_.size())) -= changes_of_targets(2, du);
  }
  if (states > 0) {
    out.state_rates = jacobians_.rates * out.y.topRows(nq + nv);
    out.state_rates.noalias() += jacobians_.rates_u.leftCols(inputs_) * du;
  }
  add_product(jacobians_.r, out.y, nq + nv, r);
  add_product(jacobians_.r_u, du, inputs_, r);
  dynamics_->solve_linear_columns(r.data(), c.data(), static_cast<int>(n));
  out.y.middleRows(nq + nv, nv) = -r;
  if (nq == nv) return out;
  out.qdot.setZero(nq, n);
  add_product(jacobians_.qdot_q, q, nq, out.qdot);
  add_product(jacobians_.qdot_v, v, nv, out.qdot);
  return out;
}

CarriedState<Dual>& ConstrainedSensitivity::directional_derivative(const MatrixXd& dq, const MatrixXd& dv,
                                                                   const MatrixXd& du) {
  update_partition();
  begin(dual_state_);
  set_derivatives(du, dual_state_.u);
  differentiate_targets(du);
  set_derivatives(complete_dq(dq, du), dual_state_.q);
  dual_state_.equations->set_position(dual_state_.q.data());
  MatrixXd null_multipliers = MatrixXd::Zero(mechanism_.rows, dq.cols());
  if (redundant_) {
    // lambda = J x, so the part of its change that does not enter the equations of motion is that of dJ x.
    const std::vector<Dual> targets = dual_state_.targets;
    set_targets(dual_state_, [](std::size_t, int) { return Dual(0); });
    set_values(x_, dual_state_.v);
    dual_state_.equations->set_velocity(dual_state_.v.data());
    null_multipliers = null_multipliers_ * derivative_columns(dual_state_.equations->row_rates(), dq.cols());
    set_values(v_, dual_state_.v);
    dual_state_.targets = targets;
    dual_state_.equations->set_targets(dual_state_.targets.data());
  }
  differentiate_velocity(dv);
  differentiate_acceleration(null_multipliers);
  return dual_state_;
}

void ConstrainedSensitivity::differentiate_velocity(const MatrixXd& dv) {
  MatrixXd given = given_velocities(dv);
  set_derivatives(given, dual_state_.v);
  dual_state_.equations->set_velocity(dual_state_.v.data());
  if (of_speeds_.dependent.empty() && sides_.empty() && !touches()) return;
  if (!of_speeds_.dependent.empty())
    given += of_speeds_.solve(derivative_columns(dual_state_.equations->row_rates(), dv.cols()), mechanism_.nv);
  given = stopped(given);
  set_derivatives(given, dual_state_.v);
  dual_state_.equations->set_velocity(dual_state_.v.data());
  if (!touches()) return;
  contacts_->stop(contacts_->kept_speeds(*dual_state_.equations, dv.cols()), given);
  set_derivatives(given, dual_state_.v);
  dual_state_.equations->set_velocity(dual_state_.v.data());
}

void ConstrainedSensitivity::differentiate_acceleration(const MatrixXd& null_multipliers) {
  const Index n = null_multipliers.cols();
  MatrixXd dvdot = MatrixXd::Zero(mechanism_.nv, n);
  MatrixXd dlambda = null_multipliers;
  MatrixXd dholding = MatrixXd::Zero(dynamics_->switching_forces().locks(), n);
  MatrixXd dx = MatrixXd::Zero(touches() ? contacts_->rows() : 0, n);
  // One pass is exact, but for friction of joints that follows the forces of contacts.
  const bool repeats = touches() && !dynamics_->switching_forces().loads().empty();
  const auto correct = [&](MatrixXd& a, MatrixXd& l, MatrixXd& h, MatrixXd& x) {
    for (int pass = 0; pass < (repeats ? most_passes : 1); ++pass) {
      if (correct_accelerations(a, l, h, x, pass > 0) <= enough_passed) break;
    }
  };
  const auto with_present_forces = [&] {
    MatrixXd a = MatrixXd::Zero(mechanism_.nv, n), l = null_multipliers, h = dholding, x = MatrixXd::Zero(dx.rows(), n);
    correct(a, l, h, x);
    return a;
  };
  if (touches()) require_determined_prestress(*contacts_, with_present_forces);
  correct(dvdot, dlambda, dholding, dx);
  std::vector<Dual> holding(holding_.begin(), holding_.end());
  for (std::size_t i = 0; i < holding.size(); ++i)
    holding[i].derivatives().head(n) = dholding.row(static_cast<Index>(i)).transpose().array();
  if (dynamics_->switching_forces().is_redundant()) {
    dlambda.setConstant(undetermined);
    for (Dual& force : holding) force.derivatives().setConstant(undetermined);
  }
  if (touches())
    undetermine_reactions(
        *contacts_, [&](VectorXd& r, VectorXd& l, VectorXd& x) { solve(r, VectorXd::Zero(mechanism_.rows), l, x); },
        dlambda, holding);
  evaluate_accelerations(dvdot, dlambda, dx, true);
  set_forces(dual_state_, holding);
}

void ConstrainedSensitivity::evaluate_accelerations(const MatrixXd& dvdot, const MatrixXd& dlambda, const MatrixXd& dx,
                                                    bool shows_redundant) {
  ResidualEvaluator<Dual>& e = *dual_state_.equations;
  set_derivatives(dvdot, dual_state_.vdot);
  set_derivatives(dlambda, dual_state_.lambda);
  e.apply_forces(nullptr);
  dual_state_.contact_forces.clear();
  if (touches()) {
    contacts_->apply(e, dx, shows_redundant);
    dual_state_.contact_forces = contacts_->forces();
  }
  e.set_acceleration(dual_state_.u.data(), dual_state_.vdot.data(), dual_state_.lambda.data());
}

// Adds what the residuals lack; returns the largest change.
double ConstrainedSensitivity::correct_accelerations(MatrixXd& dvdot, MatrixXd& dlambda, MatrixXd& dholding,
                                                     MatrixXd& dx, bool again) {
  ResidualEvaluator<Dual>& e = *dual_state_.equations;
  const MatrixXd none = MatrixXd::Zero(dlambda.rows(), dlambda.cols());
  evaluate_accelerations(dvdot, again ? dlambda : none, dx, false);
  const MatrixXd kept = touches() ? contacts_->kept_accelerations(e, dvdot.cols()) : MatrixXd();
  double change = 0;
  VectorXd l;
  VectorXd x;
  for (Index k = 0; k < dvdot.cols(); ++k) {
    const VectorXd residual = derivatives_along(e.force_residual(), static_cast<int>(k));
    const VectorXd c = derivatives_along(e.acceleration_residual(), static_cast<int>(k));
    VectorXd r = residual;
    solve(r, c, l, x);
    if (touches()) {
      const VectorXd forces = contacts_->change_of_forces(r, kept.col(k));
      dx.col(k) += forces;
      change = std::max(change, forces.size() > 0 ? forces.cwiseAbs().maxCoeff() : 0);
      r = residual - contacts_->generalized(forces);
      solve(r, c, l, x);
    }
    dvdot.col(k) += r;
    dlambda.col(k) += l;
    dholding.col(k) = x;  // the residuals are without them
  }
  return change;
}

}  // namespace gelenk

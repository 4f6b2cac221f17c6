// SPDX-License-Identifier: BSD-3-Clause
// The part of ConstrainedSensitivity that concerns closed contacts.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "analysis/constrained_sensitivity_impl.h"
#include "analysis/dual_columns.h"
#include "mechanism/mechanism.h"

namespace gelenk {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void put_columns(const std::vector<Dual>& from, Index row, Index first, Index width, MatrixXd& to) {
  to.block(row, first, static_cast<Index>(from.size()), width) = derivative_columns(from, width);
}

using Part = std::function<CarriedState<Dual>&(Index first, Index width)>;

// Joins the derivatives along up to dual_directions directions each; du: of all.
MovedState joined(const Mechanism& mechanism, Index states, const MatrixXd& du, const Part& part) {
  const Index nq = mechanism.nq;
  const Index nv = mechanism.nv;
  const Index n = du.cols();
  MovedState out;
  out.y.resize(nq + 2 * nv + states, n);
  out.y.bottomRows(states) = du.bottomRows(states);
  if (nq != nv) out.qdot.resize(nq, n);
  if (states > 0) out.state_rates.resize(states, n);
  std::vector<Dual> rates(static_cast<std::size_t>(states));
  for (Index first = 0; first < n; first += dual_directions) {
    const Index width = std::min<Index>(dual_directions, n - first);
    CarriedState<Dual>& at = part(first, width);
    put_columns(at.q, 0, first, width, out.y);
    put_columns(at.v, nq, first, width, out.y);
    put_columns(at.vdot, nq + nv, first, width, out.y);
    if (nq != nv) put_columns(at.equations->qdot(), 0, first, width, out.qdot);
    if (states == 0) continue;
    at.equations->state_rates(at.u.data(), rates.data());
    put_columns(rates, 0, first, width, out.state_rates);
  }
  return out;
}

}  // namespace

// Their forces are loads from here on.
void ConstrainedSensitivity::find_contact_forces(const double* u) {
  contacts_->set_point(v_.data(), u, vdot_.data());
  const int ambiguous = contacts_->ambiguous_contact();
  if (ambiguous < 0) return;
  contacts_->withdraw();
  throw NotDifferentiablePoint(LawEdge{ambiguous, LawEdge::Of::redundant_normal_forces});
}

void undetermine_reactions(const HeldContacts& contacts, const Response& respond, MatrixXd& dlambda,
                           std::vector<Dual>& holding) {
  constexpr double no_effect = 1e-9;  // of redundant multipliers, whose largest entry is 1 in order
  VectorXd l;
  VectorXd x;
  for (Index k = 0; k < contacts.redundant().cols(); ++k) {
    VectorXd r = -contacts.generalized(contacts.redundant().col(k));
    respond(r, l, x);
    for (Index i = 0; i < l.size(); ++i) {
      if (std::abs(l[i]) > no_effect) dlambda.row(i).setConstant(undetermined);
    }
    for (Index i = 0; i < x.size(); ++i) {
      if (std::abs(x[i]) > no_effect) holding[static_cast<std::size_t>(i)].derivatives().setConstant(undetermined);
    }
  }
}

void require_determined_prestress(HeldContacts& contacts, const std::function<MatrixXd()>& accelerations) {
  constexpr double no_change = 1e-9;  // relative to the accelerations that the forces alone would cause, per rad or m
  const MatrixXd redundant = contacts.redundant();
  if (redundant.cols() == 0) return;
  const MatrixXd present = accelerations();
  const VectorXd determined = contacts.multipliers();
  const double size = determined.cwiseAbs().maxCoeff();
  for (Index k = 0; k < redundant.cols(); ++k) {
    contacts.set_multipliers(determined + size / redundant.col(k).cwiseAbs().maxCoeff() * redundant.col(k));
    const MatrixXd changed = accelerations();
    contacts.set_multipliers(determined);
    if ((changed - present).cwiseAbs().maxCoeff() <= no_change * size * contacts.largest_response()) continue;
    throw NotDifferentiablePoint(LawEdge{contacts.contact_of(redundant.col(k)), LawEdge::Of::redundant_prestress});
  }
}

// By dual numbers, which the kinematics of contacts are written for.
MovedState ConstrainedSensitivity::state_derivative_in_contact(const MatrixXd& dq, const MatrixXd& dv,
                                                               const MatrixXd& du) {
  return joined(mechanism_, rates_.size(), du, [&](Index first, Index width) -> CarriedState<Dual>& {
    const auto some = [&](const MatrixXd& of) -> MatrixXd { return of.middleCols(first, width); };
    return directional_derivative(some(dq), some(dv), some(du));
  });
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "derivatives/forward_ad.h"

#include <algorithm>

#include "kinematics/loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

void copy(const double* from, std::vector<Dual>& to) { std::copy_n(from, to.size(), to.begin()); }

template <class Matrix>
void store_column(const std::vector<Dual>& from, int k, Matrix& to, Eigen::Index c) {
  for (std::size_t i = 0; i < from.size(); ++i) to(static_cast<Eigen::Index>(i), c) = from[i].derivatives()[k];
}

}  // namespace

Differentiator::Differentiator(const Mechanism& mechanism, const Loads& loads, int inputs)
    : residuals_(make_residual_evaluator<Dual>(mechanism, loads)),
      q_(mechanism.nq),
      v_(mechanism.nv),
      u_(inputs),
      vdot_(mechanism.nv),
      lambda_(mechanism.rows),
      targets_(3 * mechanism.coordinate_rows.size()),
      rates_(loads.rates.size()) {}

// Evaluates the residuals for the directions seeded in q, v, u.
void Differentiator::run(const LinearizationPoint& at) {
  residuals_->set_cut_reference(at.cut_reference);
  residuals_->set_targets(targets_.data());
  residuals_->set_position(q_.data());
  residuals_->set_velocity(v_.data());
  residuals_->set_acceleration(u_.data(), vdot_.data(), lambda_.data());
  residuals_->state_rates(u_.data(), rates_.data());
}

// Differentiates with respect to all of `in`, dual_directions numbers at a time. store(c, k) saves direction k of the
// residuals as column c.
template <class Store>
void Differentiator::sweep(const LinearizationPoint& at, std::vector<Dual>& in, Store store) {
  for (int first = 0; first < static_cast<int>(in.size()); first += dual_directions) {
    const int n = std::min(dual_directions, static_cast<int>(in.size()) - first);
    for (int k = 0; k < n; ++k) in[first + k].derivatives()[k] = 1;
    run(at);
    for (int k = 0; k < n; ++k) {
      store(first + k, k);
      in[first + k].derivatives()[k] = 0;
    }
  }
}

void Differentiator::operator()(const LinearizationPoint& at, Jacobians& out) {
  const auto nq = static_cast<int>(q_.size());
  out.clear(nq, static_cast<int>(v_.size()), static_cast<int>(lambda_.size()), static_cast<int>(u_.size()),
            static_cast<int>(rates_.size()));
  copy(at.q, q_);
  copy(at.v, v_);
  copy(at.u, u_);
  copy(at.vdot, vdot_);
  copy(at.lambda, lambda_);
  copy(at.targets, targets_);
  const ResidualEvaluator<Dual>& e = *residuals_;
  sweep(at, q_, [&](int c, int k) {
    store_column(e.force_residual(), k, out.r, c);
    store_column(e.acceleration_residual(), k, out.c, c);
    store_column(e.qdot(), k, out.qdot_q, c);
    store_column(rates_, k, out.rates, c);
    if (!out.of_rows) return;
    store_column(e.Phi(), k, out.Phi_q, c);
    store_column(e.row_rates(), k, out.rate_q, c);
  });
  sweep(at, v_, [&](int c, int k) {
    store_column(e.force_residual(), k, out.r, nq + c);
    store_column(e.acceleration_residual(), k, out.c, nq + c);
    store_column(e.qdot(), k, out.qdot_v, c);
    store_column(rates_, k, out.rates, nq + c);
  });
  if (!out.of_inputs && rates_.empty()) return;
  sweep(at, u_, [&](int c, int k) {
    store_column(e.force_residual(), k, out.r_u, c);
    store_column(rates_, k, out.rates_u, c);
  });
}

}  // namespace gelenk

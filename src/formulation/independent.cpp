// SPDX-License-Identifier: BSD-3-Clause
// `independent`: coordinate partitioning (Wehage & Haug 1982). LU of J with full pivoting tells r dependent speeds, and
// r rows that determine them from the others; in every evaluation the dependent coordinates and speeds are solved from
// the independent ones (Newton's method along the dependent speeds, from the state given), and f is that of the state
// found: it does not depend on the dependent part of y. After a step the same puts the dependent part of y right. The
// full state is kept, so another partition goes on from the same point.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "formulation/formulation.h"

namespace gelenk {
namespace {

// A new partition is looked for where the smallest pivot has shrunk to this part of what it was when chosen.
constexpr double worn = 0.3;

class Independent final : public Formulation {
 public:
  Independent(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u)
      : Formulation(mechanism, dynamics, u), state_(size()) {}

  void start(const std::vector<double>& cut_q, double t, const double* y) override {
    Formulation::start(cut_q, t, y);
    if (rows() > 0) choose();
  }

  void exchange(Record& record) override {
    Formulation::exchange(record);
    int rank = static_cast<int>(needed_.size());
    record.within(rank, 0, std::min(rows(), nv_));
    needed_.resize(rank);
    dependent_.resize(rank);
    for (int& row : needed_) record.within(row, 0, rows() - 1);
    for (int& speed : dependent_) record.within(speed, 0, nv_ - 1);
    record.exchange(smallest_, chosen_);
  }

  bool project(double, double* y) override { return close_position(y) && close_velocity(y + nq_); }

  void accepted(double t, const double* y) override {
    Formulation::accepted(t, y);  // leaves dynamics_ at y
    if (rows() > 0 && smallest_ < worn * chosen_) choose();
  }

 private:
  // At the position of dynamics_.
  void choose() {
    dynamics_.factorise();
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(J());
    // Where the rank is low for a moment, the former partition is as good as any.
    if (!needed_.empty() && dynamics_.rank() < static_cast<int>(needed_.size())) return;
    const int rank = dynamics_.rank();
    const auto& columns = lu.permutationQ().indices();
    dependent_.assign(columns.begin(), columns.begin() + rank);
    needed_.clear();
    for (int r = 0; r < rows(); ++r) {
      if (lu.permutationP().indices()[r] < rank) needed_.push_back(r);
    }
    factorise_dependent();
    chosen_ = smallest_;
    factors_ = true;
  }

  void factorise_dependent() {
    lu_.compute(J()(needed_, dependent_));
    smallest_ = lu_.matrixLU().diagonal().cwiseAbs().minCoeff();
  }

  void refactor() override {
    dynamics_.factorise();
    if (!needed_.empty()) factorise_dependent();
  }

  void correction(const double* residual, double* dv) override {
    Eigen::VectorXd error(needed_.size());
    for (std::size_t k = 0; k < needed_.size(); ++k) error[k] = residual[needed_[k]];
    const Eigen::VectorXd x = lu_.solve(error);
    std::fill_n(dv, nv_, 0.0);
    for (std::size_t k = 0; k < dependent_.size(); ++k) dv[dependent_[k]] = -x[k];
  }

  const double* state_for(const double* y) override {
    std::copy_n(y, size(), state_.begin());
    return close_position(state_.data()) ? state_.data() : nullptr;
  }

  bool accelerate(double, const double*, double* vdot) override {
    renew_factors();
    if (!close_velocity(state_.data() + nq_)) return false;
    dynamics_.solve(u_.data(), vdot);
    return true;
  }

  // With z = state_for(y): dq_z = N T N^+ dq and dv_z = T dv - E J_d^-1 (d(J v)/dq) dq_z, where T carries the dependent
  // speeds along with the independent ones and E places numbers at the dependent speeds. N^+ takes a quaternion's
  // length away, as normalising it does.
  void chain(Eigen::Map<Eigen::MatrixXd>& out) override {
    const Eigen::MatrixXd& N = slopes_.qdot_v;
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(nv_, nv_);
    for (const int k : dependent_) T(k, k) = 0;
    Eigen::MatrixXd dv_dq = Eigen::MatrixXd::Zero(nv_, nq_);
    const Eigen::MatrixXd to_speeds = (N.transpose() * N).ldlt().solve(N.transpose());
    if (!needed_.empty()) {
      const Eigen::MatrixXd carried = lu_.solve((J() * T)(needed_, Eigen::all).eval());
      T(dependent_, Eigen::all) = -carried;
    }
    const Eigen::MatrixXd dq = N * T * to_speeds;
    if (!needed_.empty()) {
      const Eigen::MatrixXd rates = (slopes_.rate_q * dq)(needed_, Eigen::all);
      dv_dq(dependent_, Eigen::all) = -lu_.solve(rates);
    }
    const Eigen::MatrixXd by_q = out.leftCols(nq_);
    const Eigen::MatrixXd by_v = out.rightCols(nv_);
    out.leftCols(nq_) = by_q * dq + by_v * dv_dq;
    out.rightCols(nv_) = by_v * T;
  }

  std::vector<double> state_;
  std::vector<int> needed_, dependent_;      // rows, and the speeds they determine
  Eigen::FullPivLU<Eigen::MatrixXd> lu_;     // of J there
  double smallest_ = INFINITY, chosen_ = 0;  // its smallest pivot; when chosen
};

}  // namespace

std::unique_ptr<Formulation> make_independent(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                              const FormulationOptions&) {
  return std::make_unique<Independent>(mechanism, dynamics, u);
}

}  // namespace gelenk

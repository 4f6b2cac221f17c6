// SPDX-License-Identifier: BSD-3-Clause
// `independent`: coordinate partitioning (Wehage & Haug 1982). LU of J with full pivoting tells r dependent speeds, and
// r rows that determine them from the others; in every evaluation the dependent coordinates and speeds are solved from
// the independent ones (Newton's method along the dependent speeds, from the state given), and f is that of the state
// found: it does not depend on the dependent part of y. After a step the same puts the dependent part of y right. The
// full state is kept, so another partition goes on from the same point.
#include <Eigen/Cholesky>
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
      : Formulation(mechanism, dynamics, u),
        state_(size()),
        all_(mechanism.rows, mechanism.nv),
        right_(std::min(mechanism.rows, mechanism.nv)),
        dv_dq_(mechanism.nv, mechanism.nq),
        carried_(mechanism.nv) {
    needed_.reserve(right_.size());
    dependent_.reserve(right_.size());
  }

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

  bool project(double t, double* y) override {
    go_to(t);
    return close_position(y) && close_velocity(y + nq_);
  }

  void accepted(double t, const double* y) override {
    Formulation::accepted(t, y);  // leaves dynamics_ at y
    if (rows() > 0 && smallest_ < worn * chosen_) choose();
  }

 private:
  // At the position of dynamics_.
  void choose() {
    dynamics_.factorise();
    all_.compute(J());
    // Where the rank is low for a moment, the former partition is as good as any.
    if (!needed_.empty() && dynamics_.rank() < static_cast<int>(needed_.size())) return;
    const int rank = dynamics_.rank();
    const auto& columns = all_.permutationQ().indices();
    dependent_.assign(columns.begin(), columns.begin() + rank);
    needed_.clear();
    for (int r = 0; r < rows(); ++r) {
      if (all_.permutationP().indices()[r] < rank) needed_.push_back(r);
    }
    factorise_dependent();
    chosen_ = smallest_;
    factors_ = true;
  }

  void factorise_dependent() {
    const auto rank = static_cast<Eigen::Index>(needed_.size());
    J_d_.resize(rank, rank);
    for (Eigen::Index k = 0; k < rank; ++k) {
      for (Eigen::Index r = 0; r < rank; ++r) J_d_(r, k) = J()(needed_[r], dependent_[k]);
    }
    lu_.compute(J_d_);
    smallest_ = lu_.matrixLU().diagonal().cwiseAbs().minCoeff();
  }

  void refactor() override {
    dynamics_.factorise();
    if (!needed_.empty()) factorise_dependent();
  }

  void correction(const double* residual, double* dv) override {
    // lu_.solve() would ask for memory.
    const auto rank = static_cast<Eigen::Index>(needed_.size());
    auto x = right_.head(rank);
    for (Eigen::Index k = 0; k < rank; ++k) x[lu_.permutationP().indices()[k]] = residual[needed_[k]];
    lu_.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(x);
    lu_.matrixLU().triangularView<Eigen::Upper>().solveInPlace(x);
    std::fill_n(dv, nv_, 0.0);
    for (Eigen::Index k = 0; k < rank; ++k) dv[dependent_[lu_.permutationQ().indices()[k]]] = -x[k];
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
    T_.setIdentity(nv_, nv_);
    for (const int k : dependent_) T_(k, k) = 0;
    JT_.noalias() = J() * T_;
    for (int k = 0; k < nv_; ++k) {
      correction(JT_.col(k).data(), carried_.data());
      for (const int dependent : dependent_) T_(dependent, k) = carried_[dependent];
    }
    square_.noalias() = N.transpose() * N;
    square_factor_.compute(square_);
    to_speeds_ = N.transpose();
    square_factor_.solveInPlace(to_speeds_);
    T_to_speeds_.noalias() = T_ * to_speeds_;
    dq_.noalias() = N * T_to_speeds_;
    rates_.noalias() = slopes_.rate_q * dq_;
    for (int k = 0; k < nq_; ++k) correction(rates_.col(k).data(), dv_dq_.col(k).data());
    f_ = out;
    out.leftCols(nq_).noalias() = f_.leftCols(nq_) * dq_;
    out.leftCols(nq_).noalias() += f_.rightCols(nv_) * dv_dq_;
    out.rightCols(nv_).noalias() = f_.rightCols(nv_) * T_;
  }

  std::vector<double> state_;
  std::vector<int> needed_, dependent_;    // rows, and the speeds they determine
  Eigen::MatrixXd J_d_;                    // J there
  Eigen::FullPivLU<Eigen::MatrixXd> lu_;   // of it
  Eigen::FullPivLU<Eigen::MatrixXd> all_;  // of J, when they were chosen
  Eigen::VectorXd right_;
  double smallest_ = INFINITY, chosen_ = 0;  // its smallest pivot; when chosen
  // Of chain().
  Eigen::MatrixXd T_, JT_, square_, to_speeds_, T_to_speeds_, dq_, rates_, dv_dq_, f_;
  Eigen::VectorXd carried_;
  Eigen::LLT<Eigen::MatrixXd> square_factor_;
};

}  // namespace

std::unique_ptr<Formulation> make_independent(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                              const FormulationOptions&) {
  return std::make_unique<Independent>(mechanism, dynamics, u);
}

}  // namespace gelenk

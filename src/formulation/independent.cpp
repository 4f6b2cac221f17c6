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

// Corrects the dependent coordinates and speeds alone.
class Partition final : public Corrector {
 public:
  Partition(const Mechanism& mechanism, Dynamics& dynamics)
      : Corrector(mechanism, dynamics),
        all_(mechanism.rows, mechanism.nv),
        right_(std::min(mechanism.rows, mechanism.nv)) {
    needed_.reserve(right_.size());
    dependent_.reserve(right_.size());
  }

  const std::vector<int>& dependent() const { return dependent_; }
  bool is_worn() const { return smallest_ < worn * chosen_; }

  // At the position of `dynamics`.
  void choose() {
    dynamics_.factorize();
    all_.compute(dynamics_.J());
    // Where the rank is low for a moment, the former partition is as good as any.
    if (!needed_.empty() && dynamics_.rank() < static_cast<int>(needed_.size())) return;
    const int rank = dynamics_.rank();
    const auto& columns = all_.permutationQ().indices();
    dependent_.assign(columns.begin(), columns.begin() + rank);
    needed_.clear();
    for (int r = 0; r < mechanism_.rows; ++r) {
      if (all_.permutationP().indices()[r] < rank) needed_.push_back(r);
    }
    refactorize();
    chosen_ = smallest_;
  }

  void min_norm_displacement(const double* residual, double* dv) override {
    std::fill_n(dv, mechanism_.nv, 0.0);
    const auto rank = static_cast<Eigen::Index>(needed_.size());
    if (rank == 0) return;  // nothing has been factorized
    // lu_.solve() would allocate memory.
    auto x = right_.head(rank);
    for (Eigen::Index k = 0; k < rank; ++k) x[lu_.permutationP().indices()[k]] = residual[needed_[k]];
    lu_.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(x);
    lu_.matrixLU().triangularView<Eigen::Upper>().solveInPlace(x);
    for (Eigen::Index k = 0; k < rank; ++k) dv[dependent_[lu_.permutationQ().indices()[k]]] = -x[k];
  }

  void serialize(Archive& archive) {
    int rank = static_cast<int>(needed_.size());
    archive.serialize_in_range(rank, 0, std::min(mechanism_.rows, mechanism_.nv));
    needed_.resize(rank);
    dependent_.resize(rank);
    for (int& row : needed_) archive.serialize_in_range(row, 0, mechanism_.rows - 1);
    for (int& speed : dependent_) archive.serialize_in_range(speed, 0, mechanism_.nv - 1);
    archive.serialize(smallest_, chosen_);
  }

 private:
  void refactor() override {
    dynamics_.factorize();
    if (!needed_.empty()) factorise_dependent();
  }

  void factorise_dependent() {
    const auto rank = static_cast<Eigen::Index>(needed_.size());
    J_d_.resize(rank, rank);
    const auto J = dynamics_.J();
    for (Eigen::Index k = 0; k < rank; ++k) {
      for (Eigen::Index r = 0; r < rank; ++r) J_d_(r, k) = J(needed_[r], dependent_[k]);
    }
    lu_.compute(J_d_);
    smallest_ = lu_.matrixLU().diagonal().cwiseAbs().minCoeff();
  }

  std::vector<int> needed_, dependent_;    // rows, and the speeds they determine
  Eigen::MatrixXd J_d_;                    // J there
  Eigen::FullPivLU<Eigen::MatrixXd> lu_;   // of it
  Eigen::FullPivLU<Eigen::MatrixXd> all_;  // of J, when they were chosen
  Eigen::VectorXd right_;
  double smallest_ = INFINITY, chosen_ = 0;  // its smallest pivot; when chosen
};

class Independent final : public Formulation {
 public:
  explicit Independent(const FormulationContext& context)
      : Formulation(context),
        partition_(mechanism_, dynamics_),
        state_(size()),
        dv_dq_(mechanism_.nv, mechanism_.nq),
        carried_(mechanism_.nv) {}

  void start(const std::vector<double>& cut_q, double t, const double* y) override {
    Formulation::start(cut_q, t, y);
    if (mechanism_.rows > 0) partition_.choose();
  }

  void serialize(Archive& archive) override {
    Formulation::serialize(archive);
    partition_.serialize(archive);
  }

  bool rhs(double t, const double* y, double* ydot) override {
    if (!Eigen::Map<const Eigen::VectorXd>(y, size()).allFinite()) return false;
    drives_.go_to(t);
    std::copy_n(y, size(), state_.begin());
    return partition_.close_position(state_.data()) && evaluate(t, state_.data(), ydot);
  }

  bool jacobian(double t, const double* y, double* J) override {
    if (!Formulation::jacobian(t, y, J)) return false;
    Eigen::Map<Eigen::MatrixXd> out(J, size(), size());
    chain(out);
    return out.allFinite();
  }

  bool project(double t, double* y) override {
    drives_.go_to(t);
    return partition_.close_position(y) && partition_.close_velocity(y + mechanism_.nq);
  }

  void accepted(double t, const double* y) override {
    Formulation::accepted(t, y);  // leaves dynamics_ at y
    if (mechanism_.rows > 0 && partition_.is_worn()) partition_.choose();
  }

 private:
  Corrector& corrector() override { return partition_; }

  bool accelerate(double, const double*, double* vdot) override {
    partition_.refactorize();
    if (!partition_.close_velocity(state_.data() + mechanism_.nq)) return false;
    dynamics_.solve(drives_.u().data(), vdot);
    return true;
  }

  // From the slopes of f at z = state_ to those at y: dq_z = N T N^+ dq and dv_z = T dv - E J_d^-1 (d(J v)/dq) dq_z,
  // where T carries the dependent speeds along with the independent ones and E places numbers at the dependent speeds.
  // N^+ takes a quaternion's length away, as normalising it does.
  void chain(Eigen::Map<Eigen::MatrixXd>& out) {
    const int nq = mechanism_.nq;
    const int nv = mechanism_.nv;
    const Eigen::MatrixXd& N = jacobians_.qdot_v;
    T_.setIdentity(nv, nv);
    for (const int k : partition_.dependent()) T_(k, k) = 0;
    JT_.noalias() = dynamics_.J() * T_;
    for (int k = 0; k < nv; ++k) {
      partition_.min_norm_displacement(JT_.col(k).data(), carried_.data());
      for (const int dependent : partition_.dependent()) T_(dependent, k) = carried_[dependent];
    }
    square_.noalias() = N.transpose() * N;
    square_factor_.compute(square_);
    to_speeds_ = N.transpose();
    square_factor_.solveInPlace(to_speeds_);
    T_to_speeds_.noalias() = T_ * to_speeds_;
    dq_.noalias() = N * T_to_speeds_;
    rates_.noalias() = jacobians_.rate_q * dq_;
    for (int k = 0; k < nq; ++k) partition_.min_norm_displacement(rates_.col(k).data(), dv_dq_.col(k).data());
    f_ = out;
    out.leftCols(nq).noalias() = f_.leftCols(nq) * dq_;
    out.leftCols(nq).noalias() += f_.rightCols(nv) * dv_dq_;
    out.rightCols(nv).noalias() = f_.rightCols(nv) * T_;
  }

  Partition partition_;
  std::vector<double> state_;  // at which rhs(y) evaluates
  // Of chain().
  Eigen::MatrixXd T_, JT_, square_, to_speeds_, T_to_speeds_, dq_, rates_, dv_dq_, f_;
  Eigen::VectorXd carried_;
  Eigen::LLT<Eigen::MatrixXd> square_factor_;
};

}  // namespace

std::unique_ptr<Formulation> make_independent(const FormulationContext& context) {
  return std::make_unique<Independent>(context);
}

}  // namespace gelenk

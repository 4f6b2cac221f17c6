// SPDX-License-Identifier: BSD-3-Clause
// `independent`: coordinate partitioning (Wehage & Haug 1982). LU factorization of J with full pivoting selects r
// dependent velocities and r constraint equations that determine them from the others. In every evaluation the
// dependent coordinates and velocities are solved for (Newton's method along the dependent velocities, from the given
// state), and f is evaluated at the resulting state, so it does not depend on the dependent part of y. After a step the
// same corrects the dependent part of y. The full state is kept, so another partition can continue from the same point.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "formulation/formulation.h"

namespace gelenk {
namespace {

// Ratio of the smallest pivot to its value when the partition was chosen, below which a new one is chosen.
constexpr double repartition_ratio = 0.3;

// Projects by changing the dependent coordinates and velocities only.
class Partition final : public ConstraintProjector {
 public:
  Partition(const Mechanism& mechanism, Dynamics& dynamics)
      : ConstraintProjector(mechanism, dynamics),
        full_lu_(mechanism.rows, mechanism.nv),
        rhs_(std::min(mechanism.rows, mechanism.nv)) {
    rows_.reserve(rhs_.size());
    dependent_.reserve(rhs_.size());
  }

  const std::vector<int>& dependent() const { return dependent_; }
  bool needs_repartitioning() const { return smallest_pivot_ < repartition_ratio * pivot_when_chosen_; }

  // Chooses a partition at the position of `dynamics`.
  void choose() {
    dynamics_.factorize();
    full_lu_.compute(dynamics_.J());
    // Where the rank is momentarily lower, the former partition is kept.
    if (!rows_.empty() && dynamics_.rank() < static_cast<int>(rows_.size())) return;
    const int rank = dynamics_.rank();
    const auto& columns = full_lu_.permutationQ().indices();
    dependent_.assign(columns.begin(), columns.begin() + rank);
    rows_.clear();
    for (int r = 0; r < mechanism_.rows; ++r) {
      if (full_lu_.permutationP().indices()[r] < rank) rows_.push_back(r);
    }
    refactorize();
    pivot_when_chosen_ = smallest_pivot_;
  }

  void min_norm_displacement(const double* residual, double* dv) override {
    std::fill_n(dv, mechanism_.nv, 0.0);
    const auto rank = static_cast<Eigen::Index>(rows_.size());
    if (rank == 0) return;  // there are no factors
    // lu_.solve() would allocate memory.
    auto x = rhs_.head(rank);
    for (Eigen::Index k = 0; k < rank; ++k) x[lu_.permutationP().indices()[k]] = residual[rows_[k]];
    lu_.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(x);
    lu_.matrixLU().triangularView<Eigen::Upper>().solveInPlace(x);
    for (Eigen::Index k = 0; k < rank; ++k) dv[dependent_[lu_.permutationQ().indices()[k]]] = -x[k];
  }

  void serialize(Archive& archive) {
    int rank = static_cast<int>(rows_.size());
    archive.serialize_in_range(rank, 0, std::min(mechanism_.rows, mechanism_.nv));
    rows_.resize(rank);
    dependent_.resize(rank);
    for (int& row : rows_) archive.serialize_in_range(row, 0, mechanism_.rows - 1);
    for (int& speed : dependent_) archive.serialize_in_range(speed, 0, mechanism_.nv - 1);
    archive.serialize(smallest_pivot_, pivot_when_chosen_);
  }

 private:
  void refactor() override {
    dynamics_.factorize();
    if (!rows_.empty()) factorize_dependent();
  }

  void factorize_dependent() {
    const auto rank = static_cast<Eigen::Index>(rows_.size());
    J_d_.resize(rank, rank);
    const auto J = dynamics_.J();
    for (Eigen::Index k = 0; k < rank; ++k) {
      for (Eigen::Index r = 0; r < rank; ++r) J_d_(r, k) = J(rows_[r], dependent_[k]);
    }
    lu_.compute(J_d_);
    smallest_pivot_ = lu_.matrixLU().diagonal().cwiseAbs().minCoeff();
  }

  std::vector<int> rows_, dependent_;          // constraint equations, and the velocities that they determine
  Eigen::MatrixXd J_d_;                        // the square submatrix of J with these rows and columns
  Eigen::FullPivLU<Eigen::MatrixXd> lu_;       // of J_d_
  Eigen::FullPivLU<Eigen::MatrixXd> full_lu_;  // of J when the partition was chosen
  Eigen::VectorXd rhs_;
  double smallest_pivot_ = INFINITY, pivot_when_chosen_ = 0;  // smallest pivot of J_d_, now and when chosen
};

class Independent final : public Formulation {
 public:
  explicit Independent(const FormulationContext& context)
      : Formulation(context),
        partition_(mechanism_, dynamics_),
        state_(size()),
        dv_dq_(mechanism_.nv, mechanism_.nq),
        column_(mechanism_.nv) {}

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
    drives_.go_to(t, y);
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
    drives_.go_to(t, y);
    return partition_.close_position(y) && partition_.close_velocity(y + mechanism_.nq);
  }

  void accepted(double t, const double* y) override {
    Formulation::accepted(t, y);  // leaves dynamics_ at y
    if (mechanism_.rows == 0) return;
    if (partition_.needs_repartitioning()) partition_.choose();
    // A step from a restored state has none either; with those of the last evaluation it would end on other digits.
    partition_.discard_factors();
  }

 private:
  ConstraintProjector& projector() override { return partition_; }

  bool accelerate(double, const double*, double* vdot) override {
    partition_.refactorize();
    if (!partition_.close_velocity(state_.data() + mechanism_.nq)) return false;
    dynamics_.solve(drives_.u().data(), vdot);
    return true;
  }

  // From the derivatives of f at z = state_ to those at y: dq_z = N T N^+ dq and dv_z = T dv - E J_d^-1 (d(J v)/dq)
  // dq_z, where T expresses all velocities by the independent ones and E inserts the dependent velocities. N^+ removes
  // changes of the norm of a quaternion, as normalization does.
  void chain(Eigen::Map<Eigen::MatrixXd>& out) {
    const int nq = mechanism_.nq;
    const int nv = mechanism_.nv;
    const Eigen::MatrixXd& N = jacobians_.qdot_v;
    T_.setIdentity(nv, nv);
    for (const int k : partition_.dependent()) T_(k, k) = 0;
    JT_.noalias() = dynamics_.J() * T_;
    for (int k = 0; k < nv; ++k) {
      partition_.min_norm_displacement(JT_.col(k).data(), column_.data());
      for (const int dependent : partition_.dependent()) T_(dependent, k) = column_[dependent];
    }
    NtN_.noalias() = N.transpose() * N;
    NtN_factor_.compute(NtN_);
    N_pinv_ = N.transpose();
    NtN_factor_.solveInPlace(N_pinv_);
    T_N_pinv_.noalias() = T_ * N_pinv_;
    dq_.noalias() = N * T_N_pinv_;
    rates_.noalias() = jacobians_.rate_q * dq_;
    for (int k = 0; k < nq; ++k) partition_.min_norm_displacement(rates_.col(k).data(), dv_dq_.col(k).data());
    f_ = out;
    out.leftCols(nq).noalias() = f_.leftCols(nq) * dq_;
    out.leftCols(nq).noalias() += f_.middleCols(nq, nv) * dv_dq_;
    out.middleCols(nq, nv).noalias() = f_.middleCols(nq, nv) * T_;
  }

  Partition partition_;
  std::vector<double> state_;  // state at which rhs(y) evaluates f
  // Workspace of chain().
  Eigen::MatrixXd T_, JT_, NtN_, N_pinv_, T_N_pinv_, dq_, rates_, dv_dq_, f_;
  Eigen::VectorXd column_;
  Eigen::LLT<Eigen::MatrixXd> NtN_factor_;
};

}  // namespace

std::unique_ptr<Formulation> make_independent(const FormulationContext& context) {
  return std::make_unique<Independent>(context);
}

}  // namespace gelenk

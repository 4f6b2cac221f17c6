// SPDX-License-Identifier: BSD-3-Clause
#include "batch/elimination.h"

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace gelenk {
namespace {

using recording::Recorded;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double dependent = 1e-7;  // what is left of an equation of size 1 that follows from others
// How far positions at which pivots are compared are from the start [rad or m]: that may be a singular one, or near it,
// with pivots that are small or vanish.
constexpr double neighborhoods[] = {0, 0.05, 0.05, 0.05, 0.2, 0.2, 0.2, 0.8, 0.8, 0.8};
// Pivots of another position are chosen if the smallest is so many times that of the first ones.
constexpr double much_larger = 10;

Recorded at(const SceneEquations& of, const std::vector<expression::Term>& matrix, int row, int column) {
  const std::size_t n = of.v.size();
  return Recorded::of(matrix[static_cast<std::size_t>(row) * n + static_cast<std::size_t>(column)]);
}

RowMajor matrix(const std::vector<double>& of, std::size_t columns) {
  return Eigen::Map<const RowMajor>(of.data(), static_cast<Eigen::Index>(of.size() / columns),
                                    static_cast<Eigen::Index>(columns));
}

// By elimination with complete pivoting. J: of velocities and equations of size 1.
Pivots largest(RowMajor J) {
  Pivots out;
  std::vector<bool> is_used(static_cast<std::size_t>(J.rows()), false);
  for (Eigen::Index n = 0; n < std::min(J.rows(), J.cols()); ++n) {
    Eigen::Index row = 0;
    Eigen::Index column = 0;
    if (!(J.cwiseAbs().maxCoeff(&row, &column) > dependent)) break;
    out.rows.push_back(static_cast<int>(row));
    out.columns.push_back(static_cast<int>(column));
    const Eigen::RowVectorXd pivot = J.row(row) / J(row, column);
    for (Eigen::Index r = 0; r < J.rows(); ++r) J.row(r) -= J(r, column) * pivot;
    J.row(row).setZero();
    J.col(column).setZero();
  }
  return out;
}

// Newton's method onto Phi = 0; false: it does not converge.
bool close(const TracedScene& scene, const std::vector<double>& v, const std::vector<double>& u,
           std::vector<double>& q) {
  constexpr int most_iterations = 20;
  constexpr double closed = 1e-12;  // m or rad
  for (int i = 0; i < most_iterations; ++i) {
    const EquationValues values = scene.values(q, v, u);
    const Eigen::Map<const Eigen::VectorXd> Phi(values.Phi.data(), static_cast<Eigen::Index>(values.Phi.size()));
    if (Phi.lpNorm<Eigen::Infinity>() < closed) return true;
    const Eigen::VectorXd dv = -matrix(values.J, v.size()).completeOrthogonalDecomposition().solve(Phi);
    if (!(dv.lpNorm<Eigen::Infinity>() < 10)) return false;
    const EquationValues moved = scene.values(q, {dv.begin(), dv.end()}, u);
    for (std::size_t k = 0; k < q.size(); ++k) q[k] += moved.qdot[k];
  }
  return false;
}

}  // namespace

namespace {

// A position, and the Jacobian there, of velocities and equations of size 1.
struct Sample {
  std::vector<double> q;
  RowMajor J;
};

RowMajor scaled(const EquationValues& values, std::size_t nv) {
  const RowMajor M = matrix(values.M, nv);
  RowMajor J = matrix(values.J, nv);
  for (Eigen::Index c = 0; c < J.cols(); ++c) J.col(c) /= M(c, c) > 0 ? std::sqrt(M(c, c)) : 1;
  const double largest_row = J.cwiseAbs().maxCoeff();
  for (Eigen::Index r = 0; r < J.rows(); ++r) {
    const double size = J.row(r).cwiseAbs().maxCoeff();
    J.row(r) /= size > dependent * largest_row ? size : largest_row;
  }
  return J;
}

// The start, if it closes, and positions around it.
std::vector<Sample> samples(const TracedScene& scene, const std::vector<double>& start, const std::vector<double>& u) {
  const std::vector<double> rest(scene.equations().v.size(), 0);
  std::mt19937 random(1);  // its numbers are the same everywhere, those of distributions are not
  std::vector<Sample> out;
  for (const double around : neighborhoods) {
    std::vector<double> q = start;
    for (double& x : q)
      x += around * (2 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1);
    if (close(scene, rest, u, q)) out.push_back({q, scaled(scene.values(q, rest, u), rest.size())});
  }
  return out;
}

// The smallest pivot of these, in this order; 0 if one vanishes.
double smallest_pivot(RowMajor J, const Pivots& pivots) {
  double out = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < pivots.rows.size(); ++n) {
    const double pivot = J(pivots.rows[n], pivots.columns[n]);
    out = std::min(out, std::abs(pivot));
    if (!(out > 0)) return 0;
    const Eigen::RowVectorXd row = J.row(pivots.rows[n]) / pivot;
    for (std::size_t k = n + 1; k < pivots.rows.size(); ++k)
      J.row(pivots.rows[k]) -= J(pivots.rows[k], pivots.columns[n]) * row;
  }
  return out;
}

}  // namespace

Pivots choose_pivots(const TracedScene& scene) {
  const SceneEquations& equations = scene.equations();
  Pivots out;
  for (const EquationArgument& of : equations.q) out.q.push_back(of.start);
  for (const EquationArgument& of : equations.u) out.u.push_back(of.start);
  if (equations.rows.empty()) return out;
  const std::vector<Sample> found = samples(scene, out.q, out.u);
  double smallest = 0;
  for (const Sample& at : found) {
    Pivots here = largest(at.J);
    const double size = smallest_pivot(at.J, here);
    const bool has_more = here.rows.size() > out.rows.size();
    if (!has_more && (here.rows.size() < out.rows.size() || size < much_larger * smallest)) continue;
    smallest = size;
    out.rows = std::move(here.rows);
    out.columns = std::move(here.columns);
  }
  // Their usual size is that where the smallest is largest.
  double best = 0;
  for (const Sample& at : found) {
    const double size = smallest_pivot(at.J, out);
    if (size <= best) continue;
    best = size;
    out.q = at.q;
  }
  return out;
}

Elimination::Elimination(const SceneEquations& equations, const Pivots& pivots)
    : pivots_(pivots), nv_(static_cast<int>(equations.v.size())) {
  std::vector<bool> is_dependent(static_cast<std::size_t>(nv_), false);
  for (const int column : pivots_.columns) is_dependent[static_cast<std::size_t>(column)] = true;
  for (int k = 0; k < nv_; ++k) {
    if (!is_dependent[static_cast<std::size_t>(k)]) free_.push_back(k);
  }
  factorize_constraints(equations);
  factorize_mass(equations);
}

void Elimination::factorize_constraints(const SceneEquations& equations) {
  const std::size_t n = pivots_.rows.size();
  for (std::size_t i = 0; i < n; ++i) {
    Numbers& row = LU_.emplace_back();
    for (const int column : pivots_.columns) row.push_back(at(equations, equations.J, pivots_.rows[i], column));
  }
  for (std::size_t k = 0; k < n; ++k) {
    reciprocal_.push_back(Recorded(1) / LU_[k][k]);
    for (std::size_t i = k + 1; i < n; ++i) {
      LU_[i][k] *= reciprocal_[k];
      for (std::size_t j = k + 1; j < n; ++j) LU_[i][j] -= LU_[i][k] * LU_[k][j];
    }
  }
  T_.assign(n, Numbers(free_.size()));
  for (std::size_t f = 0; f < free_.size(); ++f) {
    Numbers right_side;
    for (const int row : pivots_.rows) right_side.push_back(-at(equations, equations.J, row, free_[f]));
    const Numbers column = dependent(right_side);
    for (std::size_t i = 0; i < n; ++i) T_[i][f] = column[i];
  }
}

// From the last velocity to the first: those of branches of a tree then remain apart.
void Elimination::factorize_mass(const SceneEquations& equations) {
  const std::size_t n = pivots_.columns.size();
  const std::size_t f = free_.size();
  const auto M = [&](int row, int column) { return at(equations, equations.M, row, column); };
  TM_d_.assign(f, Numbers(n));
  L_.assign(f, Numbers(f));
  for (std::size_t i = 0; i < f; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      TM_d_[i][j] = M(free_[i], pivots_.columns[j]);
      for (std::size_t k = 0; k < n; ++k) TM_d_[i][j] += T_[k][i] * M(pivots_.columns[k], pivots_.columns[j]);
    }
  }
  for (std::size_t i = 0; i < f; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      Recorded& entry = L_[i][j];
      entry = M(free_[i], free_[j]);
      for (std::size_t k = 0; k < n; ++k) entry += T_[k][i] * M(pivots_.columns[k], free_[j]) + TM_d_[i][k] * T_[k][j];
    }
  }
  reciprocal_mass_.resize(f);
  for (std::size_t k = f; k-- > 0;) {
    reciprocal_mass_[k] = Recorded(1) / L_[k][k];
    for (std::size_t i = k; i-- > 0;) {
      const Recorded factor = L_[k][i] * reciprocal_mass_[k];
      for (std::size_t j = 0; j <= i; ++j) L_[i][j] -= factor * L_[k][j];
      L_[k][i] = factor;
    }
  }
}

Elimination::Numbers Elimination::dependent(Numbers right_side) const {
  Numbers& x = right_side;
  const std::size_t n = x.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= LU_[i][k] * x[k];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= LU_[i][k] * x[k];
    x[i] *= reciprocal_[i];
  }
  return right_side;
}

Elimination::Numbers Elimination::independent(Numbers right_side) const {
  Numbers& x = right_side;
  const std::size_t n = x.size();
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t i = 0; i < k; ++i) x[i] -= L_[k][i] * x[k];
  }
  for (std::size_t k = 0; k < n; ++k) {
    x[k] *= reciprocal_mass_[k];
    for (std::size_t i = 0; i < k; ++i) x[k] -= L_[k][i] * x[i];
  }
  return right_side;
}

Elimination::Numbers Elimination::whole(const Numbers& particular, const Numbers& free) const {
  Numbers out(static_cast<std::size_t>(nv_));
  for (std::size_t i = 0; i < free.size(); ++i) out[static_cast<std::size_t>(free_[i])] = free[i];
  for (std::size_t i = 0; i < particular.size(); ++i) {
    Recorded& x = out[static_cast<std::size_t>(pivots_.columns[i])];
    x = particular[i];
    for (std::size_t k = 0; k < free.size(); ++k) x += T_[i][k] * free[k];
  }
  return out;
}

// 0 = T^T (M vdot + h), vdot = (x_d; 0) + T a with J_d x_d = gamma.
Elimination::Numbers Elimination::accelerations(const Numbers& gamma, const Numbers& h) const {
  const Numbers particular = dependent(gamma);
  Numbers forces;
  for (std::size_t i = 0; i < free_.size(); ++i) {
    Recorded force = -h[static_cast<std::size_t>(free_[i])];
    for (std::size_t k = 0; k < particular.size(); ++k) {
      force -= T_[k][i] * h[static_cast<std::size_t>(pivots_.columns[k])];
      force -= TM_d_[i][k] * particular[k];
    }
    forces.push_back(force);
  }
  return whole(particular, independent(forces));
}

Elimination::Numbers Elimination::displacement(const Numbers& residual) const {
  Numbers negative;
  for (const Recorded& x : residual) negative.push_back(-x);
  const Numbers particular = dependent(negative);
  Numbers right_side;
  for (std::size_t i = 0; i < free_.size(); ++i) {
    Recorded sum(0);
    for (std::size_t k = 0; k < particular.size(); ++k) sum -= TM_d_[i][k] * particular[k];
    right_side.push_back(sum);
  }
  return whole(particular, independent(right_side));
}

}  // namespace gelenk

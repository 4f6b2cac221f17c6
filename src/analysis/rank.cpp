// SPDX-License-Identifier: BSD-3-Clause
// How many rows are independent, and which speeds may stand for the rest.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/assembly.h"

namespace gelenk {
namespace {

// Pivots below this fraction of the largest count as repeated rows: at positions moved off a symmetric one by some
// tenths of a radian, rows that are independent have pivots far above, repeated ones at the closure's rounding.
constexpr double same_row = 1e-8;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

bool close(const Mechanism& mechanism, Dynamics& dynamics, std::vector<double>& q) {
  std::vector<double> dv(mechanism.nv);
  for (int i = 0; i < 40; ++i) {
    dynamics.set_position(q.data());
    const auto& Phi = dynamics.Phi();
    const double gap = Eigen::Map<const Eigen::VectorXd>(Phi.data(), mechanism.rows).lpNorm<Eigen::Infinity>();
    if (!std::isfinite(gap)) return false;
    dynamics.factorise();
    if (gap < 1e-12) return true;
    dynamics.correct(Phi.data(), dv.data());
    dynamics.displace(q.data(), dv.data());
  }
  return false;
}

int rank_here(const Mechanism& mechanism, Dynamics& dynamics) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(
      Eigen::Map<const RowMajor>(dynamics.jacobian().data(), mechanism.rows, mechanism.nv).transpose());
  qr.setThreshold(same_row);
  return static_cast<int>(qr.rank());
}

}  // namespace

int structural_rank(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q) {
  dynamics.limit_rank(mechanism.rows);
  if (mechanism.rows == 0) return 0;
  dynamics.set_position(q.data());
  dynamics.factorise();
  int rank = rank_here(mechanism, dynamics);
  // Steps along random free motions away from q, closed again; the rank there is that of no special position.
  std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene gives the same rank
  std::normal_distribution<double> normal;
  for (int sample = 0; sample < 5; ++sample) {
    dynamics.limit_rank(rank);
    std::vector<double> moved = q;
    dynamics.set_position(q.data());
    dynamics.factorise();
    const Eigen::Map<const RowMajor> J(dynamics.jacobian().data(), mechanism.rows, mechanism.nv);
    Eigen::VectorXd dv(mechanism.nv);
    for (auto& x : dv) x = normal(random);
    std::vector<double> back(mechanism.nv);
    const Eigen::VectorXd residual = J * dv;
    dynamics.correct(residual.data(), back.data());
    dv += Eigen::Map<const Eigen::VectorXd>(back.data(), mechanism.nv);
    const double size = dv.lpNorm<Eigen::Infinity>();
    if (size < 1e-9) continue;  // nothing can move
    dv *= 0.15 / size;
    dynamics.displace(moved.data(), dv.data());
    if (close(mechanism, dynamics, moved)) rank = std::max(rank, rank_here(mechanism, dynamics));
  }
  dynamics.limit_rank(rank);
  return rank;
}

std::vector<int> independent_speeds(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& q,
                                    int rank, const std::vector<bool>& prefer) {
  dynamics.set_position(q.data());
  dynamics.factorise();
  Eigen::MatrixXd J = Eigen::Map<const RowMajor>(dynamics.jacobian().data(), mechanism.rows, mechanism.nv);
  std::vector<bool> dependent(mechanism.nv, false);
  std::vector<bool> used(mechanism.rows, false);
  const double largest = J.size() > 0 ? J.lpNorm<Eigen::Infinity>() : 0;
  // Gaussian elimination with full pivoting makes speeds dependent, those nobody asked for first.
  for (int step = 0, pass = 0; step < rank && pass < 2;) {
    int row = -1;
    int column = -1;
    double pivot = (pass == 0 ? 1e-3 : same_row) * largest;
    for (int r = 0; r < mechanism.rows; ++r) {
      for (int k = 0; k < mechanism.nv; ++k) {
        if (used[r] || dependent[k] || (pass == 0 && prefer[k])) continue;
        if (std::abs(J(r, k)) <= pivot) continue;
        pivot = std::abs(J(r, k));
        row = r;
        column = k;
      }
    }
    if (row < 0) {
      ++pass;
      continue;
    }
    for (int r = 0; r < mechanism.rows; ++r) {
      if (r != row) J.row(r) -= J(r, column) / J(row, column) * J.row(row);
    }
    used[row] = dependent[column] = true;
    ++step;
  }
  std::vector<int> out;
  for (int k = 0; k < mechanism.nv; ++k) {
    if (!dependent[k]) out.push_back(k);
  }
  return out;
}

}  // namespace gelenk

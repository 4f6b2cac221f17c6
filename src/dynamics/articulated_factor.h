// SPDX-License-Identifier: BSD-3-Clause
// The factorization M = L^T L of SparseFactor, with the same signs, but in operator form: L is applied by recursions
// along the tree (Featherstone 2008, sec. 7.3; Rodriguez, Jain & Kreutz-Delgado 1992, eq. 3.23), each linear in the
// number of links. For long branches, where M is large and full.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "kinematics/kernels.h"

namespace gelenk {

template <class A>
class ArticulatedFactor {
 public:
  // model and ws must outlive it. All functions read the poses and motion spaces in ws.
  ArticulatedFactor(const Model<A>& model, const Workspace<A>& ws)
      : model_(model),
        ws_(ws),
        G_(model.links.size()),
        p_(model.links.size()),
        a_(model.links.size()),
        U_(model.nv),
        root_(model.nv),
        inverse_(model.nv),
        column_(model.nv),
        link_of_(model.nv) {
    for (std::size_t i = 1; i < model.links.size(); ++i) {
      for (int k = 0; k < model.links[i].nv; ++k) link_of_[model.links[i].iv + k] = static_cast<int>(i);
    }
  }

  // added: inertia added to the diagonal of M, by velocity. held: by velocity, whether it is kept at 0, without a row
  // and column of M; empty: none is. Returns -1, or the velocity at which M has no inertia.
  int factorize(const std::vector<double>& added, std::span<const char> held = {});

  double pivot(int k) const { return 1 / inverse_[k]; }  // L_kk^2: the articulated inertia at k

  void solve_transposed(double* x) const;  // x <- L^-T x
  // The same for a sparse x. nonzeros: its indices, ascending and with all velocities inwards of each.
  void solve_transposed(double* x, std::span<const int> nonzeros) const;
  void solve(double* x) const;  // x <- L^-1 x
  // The same for each column of x (nv x columns), stored row by row.
  void solve_transposed(double* x, int columns) const;
  void solve(double* x, int columns) const;
  void multiply(const double* x, double* y) const;  // y = L x

  // f <- the accelerations that generalized forces f cause, with the velocities held for which M was factorized; for
  // these, the force that holds them (Featherstone 2008, sec. 9.1: hybrid dynamics).
  void solve_held(std::span<const char> held, double* f) const;

 private:
  template <class Solve>
  void by_columns(double* x, int columns, Solve solve) const;
  void carry_inwards(int i, int k, double* x) const;

  using Force = typename A::Force;
  using Motion = typename A::Motion;

  const Model<A>& model_;
  const Workspace<A>& ws_;
  std::vector<typename A::ArticulatedInertia> G_;  // by link
  mutable std::vector<Force> p_;
  mutable std::vector<Motion> a_;
  std::vector<Force> U_;                // by velocity: G_ S, with all later velocities of the link free
  std::vector<double> root_, inverse_;  // 1 / sqrt(D) and 1 / D, with D = S . U
  mutable std::vector<double> column_;
  std::vector<int> link_of_;  // by velocity
};

extern template class ArticulatedFactor<Planar>;
extern template class ArticulatedFactor<Spatial>;

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Projected block Gauss-Seidel: the cones one after the other, each solved exactly with the others' present impulses
// (Jean & Moreau 1992; Jourdan, Alart & Jean 1998). A sweep costs one product.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "cone/block_solver.h"
#include "cone/iteration.h"

namespace gelenk {
namespace {

using Eigen::Index;

constexpr int renewal_interval = 20;  // sweeps between evaluations of u = G x + b: updates add rounding errors

class GaussSeidel {
 public:
  void run(ConeIteration& at) {
    const Eigen::Map<const Eigen::MatrixXd> G = at.matrix();
    for (int sweep = 1;; ++sweep) {
      for (const Cone& cone : at.cones()) relax(at, G, cone);
      at.count_product();
      if (sweep % renewal_interval == 0) at.update_velocity();
      if (!at.advance()) return;
    }
  }

 private:
  static void relax(ConeIteration& at, const Eigen::Map<const Eigen::MatrixXd>& G, const Cone& cone) {
    const auto n = static_cast<std::size_t>(cone.size());
    const Index first = cone.first;
    std::array<double, Cone::max_block> W{};
    std::array<double, Cone::max_size> q{}, x{};
    for (std::size_t i = 0; i < n; ++i) {
      const Index row = first + static_cast<Index>(i);
      x[i] = at.x()[row];
      q[i] = at.u()[row];
      for (std::size_t j = 0; j < n; ++j) {
        const Index column = first + static_cast<Index>(j);
        W[i * n + j] = at.scale(row) * G(row, column) * at.scale(column);
        q[i] -= W[i * n + j] * at.x()[column];
      }
    }
    solve_block(cone, W.data(), q.data(), at.exact(), x.data());
    for (std::size_t j = 0; j < n; ++j) {
      const Index column = first + static_cast<Index>(j);
      const double change = x[j] - at.x()[column];
      if (change == 0) continue;
      at.x()[column] = x[j];
      const double factor = at.scale(column) * change;
      for (Index i = 0; i < at.size(); ++i) at.u()[i] += at.scale(i) * G(i, column) * factor;
    }
  }
};

class GaussSeidelSolver final : public IterativeConeSolver {
  void reserve(ConeIteration&) override {}
  void run(ConeIteration& at) override { method_.run(at); }
  GaussSeidel method_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_gauss_seidel_cone_solver() { return std::make_unique<GaussSeidelSolver>(); }

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The default. Up to about a hundred contacts: semismooth Newton, led by some steps of the spectral projected gradient
// where it stalls. Beyond, factorizing takes longer than many iterations of a gradient method: the accelerated one,
// with Newton's method where it does not suffice and there is a matrix. Without a matrix, or with more than some
// hundred contacts: the accelerated gradient alone.
#include <limits>

#include "cone/accelerated_gradient.h"
#include "cone/newton.h"
#include "cone/spectral_gradient.h"

namespace gelenk {
namespace {

constexpr Eigen::Index newton_first = 300;   // unknowns, up to which Newton's method comes first
constexpr Eigen::Index newton_at_all = 900;  // unknowns, up to which it is used: some tenths of a second per step
constexpr int newton_steps = 100;
constexpr int fixed_point_steps = 200;  // between attempts at the exact problem
constexpr int spectral_steps = 30;
constexpr int accelerated_steps = 300;

class HybridSolver final : public IterativeConeSolver {
  void run(ConeIteration& at) override {
    if (at.size() > newton_at_all || (at.size() > newton_first && !at.has_matrix())) {
      accelerated_.run(at, std::numeric_limits<int>::max());
      return;
    }
    bool newton = at.size() <= newton_first;
    for (; !at.done(); newton = !newton) {
      at.return_to_best();
      if (newton) {
        newton_.run(at, newton_steps);
        for (int k = 0; k < fixed_point_steps && at.exact() && !at.done(); ++k) fixed_point_step(at, k == 0);
      } else if (at.size() <= newton_first) {
        spectral_.run(at, spectral_steps);
      } else {
        accelerated_.run(at, accelerated_steps);
      }
    }
  }

  void reserve(ConeIteration& at) override {
    accelerated_.reserve(at.size());
    if (at.size() > newton_at_all) return;
    spectral_.reserve(at.size());
    shift_.start(at.size());
    newton_.reserve(at.size(), at.cones().size());
  }

  // Solves the convex problem with De Saxce's shift of the present iterate, to a fraction: a step of the fixed-point
  // iteration of FrozenShift, but with Newton's method.
  void fixed_point_step(ConeIteration& at, bool first) {
    if (first) at.return_to_best();
    shift_.start(at.size());
    ConeVector shift = shift_.vector(at.size());
    shift.setZero();
    add_lift(at.cones(), at.u().data(), shift.data());
    newton_.run_with(shift.data(), at, newton_steps);
  }

  ConeMemory shift_;
  SemismoothNewton newton_;
  SpectralGradient spectral_;
  AcceleratedGradient accelerated_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_hybrid_cone_solver() { return std::make_unique<HybridSolver>(); }

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The default: semismooth Newton as long as it converges, led by the spectral projected gradient where it does not.
#include "cone/newton.h"
#include "cone/spectral_gradient.h"

namespace gelenk {
namespace {

constexpr Eigen::Index most_unknowns = 300;  // about a hundred contacts: factorizing more takes longer than iterating
constexpr int gradient_steps = 30;
constexpr int newton_steps = 15;

class HybridSolver final : public IterativeConeSolver {
  void run(ConeIteration& at) override {
    if (at.size() > most_unknowns) {
      while (!at.done()) gradient_.run(at, 1000);
      return;
    }
    for (;;) {
      newton_.run(at, newton_steps);
      if (at.done()) return;
      at.return_to_best();
      gradient_.run(at, gradient_steps);
      if (at.done()) return;
      at.return_to_best();
    }
  }
  SemismoothNewton newton_;
  SpectralGradient gradient_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_hybrid_cone_solver() { return std::make_unique<HybridSolver>(); }

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Projected block Gauss-Seidel: the cones one after the other, each solved exactly with the others' present impulses
// (Jean & Moreau 1992; Jourdan, Alart & Jean 1998). With a sparse root of G a sweep costs as much as a product.
//
// The sweeps are accelerated by Anderson's method. Where that stalls they continue with Nesterov's momentum for a
// while: jammed contacts share impulses that G takes to nearly nothing, and sweeps carry these on and on, by the same
// amount each time, until something slips.
#pragma once

#include <array>
#include <vector>

#include "complementarity/iteration.h"
#include "linear/anderson.h"

namespace gelenk {

class GaussSeidel {
 public:
  void reserve(Eigen::Index n, std::size_t cones);
  // Up to max_sweeps, or until `patience` of them have not halved the least residual.
  void run(ConeIteration& at, int max_sweeps, int patience);

 private:
  template <class Velocities>
  void sweep_all(ConeIteration& at, Velocities& velocities, int max_sweeps, int patience);
  template <class Velocities>
  void sweep(ConeIteration& at, Velocities& velocities);
  void take_blocks(ConeIteration& at);
  void start_momentum(ConeIteration& at);
  void add_momentum(ConeIteration& at);
  void start_acceleration(ConeIteration& at);
  bool accelerate(ConeIteration& at);

  std::vector<std::array<double, Cone::max_block>> blocks_;  // of G, in scaled variables
  std::vector<double> value_, w_;                            // of a root
  ConeMemory memory_;
  double* before_ = nullptr;  // where the last sweep began
  double* last_ = nullptr;    // the result of the last sweep but one
  double momentum_ = 1;       // Nesterov's t
  double last_change_ = 0;
  AndersonAcceleration acceleration_;
};

}  // namespace gelenk

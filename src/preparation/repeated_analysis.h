// SPDX-License-Identifier: BSD-3-Clause
// What of the preparation of a scene depends on its inertias and loads: found again for others, without an assembly.
//
// Positions and velocities at the start follow from geometry alone. Inertias and loads decide whether the mass matrix
// can be factorized, in which direction a mechanism sets out, and, as the metric in which the constraint equations are
// factorized, what is known of their pivots.
#pragma once

#include <memory>
#include <vector>

#include "kinematics/loads.h"
#include "preparation/preparation.h"
#include "preparation/start.h"

namespace gelenk {

class RepeatedAnalysis {
 public:
  // scene: of which `prepared` was prepared. before: reduce(scene). loads: of the islands. All but `before` must
  // outlive it.
  RepeatedAnalysis(const Scene& scene, double time, const Inputs& inputs, PreparedScene& prepared,
                   const ReducedScene& before, const std::vector<const Loads*>& loads);

  // Whether the preparation is of the kind of which only inertias and loads need to be looked at: nothing was in doubt,
  // no reduction followed from the start, and no position is prescribed.
  bool is_possible() const { return is_possible_; }
  // After inertias of the scene or numbers of the loads have changed: analyzes it at the same start, and brings the
  // inertias and the mobility in `prepared` up to date. Returns false if the preparation of the scene may differ in
  // anything else.
  bool repeat();

 private:
  // A link, and the bodies that are welded together in it.
  struct Bodies {
    int island = 0, link = 0;
    std::vector<int> bodies;  // of the scene, in the order in which their inertias are added
    std::vector<Pose3> X_GB;  // of each in the frame of the first
    Pose3 X_LG;
  };

  bool find_bodies();
  Spatial::Inertia inertia(const Bodies& of) const;
  bool repeat(std::size_t island);

  const Scene& scene_;
  PreparedScene& prepared_;
  std::vector<const Loads*> loads_;
  std::vector<std::unique_ptr<Dynamics>> dynamics_;  // of the islands with all constraint equations
  std::vector<Bodies> links_;
  std::vector<StartGuesses> guesses_;
  std::vector<double> no_inputs_;
  bool is_possible_ = false;
};

// Whether two sets of loads of an island are the same but for numbers.
bool differ_in_numbers_alone(const Loads& a, const Loads& b);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The reaction of a joint as users see it.
#pragma once

#include "dynamics/dynamics.h"

namespace gelenk {

// Force [N] and torque [N m] of a joint on its child body at the origin of its frame M, resolved in its frame F.
class Reaction {
 public:
  // joint: of the scene, in the tree or cut.
  Reaction(const Scene& scene, const ReducedScene& reduced, int joint);

  // Component 0..2 of the force, 3..5 of the torque. dynamics: of the joint's island, with accelerations set.
  // T: double, or numbers that carry derivatives.
  template <class T>
  T component(int i, const Readings<T>& dynamics) const;

 private:
  bool cut_;
  int index_;     // link or cut
  BodyPlace at_;  // where the wrench is known: frame of the link, or the cut's M
  double side_;   // -1: known on the parent
  BodyPlace frame_M_, frame_F_;
};

}  // namespace gelenk

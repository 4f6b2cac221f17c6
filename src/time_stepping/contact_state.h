// SPDX-License-Identifier: BSD-3-Clause
// What a time-stepping scheme remembers of contacts from one step to the next: the impulses at the points of contact,
// from which the next step starts, and the wrenches that outputs show.
#pragma once

#include <Eigen/Core>
#include <tuple>
#include <vector>

#include "contact_geometry/contact_finder.h"
#include "dynamics/switching_forces.h"
#include "nonsmooth/contact_sum.h"
#include "util/archive.h"

namespace gelenk {

// A point that was in contact in the last step.
struct RememberedContact {
  int a = 0, b = 0, feature = 0;
  bool slides = false;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N, on b, in the root frame: the mean over the step
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  // N m
  double gap = 0, gap_rate = 0;                      // m, m/s: in the middle of the step; at its end

  std::tuple<int, int, int> key() const { return {a, b, feature}; }
};

struct ContactState {
  std::vector<RememberedContact> contacts;  // ordered by their keys
  std::vector<LockForces> locks;            // by lock: means over the step, and modes at its end
  bool any_latch = false;                   // among locks
  std::vector<Spatial::Force> wrenches;  // by link, about its origin, along the axes of the root frame: of all contacts
  std::vector<double> along;             // by velocity: generalized forces of friction and limits
  std::vector<ContactSum> sums;          // by contact of the scene
  double step = 0;                       // s: the last one; 0: none that has moved anything

  // Of what a saved state has of many contacts, for which memory is taken at the start: of 200 points [64 bits].
  static constexpr std::size_t reserved_words = std::size_t{200} * 12;

  const RememberedContact* find(const NearPoint& point) const;
  // Saves or restores it. shapes: number of shapes of the mechanism.
  void serialize(Archive& archive, int shapes);
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The laws of restitution, in located impacts and in time steps alike. Normal velocities after an impact are at least
// -restitution times the approach (Newton's law, as Moreau 1988 states it for several contacts), or impulses are at
// least 1 + restitution times those of compression, which ends when nothing approaches any more (Poisson's law; Glocker
// & Pfeiffer 1995). Where a law would add energy, as Newton's may with friction (Kane & Levinson 1985) or unlike
// restitutions, restitution is reduced to what adds none.
#pragma once

#include <vector>

namespace gelenk {

class Restitution {
 public:
  // Something that is struck, by the row of the velocity along its normal.
  struct Struck {
    int row = 0;
    double sign = 1;         // of the motion away from what is struck
    double restitution = 0;  // of this impact
    double approach = 0;     // speed before it; 0: it does not approach
    bool poisson = false;    // Poisson's law instead of Newton's
    double part = 1;         // of the restitution, if the whole of it adds energy
  };

  void clear() { struck_.clear(); }
  void reserve(std::size_t count) { struck_.reserve(count); }
  void add(const Struck& struck) { struck_.push_back(struck); }
  // Whether the impulses of compression are needed: those without restitution.
  bool needs_compression() const;
  // Of all, or of those whose row `concerns`.
  void set_part(double part) {
    for (Struck& at : struck_) at.part = part;
  }
  template <class Concerns>
  void set_part(double part, Concerns concerns) {
    for (Struck& at : struck_) {
      if (concerns(at.row)) at.part = part;
    }
  }
  // Adds to the velocities b what Newton's restitutions demand of those after the impact.
  void add_demands(double* b) const;
  // least <- by row, the impulses that Poisson's restitutions demand, from those of compression.
  void set_least_impulses(const double* compression, double* least) const;

 private:
  std::vector<Struck> struck_;
};

// The largest part of the restitutions that adds no energy. adds_none(part): solves with this part.
template <class AddsNone>
double largest_part(int bisections, AddsNone adds_none) {
  double low = 0;
  double high = 1;
  for (int k = 0; k < bisections; ++k) {
    const double middle = (low + high) / 2;
    (adds_none(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace gelenk

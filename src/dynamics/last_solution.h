// SPDX-License-Identifier: BSD-3-Clause
// The last accelerations, which are asked for again under the same conditions: by outputs and by the step that begins
// there, and in each stage of a step while a mechanism is held at rest.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace gelenk {

class LastSolution {
 public:
  // All that accelerations depend on, besides the numbers of loads.
  struct Conditions {
    long factors;                    // changes with the position, and with all else that the factors depend on
    long velocities;                 // changes with them, and with gravity
    long multipliers;                // changes when those of the solution are overwritten
    const double* u;                 // all inputs of the scene
    std::span<const int> held;       // the held modes of forces; empty: they follow from the state
    std::span<const bool> branches;  // the held branches of laws; empty as above
  };

  // inputs: those that act here, of which the list must outlive it; modes, branches: how many can be held.
  LastSolution(const std::vector<int>& inputs, int nv, int modes, int branches)
      : inputs_(inputs),
        u_(inputs.size()),
        vdot_(static_cast<std::size_t>(nv)),
        held_(static_cast<std::size_t>(modes)),
        branches_(static_cast<std::size_t>(branches)) {}

  bool is_for(const Conditions& now) const {
    if (!holds_ || now.factors != factors_ || now.velocities != velocities_ || now.multipliers != multipliers_)
      return false;
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      if (now.u[inputs_[i]] != u_[i]) return false;
    }
    return std::ranges::equal(now.held, std::span(held_).first(held_count_)) &&
           std::ranges::equal(now.branches, std::span(branches_).first(branch_count_));
  }
  // Exchanges vdot for a vector of the same size.
  void keep(const Conditions& now, std::vector<double>& vdot) {
    holds_ = true;
    kept_number_ = number_;
    factors_ = now.factors;
    velocities_ = now.velocities;
    multipliers_ = now.multipliers;
    for (std::size_t i = 0; i < inputs_.size(); ++i) u_[i] = now.u[inputs_[i]];
    held_count_ = now.held.size();
    if (held_count_ > 0) std::ranges::copy(now.held, held_.begin());
    branch_count_ = now.branches.size();
    if (branch_count_ > 0) std::ranges::copy(now.branches, branches_.begin());
    std::swap(vdot_, vdot);
  }
  // Begins another one, beside which this one is kept.
  void begin_other() { number_ = ++count_; }
  void drop() {
    holds_ = false;
    begin_other();
  }
  // Returns to it.
  const std::vector<double>& repeat() {
    number_ = kept_number_;
    return vdot_;
  }
  // Of the last one; that of a repeated one is the same.
  long number() const { return number_; }

 private:
  const std::vector<int>& inputs_;
  bool holds_ = false;
  long count_ = 0, number_ = 0, kept_number_ = 0;
  long factors_ = 0, velocities_ = 0, multipliers_ = 0;
  std::vector<double> u_, vdot_;
  std::vector<int> held_;
  std::vector<char> branches_;
  std::size_t held_count_ = 0, branch_count_ = 0;
};

}  // namespace gelenk

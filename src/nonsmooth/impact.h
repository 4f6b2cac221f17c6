// SPDX-License-Identifier: BSD-3-Clause
// A located impact: impulses of everything that is struck at the same instant, contacts of shapes and bounds of joints
// alike, by the laws of restitution. Coulomb's law holds for the velocities after it.
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "complementarity/redundant_impulses.h"
#include "nonsmooth/restitution.h"

namespace gelenk {

class Impact {
 public:
  // Something that is struck: its first row is that of the velocity along its normal.
  struct Struck {
    Cone cone;
    double sign = 1;         // of the motion away from what is struck, in the first row
    double restitution = 0;  // of this impact
    bool poisson = false;    // Poisson's law instead of Newton's
  };
  // G: the change of velocities (rows) per impulse along them (columns); speeds: before it, by row.
  Impact(Eigen::MatrixXd G, Eigen::VectorXd speeds, std::vector<Struck> struck);

  std::size_t count() const { return struck_.size(); }
  double sign(std::size_t i) const { return struck_[i].sign; }
  double restitution(std::size_t i) const { return struck_[i].restitution; }
  void set_inelastic(std::size_t i) { struck_[i].restitution = 0; }
  // Makes what is struck stop: it neither approaches nor leaves.
  void hold(std::size_t i);
  bool is_held(std::size_t i) const;
  // Finds the impulses, of what acts on each other together: the rest takes no part in what its laws permit. Returns
  // false if none agree with the laws of restitution; they are inelastic then, if such can be found.
  bool solve(ConeSolver& solver);
  long iterations() const { return iterations_; }
  const Eigen::VectorXd& impulses() const { return x_; }  // by row
  // By number: velocities away from what is struck, before and after it.
  double approach(std::size_t i) const { return struck_[i].sign * speeds_[row(i)]; }
  double rebound(std::size_t i) const { return struck_[i].sign * (speeds_[row(i)] + G_.row(row(i)).dot(x_)); }
  // Velocity per impulse along its normal.
  double mobility(std::size_t i) const { return G_(row(i), row(i)); }

 private:
  Eigen::Index row(std::size_t i) const { return struck_[i].cone.first; }
  bool solve_together(ConeSolver& solver);
  Impact part(std::span<const std::pair<int, int>> numbers, std::vector<Eigen::Index>& rows) const;
  bool solve(ConeSolver& solver, double part);
  double solve_cones(ConeSolver& solver, const Eigen::VectorXd& b);
  double solve_boxes(const Eigen::VectorXd& b);
  bool adds_energy() const;

  Eigen::MatrixXd G_;
  Eigen::VectorXd speeds_, x_;
  std::vector<Struck> struck_;
  Restitution restitution_;  // of struck_
  std::vector<Cone> cones_;  // of struck_
  long iterations_ = 0;
  bool are_boxes_ = false;      // bounds of single rows, whose problem is solved exactly
  bool are_redundant_ = false;  // impulses; else they are unique
  RedundantImpulses redundant_;
  Eigen::VectorXd compression_;  // impulses without restitution; empty: not needed
};

}  // namespace gelenk

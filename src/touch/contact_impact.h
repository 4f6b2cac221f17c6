// SPDX-License-Identifier: BSD-3-Clause
// Impulses of everything that is struck at the same instant: contacts of shapes, and limits of joints.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "cone/cone.h"
#include "modes/impact.h"
#include "touch/touch_equations.h"

namespace gelenk {

// Normal velocities of at least -restitution times the approach after it (Moreau 1988), or Poisson's law for the limits
// that have it, and Coulomb's law for the velocities after it. Friction of joints exerts no impulses.
class ContactImpact {
 public:
  struct StruckLimit {
    Eigen::VectorXd row;  // of the speed of its coordinate, by velocity
    StruckContact is;     // held: it stops; then its side may be 0
  };

  // At the state of the last solve() of `dynamics`, of which v are the velocities, with nothing kept at rest.
  ContactImpact(TouchEquations& touch, const std::vector<int>& spots, const std::vector<StruckLimit>& limits,
                const double* v, double slow);

  // Of the contacts, followed by the limits.
  std::size_t count() const { return cones_.size(); }
  // By number: velocities away from what is touched, before it.
  const Eigen::VectorXd& approach() const { return approach_; }
  double restitution(std::size_t i) const { return restitution_[static_cast<Eigen::Index>(i)]; }
  void set_inelastic(std::size_t i) { restitution_[static_cast<Eigen::Index>(i)] = 0; }
  // Returns false if no impulses were found.
  bool solve(ConeSolver& solver);
  // The same after it.
  Eigen::VectorXd rebounds() const;
  // The same of the accelerations vdot of that solve().
  Eigen::VectorXd accelerations(const double* vdot) const;
  // v after it.
  void apply(double* v) const;

 private:
  void add_contact(const TouchEquations& touch, const TouchEquations::Entry& entry, double slow);
  void add_limits(const std::vector<StruckLimit>& limits);
  void find_weights();
  bool solve(ConeSolver& solver, double part);
  double solve_cones(ConeSolver& solver, const Eigen::MatrixXd& matrix, const Eigen::VectorXd& b);
  double solve_redundant(ConeSolver& solver, const Eigen::VectorXd& b);
  double energy() const;

  TouchEquations::Rows rows_;
  TouchEquations::RowMatrix Z_;
  Eigen::MatrixXd G_;
  Eigen::VectorXd speeds_, approach_, restitution_, x_;
  Eigen::VectorXd weights_;      // by row: of redundant impulses; empty: they are unique
  Eigen::VectorXd sign_;         // by number: of the motion away from what is touched
  std::vector<char> poisson_;    // by number
  Eigen::VectorXd compression_;  // impulses without restitution; empty: not needed
  std::vector<Cone> cones_;
};

// The cone of the forces of a contact with these coefficients.
Cone cone_of(const TouchEquations::Entry& entry, const std::array<double, contact_groups>& coefficients);

}  // namespace gelenk

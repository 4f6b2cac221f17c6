// SPDX-License-Identifier: BSD-3-Clause
// What follows where contacts change: the impulses of an impact, and the modes in which closed contacts continue. Both
// are cone complementarity problems, of velocities and of accelerations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "cone/cone.h"
#include "touch/touch_equations.h"

namespace gelenk {

// Which indicators of a spot have changed their sign.
struct Trigger {
  bool touches = false, leaves = false;
  std::array<bool, contact_groups> groups{};

  bool any() const { return touches || leaves || groups[0] || groups[1] || groups[2]; }
};

// Impulses of all contacts together: normal velocities of at least -restitution times the approach after it (Moreau
// 1988), and Coulomb's law for the velocities after it.
class ContactImpact {
 public:
  // At the state of the last solve() of `dynamics`, of which v are the velocities.
  ContactImpact(TouchEquations& touch, const std::vector<int>& spots, const double* v, double slow);

  const Eigen::VectorXd& approach() const { return approach_; }  // by spot: normal velocities before it
  double restitution(std::size_t i) const { return restitution_[static_cast<Eigen::Index>(i)]; }
  void set_inelastic(std::size_t i) { restitution_[static_cast<Eigen::Index>(i)] = 0; }
  // Returns false if no impulses were found.
  bool solve(ConeSolver& solver);
  // Normal velocities after it.
  Eigen::VectorXd rebounds() const;
  // Normal accelerations for the vdot of that solve().
  Eigen::VectorXd accelerations(const double* vdot) const;
  // v after it.
  void apply(double* v) const;

 private:
  bool solve(ConeSolver& solver, double part);
  double energy() const;

  TouchEquations::Rows rows_;
  TouchEquations::RowMatrix Z_;
  Eigen::MatrixXd G_;
  Eigen::VectorXd speeds_, approach_, restitution_, x_;
  std::vector<Cone> cones_;
};

class ContactDecision {
 public:
  explicit ContactDecision(TouchEquations& touch);

  ConeSolver& solver() { return *solver_; }
  // Decides on spots that touch, at the state of the last solve() of `dynamics` with all contacts open, which gave
  // vdot. next: in, the modes of those that move and the others' groups at rest; out, the modes that follow.
  enum class Outcome { found, ambiguous, none };
  Outcome decide(const std::vector<int>& spots, const std::vector<Trigger>& triggered, const double* vdot,
                 std::vector<SpotMode>& next);

 private:
  void set_cones(const std::vector<Trigger>& triggered);
  void solve_cones(const Eigen::VectorXd& normal);
  std::vector<SpotMode> modes_of_solution(const std::vector<SpotMode>& tentative,
                                          const std::vector<Trigger>& triggered) const;
  void find_motion(std::size_t i, int group, const Eigen::VectorXd& a, bool is_triggered, SpotMode& mode) const;
  Eigen::VectorXd normal_forces() const;
  int most_pulling() const;
  bool obeys(std::size_t i, const SpotMode& mode, const Eigen::VectorXd& relative) const;
  bool refine(const double* vdot, std::vector<SpotMode>& next);
  bool check(const double* vdot, const std::vector<SpotMode>& next, int& pulls);
  bool let_slide(const std::vector<SpotMode>& tentative, const std::vector<SpotMode>& next);

  TouchEquations& touch_;
  std::unique_ptr<ConeSolver> solver_;
  std::vector<int> spots_;
  TouchEquations::Rows rows_;
  Eigen::MatrixXd G_, C_;
  Eigen::VectorXd b_, x_;
  double scale_ = 0;  // of accelerations
  std::vector<Cone> cones_;
  std::vector<std::array<bool, contact_groups>> slides_;  // friction that does not hold any more
  std::vector<char> opens_;
};

}  // namespace gelenk

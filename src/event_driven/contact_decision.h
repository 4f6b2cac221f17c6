// SPDX-License-Identifier: BSD-3-Clause
// The modes in which closed contacts and joints at rest continue: a cone complementarity problem of accelerations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "complementarity/cone.h"
#include "complementarity/rest_first.h"
#include "event_driven/contact_equations.h"
#include "event_driven/impact_equations.h"
#include "event_driven/lock_problem.h"

namespace gelenk {

// Which indicators of a candidate have changed their sign.
struct Trigger {
  bool touches = false, leaves = false;
  bool ends = false;  // beyond the end of a feature
  std::array<bool, contact_groups> groups{};

  bool any() const { return touches || leaves || ends || groups[0] || groups[1] || groups[2]; }
};

class ContactDecision {
 public:
  explicit ContactDecision(ContactEquations& equations);

  ConeSolver& solver() { return *solver_; }
  // Decides on candidates that touch and on locks, at the state of the last solve() of `dynamics` with all contacts
  // open and these locks released, which gave vdot. next: in, the modes of those that move and the others' groups at
  // rest; out, the modes that follow.
  enum class Outcome { found, ambiguous, none };
  Outcome decide(const std::vector<int>& candidates, const std::vector<Trigger>& triggered, const double* vdot,
                 std::vector<CandidateMode>& next, LockProblem& problem);
  // Of the last decide().
  long iterations() const { return iterations_; }
  // The forces of contacts of the last decide(), by row of those that were closed; within the laws.
  Eigen::VectorXd contact_forces() const { return x_.head(first_lock_); }

 private:
  void set_up(const std::vector<CandidateMode>& tentative, const std::vector<Trigger>& triggered, const double* vdot);
  void add_lock_rows();
  void set_cones();
  void set_lock_cones();
  void solve_cones(const Eigen::VectorXd& normal);
  std::vector<CandidateMode> modes_of_solution(const std::vector<CandidateMode>& tentative) const;
  void answer_locks();
  void find_motion(std::size_t i, int group, const Eigen::VectorXd& a, CandidateMode& mode) const;
  void find_directions(const std::vector<CandidateMode>& tentative, const Eigen::VectorXd& normal,
                       std::vector<CandidateMode>& next);
  Eigen::VectorXd normal_forces() const;
  Eigen::VectorXd normal_forces_in_modes();
  bool exceeds_limits();
  int side_beyond_limit(std::size_t i) const;
  bool locks_exceed_limits() const;
  bool resolve_redundancy(std::vector<CandidateMode>& next);
  bool let_go_beyond_limits(int candidate);
  bool is_indeterminate(const std::vector<CandidateMode>& next) const;
  bool slides_with(const Eigen::VectorXd& normal) const;
  bool presses(int candidate) const;
  int most_pulling() const;
  bool locks_obey(const Eigen::VectorXd& relative) const;
  bool refine(const double* vdot, std::vector<CandidateMode>& next);
  bool check(const double* vdot, const std::vector<CandidateMode>& next, int& pulls);
  bool try_locks(const double* vdot, std::vector<CandidateMode>& next);
  bool let_locks_slip();
  bool let_slide(const std::vector<CandidateMode>& tentative, const std::vector<CandidateMode>& next);

  ContactEquations& equations_;
  std::unique_ptr<ConeSolver> solver_;
  RestFirst rest_first_;
  std::vector<int> candidates_;
  ContactEquations::Rows rows_;
  Eigen::MatrixXd G_, C_;
  Eigen::VectorXd b_, x_;
  double scale_ = 0;  // of accelerations
  long iterations_ = 0;
  std::vector<Cone> cones_;
  // Whether friction of a contact or a joint has reached its limit. What holds with it, at limits of its own, moves
  // with it.
  bool breaks_away_ = false;
  bool has_consistent_friction_ = false;  // what slides has the friction of the normal forces that were found
  std::vector<std::array<bool, contact_groups>> slides_;  // friction that does not hold any more
  std::vector<char> opens_;
  LockProblem* problem_ = nullptr;  // of the present decision
  int first_lock_ = 0;              // its row
  std::vector<char> slips_;         // by lock: friction that does not hold any more
};

}  // namespace gelenk

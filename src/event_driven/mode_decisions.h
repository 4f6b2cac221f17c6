// SPDX-License-Identifier: BSD-3-Clause
// The modes in which joints and contacts continue: what moves keeps moving, and on what is at rest accelerations
// decide.
#pragma once

#include <vector>

#include "event_driven/contact_decision.h"
#include "event_driven/contact_modes.h"
#include "event_driven/joint_decisions.h"
#include "event_driven/mode_equations.h"

namespace gelenk {

class ModeDecisions {
 public:
  struct Context {
    const Mechanism& mechanism;
    Dynamics& dynamics;
    ModeEquations& equations;
    LockModes& joints;
    ContactModes& contacts;
  };
  explicit ModeDecisions(const Context& context);

  struct Modes {
    LockModes::State joints;
    std::vector<CandidateMode> contacts;
  };
  enum class Asked { joints, all };  // of which modes are determined
  // The modes that follow at (t, y). triggered: by candidate.
  Modes decide(double t, const double* y, Asked asked, const std::vector<Trigger>& triggered);
  // Of contacts, in the last decide(); and the first candidate on which it decided, -1: on none.
  ContactDecision::Outcome outcome() const { return outcome_; }
  int decided_candidate() const { return decided_candidate_; }
  JointDecisions& joints() { return joints_; }
  // Where no modes agreed with the loads of friction in the last decide(), at the same state: the index, among all
  // forces with modes, of a friction in motion that seizes if what might be at rest is, under a load of either sign;
  // -1: there is none, or modes agreed.
  int seizing(double t, const double* y);

  // Whether everything that is kept at rest can remain so, by any distribution of redundant forces. The loads of
  // friction are those of the last solve().
  bool hold_by_others(double t, const double* y);
  // The forces of contacts found by the last hold_by_others() (ContactDecision::contact_forces).
  Eigen::VectorXd contact_forces() const { return decision_.contact_forces(); }
  ConeSolver& solver() { return decision_.solver(); }

 private:
  Modes find(double t, const double* y, Asked asked, const std::vector<Trigger>& triggered);
  Modes find_held(double t, const double* y, Asked asked, const std::vector<Trigger>& triggered);
  Modes find_with_loads(double t, const double* y, Asked asked, const std::vector<Trigger>& triggered);
  void find_contact_modes(double t, const double* y, const std::vector<Trigger>& triggered,
                          std::vector<CandidateMode>& next);
  ContactDecision::Outcome decide_on(const std::vector<int>& candidates, const std::vector<Trigger>& triggered,
                                     std::vector<CandidateMode>& next);
  std::vector<int> lasting(double rest);
  void set_accelerations(double t, const double* y);
  void set_joints(const LockModes::State& state) {
    if (!modes_.empty()) modes_.set_state(state);
  }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  ModeEquations& equations_;
  LockModes& modes_;  // of joints
  ContactModes& contacts_;
  ContactEquations& contact_equations_;
  JointDecisions joints_;
  ContactDecision decision_;
  bool agrees_with_loads_ = true;
  int decided_candidate_ = -1;
  ContactDecision::Outcome outcome_ = ContactDecision::Outcome::found;
  std::vector<double> vdot_;
};

// Whether they differ in what is closed and what moves.
bool differ(const std::vector<CandidateMode>& a, const std::vector<CandidateMode>& b);
// Whether a rebound of a contact at this speed is lost in the rounding of the position, for this acceleration back.
bool is_lost_contact(double speed, double acceleration);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The equations of an impact: rows of everything that is struck at the same instant, contacts of shapes and bounds of
// joints. Friction of joints exerts no impulses.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "event_driven/contact_equations.h"
#include "event_driven/joint_impacts.h"
#include "nonsmooth/impact.h"

namespace gelenk {

class ImpactEquations {
 public:
  // At the state of the last solve() of `dynamics`, of which v are the velocities; with contacts, nothing is kept at
  // rest in it. Contacts come first, in the order of `candidates`; speeds up to `slow` are rest.
  ImpactEquations(ContactEquations& contact_equations, SwitchingForces& forces, const std::vector<int>& candidates,
                  const std::vector<JointImpacts::Struck>& joints, const double* v, double slow);

  Impact& law() { return *law_; }
  const Impact& law() const { return *law_; }
  // Accelerations away from what is struck, by number, of the accelerations vdot of that solve().
  Eigen::VectorXd accelerations(const double* vdot) const;
  // v after it.
  void apply(double* v) const;

 private:
  Impact::Struck contact(const ContactEquations& contact_equations, const ContactEquations::Entry& entry,
                         double slow) const;
  Impact::Struck joint(const JointImpacts::Struck& at, Eigen::Index row) const;

  SwitchingForces& forces_;
  ContactEquations::Rows rows_;    // of contacts
  ContactEquations::RowMatrix Z_;  // their effect on velocities
  std::vector<int> locks_;
  std::optional<Impact> law_;
};

// The cone of the forces of a contact with these coefficients.
Cone cone_of(const ContactEquations::Entry& entry, const std::array<double, contact_groups>& coefficients);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Impacts that follow each other within the accuracy of a run: they might come in another order, with another motion
// afterwards.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "event_driven/contact_modes.h"
#include "event_driven/joint_impacts.h"

namespace gelenk {

class ImpactOrder {
 public:
  // All must outlive it. first_of_contacts: the first indicator of contacts in the event log.
  ImpactOrder(ContactModes& contacts, const JointImpacts& joints, int first_of_contacts)
      : contacts_(contacts), joints_(joints), first_of_contacts_(first_of_contacts) {}

  // Before impulses at y, with the accelerations vdot: finds what is about to be struck as well, or was just before.
  void find(const double* y, int nq, const std::vector<double>& vdot);
  // After them, with the velocities v: the indicator of something found whose motion they change; -1: none.
  int changed(const double* v) const;

 private:
  struct Near {
    int indicator = 0;
    int lock = -1, side = 0;  // of a limit
    Eigen::MatrixXd rows{};   // of a contact: relative velocities by velocities
    double rate = 0;          // of the distance
  };
  double change(const Near& of, const double* v) const;

  ContactModes& contacts_;
  const JointImpacts& joints_;
  int first_of_contacts_;
  std::vector<Near> near_;
  std::vector<double> before_;  // velocities
};

}  // namespace gelenk

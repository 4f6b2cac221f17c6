// SPDX-License-Identifier: BSD-3-Clause
// What outputs and events show of contacts between events.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "contact_geometry/contact_finder.h"
#include "event_driven/contact_equations.h"
#include "nonsmooth/contact_sum.h"
#include "nonsmooth/law_audit.h"
#include "nonsmooth/shared_load.h"

namespace gelenk {

struct Scene;

class ContactOutputs final : public ContactReadings {
 public:
  // Numbers of indicators of a candidate: of its contact, of each group of friction, and of the ends of its features.
  static constexpr int per_candidate = 2 + contact_groups;
  // Far above what events and steps with impulses leave [natural units of length].
  static constexpr double least_overlap = 100 * touch_tolerance;

  // All must outlive it. contacts: of the scene.
  ContactOutputs(const Mechanism& mechanism, Dynamics& dynamics, ContactEquations& contact_equations,
                 std::size_t contacts);

  // While outputs are determined, modes are previewed, and then all contacts open, so that the recorded forces act as
  // loads.
  void keep_modes() { kept_ = contact_equations_.modes(); }
  void open_all() { contact_equations_.set_modes(open_); }
  void return_to_modes() { contact_equations_.set_modes(kept_); }
  // Records the forces and modes after the accelerations have been solved for. distributed: forces with the same
  // effect, by row (ContactEquations::forces_of); null: those solved for.
  void record(const Eigen::VectorXd* distributed);
  const LawAudit& audit() const { return audit_; }
  // What contacts share with joints at rest, of which the motion depends on the shares.
  const std::optional<SharedLoad>& shared_load() const { return shared_load_; }
  // The recorded forces by link (ContactRows::apply_forces).
  const Spatial::Force* wrenches() const { return wrenches_.data(); }
  Eigen::Vector3d force(int contact) const override { return sums_[static_cast<std::size_t>(contact)].force; }
  int mode(int contact) const override { return sums_[static_cast<std::size_t>(contact)].mode; }
  double gap(int contact) override;
  std::vector<ContactForce> forces() override { return forces_; }
  // Whether shapes overlap at q by more than located contacts do.
  bool any_overlap(const double* q);

  // By indicator: what happens when it becomes negative, and positive.
  std::vector<std::array<std::string, 2>> event_texts(const std::vector<std::string>& bodies,
                                                      const std::vector<std::string>& contacts) const;

 private:
  void add_to_audit(const ContactEquations::Entry& entry, const ContactEquations::CandidateForce& force, double slack);

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  ContactEquations& contact_equations_;
  ContactFinder finder_;
  std::vector<ContactSum> sums_;  // by contact of the scene
  std::vector<ContactForce> forces_;
  std::vector<Spatial::Force> wrenches_;  // by link
  std::vector<CandidateMode> kept_, open_;
  LawAudit audit_;  // of the recorded forces
  std::optional<SharedLoad> shared_load_;
};

}  // namespace gelenk

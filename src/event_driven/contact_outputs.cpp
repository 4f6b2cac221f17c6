// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/contact_outputs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "event_driven/shared_loads_of_contacts.h"
#include "mechanism/mechanism.h"

namespace gelenk {

ContactOutputs::ContactOutputs(const Mechanism& mechanism, Dynamics& dynamics, ContactEquations& contact_equations,
                               std::size_t contacts)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      contact_equations_(contact_equations),
      finder_(mechanism, contacts),
      sums_(contacts),
      wrenches_(mechanism.links.size()),
      kept_(contact_equations.modes()),
      open_(kept_.size()) {
  forces_.reserve(kept_.size());
}

void ContactOutputs::record(const Eigen::VectorXd* distributed) {
  std::ranges::fill(sums_, ContactSum{});
  std::ranges::fill(wrenches_, Spatial::Force{});
  forces_.clear();
  const auto& forces =
      distributed == nullptr ? contact_equations_.forces() : contact_equations_.forces_of(*distributed);
  add_wrenches(contact_equations_, forces, wrenches_);
  audit_ = {};
  double slack = least_audited_force;
  for (const auto& force : forces) slack += audited_fraction * std::abs(force.normal);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const ContactEquations::Entry& entry = contact_equations_.rows().entries[i];
    add_to_audit(entry, forces[i], slack);
    const ContactCandidate& candidate = contact_equations_.candidates()[entry.candidate];
    forces_.push_back({candidate.contact, candidate.core, candidate.tip, entry.at.p, forces[i].force, forces[i].moment,
                       forces[i].normal});
    ContactSum& sum = sums_[static_cast<std::size_t>(candidate.contact)];
    sum.force -= candidate.sign * (mechanism_.X_W0.R * (candidate.turns() ? forces[i].moment : forces[i].force));
    const CandidateMode& mode = contact_equations_.modes()[static_cast<std::size_t>(entry.candidate)];
    const bool slides = mode.groups[0].moves || !(contact_equations_.coefficient(entry.candidate, 0, false) > 0);
    sum.mode = std::max(sum.mode, slides ? 2 : 1);
  }
  shared_load_ = find_shared_load(contact_equations_, mechanism_, dynamics_);
}

void ContactOutputs::add_to_audit(const ContactEquations::Entry& entry, const ContactEquations::CandidateForce& force,
                                  double slack) {
  const int contact = contact_equations_.candidates()[entry.candidate].contact;
  audit_.add(-force.normal / slack, {BrokenLaw::Kind::contact_pulls, contact, force.normal});
  for (int group = 0; group < contact_groups; ++group) {
    const auto g = static_cast<std::size_t>(group);
    if (entry.rows[g] < 0) continue;
    const double permitted =
        contact_equations_.coefficient(entry.candidate, group, false) * std::max(0.0, force.normal);
    const auto kind = group == 0 ? BrokenLaw::Kind::contact_friction : BrokenLaw::Kind::contact_moment;
    audit_.add((force.held[g] - permitted) / (audited_fraction * permitted + slack),
               {kind, contact, force.held[g], permitted});
  }
}

bool ContactOutputs::any_overlap(const double* q) {
  dynamics_.set_position(q);
  dynamics_.readings().set_root_poses();
  for (std::size_t contact = 0; contact < sums_.size(); ++contact) {
    if (gap(static_cast<int>(contact)) < -least_overlap) return true;
  }
  return false;
}

double ContactOutputs::gap(int contact) {
  contact_equations_.candidates().read_position(dynamics_);
  double out = std::numeric_limits<double>::infinity();
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    const ContactCandidate& candidate = contact_equations_.candidates()[i];
    if (candidate.contact != contact) continue;
    // Features that are apart sideways have no gap.
    if (candidate.kind == ContactCandidate::Kind::corner || candidate.kind == ContactCandidate::Kind::edges)
      return finder_.smallest_gaps(dynamics_.readings())[static_cast<std::size_t>(contact)];
    out = std::min(out, contact_equations_.candidates().gap(i));
  }
  return out;
}

std::vector<std::array<std::string, 2>> ContactOutputs::event_texts(const std::vector<std::string>& bodies,
                                                                    const std::vector<std::string>& contacts) const {
  const auto name = [&](int shape) {
    const int body = mechanism_.shapes[static_cast<std::size_t>(shape)].scene_body;
    return body < 0 ? std::string("the ground") : bodies[static_cast<std::size_t>(body)];
  };
  std::vector<std::array<std::string, 2>> out;
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    const ContactCandidate& candidate = contact_equations_.candidates()[i];
    if (candidate.is_given()) {
      const std::string& friction = contacts[static_cast<std::size_t>(candidate.contact)];
      const std::string joint = friction.substr(0, friction.find('.'));
      const std::string slips = candidate.is_moment ? " slips in its rotation" : " slips in its translation";
      const std::string sticks = candidate.is_moment ? " sticks in its rotation" : " sticks in its translation";
      out.emplace_back();
      out.push_back({joint + sticks, joint + slips});
      for (int k = 2; k < per_candidate; ++k) out.emplace_back();
      continue;
    }
    if (candidate.turns()) {
      const std::string& limit = contacts[static_cast<std::size_t>(candidate.contact)];
      const std::string joint = limit.substr(0, limit.rfind('.'));
      out.push_back({joint + " leaves its swing limit", joint + " meets its swing limit"});
      for (int k = 1; k < per_candidate; ++k) out.emplace_back();
      continue;
    }
    const std::string subject = contacts[static_cast<std::size_t>(candidate.contact)] + ": " + name(candidate.tip);
    const std::string core = name(candidate.core);
    out.push_back({subject + " leaves " + core, subject + " touches " + core});
    out.push_back({subject + " stops sliding on " + core, subject + " slides on " + core});
    out.push_back({subject + " stops spinning on " + core, subject + " spins on " + core});
    out.push_back({subject + " stops rolling on " + core, subject + " rolls on " + core});
    out.push_back({subject + " slides off an edge of " + core, subject + " slides onto " + core});
  }
  return out;
}

}  // namespace gelenk

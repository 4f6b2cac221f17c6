// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/touch_outputs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mechanism/mechanism.h"

namespace gelenk {

TouchOutputs::TouchOutputs(const Mechanism& mechanism, Dynamics& dynamics, TouchEquations& touch, std::size_t contacts)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      touch_(touch),
      finder_(mechanism, contacts),
      sums_(contacts),
      wrenches_(mechanism.links.size()),
      kept_(touch.modes()),
      open_(kept_.size()) {
  forces_.reserve(kept_.size());
}

void TouchOutputs::record(const Eigen::VectorXd* distributed) {
  std::ranges::fill(sums_, ContactSum{});
  std::ranges::fill(wrenches_, Spatial::Force{});
  forces_.clear();
  const auto& forces = distributed == nullptr ? touch_.forces() : touch_.forces_of(*distributed);
  add_wrenches(touch_, forces, wrenches_);
  audit_ = {};
  double slack = least_audited_force;
  for (const auto& force : forces) slack += audited_fraction * std::abs(force.normal);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const TouchEquations::Entry& entry = touch_.rows().entries[i];
    add_to_audit(entry, forces[i], slack);
    const Spot& spot = touch_.spots()[entry.spot];
    forces_.push_back(
        {spot.contact, spot.core, spot.tip, entry.at.p, forces[i].force, forces[i].moment, forces[i].normal});
    ContactSum& sum = sums_[static_cast<std::size_t>(spot.contact)];
    sum.force -= spot.sign * (mechanism_.X_W0.R * forces[i].force);
    const SpotMode& mode = touch_.modes()[static_cast<std::size_t>(entry.spot)];
    const bool slides = mode.groups[0].moves || !(touch_.coefficient(entry.spot, 0, false) > 0);
    sum.mode = std::max(sum.mode, slides ? 2 : 1);
  }
}

void TouchOutputs::add_to_audit(const TouchEquations::Entry& entry, const TouchEquations::SpotForce& force,
                                double slack) {
  const int contact = touch_.spots()[entry.spot].contact;
  audit_.add(-force.normal / slack, {BrokenLaw::Kind::contact_pulls, contact, force.normal});
  for (int group = 0; group < contact_groups; ++group) {
    const auto g = static_cast<std::size_t>(group);
    if (entry.rows[g] < 0) continue;
    const double permitted = touch_.coefficient(entry.spot, group, false) * std::max(0.0, force.normal);
    const auto kind = group == 0 ? BrokenLaw::Kind::contact_friction : BrokenLaw::Kind::contact_moment;
    audit_.add((force.held[g] - permitted) / (audited_fraction * permitted + slack),
               {kind, contact, force.held[g], permitted});
  }
}

bool TouchOutputs::any_overlap(const double* q) {
  dynamics_.set_position(q);
  dynamics_.readings().set_root_poses();
  for (std::size_t contact = 0; contact < sums_.size(); ++contact) {
    if (gap(static_cast<int>(contact)) < -least_overlap) return true;
  }
  return false;
}

double TouchOutputs::gap(int contact) {
  touch_.spots().read_position(dynamics_);
  double out = std::numeric_limits<double>::infinity();
  for (int i = 0; i < touch_.spots().count(); ++i) {
    const Spot& spot = touch_.spots()[i];
    if (spot.contact != contact) continue;
    // Features that are apart sideways have no gap.
    if (spot.kind == Spot::Kind::corner || spot.kind == Spot::Kind::edges)
      return finder_.smallest_gaps(dynamics_.readings())[static_cast<std::size_t>(contact)];
    out = std::min(out, touch_.spots().gap(i));
  }
  return out;
}

std::vector<std::array<std::string, 2>> TouchOutputs::event_texts(const std::vector<std::string>& bodies,
                                                                  const std::vector<std::string>& contacts) const {
  const auto name = [&](int shape) {
    const int body = mechanism_.shapes[static_cast<std::size_t>(shape)].scene_body;
    return body < 0 ? std::string("the ground") : bodies[static_cast<std::size_t>(body)];
  };
  std::vector<std::array<std::string, 2>> out;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    const Spot& spot = touch_.spots()[i];
    const std::string subject = contacts[static_cast<std::size_t>(spot.contact)] + ": " + name(spot.tip);
    const std::string core = name(spot.core);
    out.push_back({subject + " leaves " + core, subject + " touches " + core});
    out.push_back({subject + " stops sliding on " + core, subject + " slides on " + core});
    out.push_back({subject + " stops spinning on " + core, subject + " spins on " + core});
    out.push_back({subject + " stops rolling on " + core, subject + " rolls on " + core});
    out.push_back({subject + " slides off an edge of " + core, subject + " slides onto " + core});
  }
  return out;
}

}  // namespace gelenk

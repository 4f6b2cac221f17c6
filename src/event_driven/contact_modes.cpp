// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/contact_modes.h"

#include <algorithm>

#include "kinematics/loads.h"
#include "nonsmooth/rounding.h"

namespace gelenk {
namespace {

using Eigen::Map;
using Eigen::VectorXd;

// A normal force or a force of friction beyond its bound by less than this fraction of the normal forces is rounding.
constexpr double force_rounding = 1e-11;
// Gaps beyond the held mode by less than this are rounding.
constexpr double watched_depth = touch_tolerance;

}  // namespace

ContactModes::ContactModes(const Context& context)
    : mechanism_(context.mechanism),
      dynamics_(context.dynamics),
      equations_(context.equations),
      contact_equations_(context.mechanism, context.dynamics, context.loads.contacts, context.located),
      hidden_(context.mechanism, context.dynamics, contact_equations_),
      outputs_(context.mechanism, context.dynamics, contact_equations_, context.loads.contacts.size()),
      sliding_steps_(contact_equations_, dynamics_),
      vdot_(static_cast<std::size_t>(context.mechanism.nv)) {
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    const ContactCandidate& candidate = contact_equations_.candidates()[i];
    if (candidate.kind != ContactCandidate::Kind::corner && candidate.kind != ContactCandidate::Kind::edges) continue;
    if (std::ranges::find(guards_, candidate.contact, &Guard::contact) == guards_.end())
      guards_.push_back({.contact = candidate.contact, .candidate = i});
  }
}

double ContactModes::slow(const double* v) const {
  return rest_speed * fastest_of({v, static_cast<std::size_t>(mechanism_.nv)});
}

void ContactModes::go_to(const double* y) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + mechanism_.nq);
  if (any()) contact_equations_.candidates().read_motion(dynamics_);
}

void ContactModes::begin_step(const double* y) {
  go_to(y);
  hidden_.begin();
}

void ContactModes::start() {
  contact_equations_.set_modes(std::vector<CandidateMode>(contact_equations_.modes().size()));
  for (Guard& guard : guards_) guard.least = INFINITY;
  overlapping_ = -1;
}

void ContactModes::indicator_values(double t, const double* y, double* g, double* gdot) {
  const int n = contact_equations_.candidates().count();
  if (n == 0) return;
  std::fill_n(g, per_candidate * n, -1.0);
  std::fill_n(gdot, per_candidate * n, 0.0);
  if (!contact_equations_.closed().empty()) {
    equations_.accelerations_at(t, y, vdot_.data());
    indicators_of_closed(vdot_.data(), g, gdot);
  }
  go_to(y);
  for (int i = 0; i < n; ++i) {
    if (mode_of(i).closed || contact_equations_.candidates()[i].is_given()) continue;
    const auto first = static_cast<std::size_t>(per_candidate) * static_cast<std::size_t>(i);
    g[first] = -contact_equations_.candidates()[i].size;
    if (!contact_equations_.candidates().is_close(i)) {
      if (!contact_equations_.candidates().shows_distance(i)) continue;
      g[first] = -contact_equations_.candidates().distance(i, gdot[first]);
      gdot[first] = -gdot[first];
      continue;
    }
    if (!contact_equations_.candidates().is_near(i)) continue;
    const CandidateState at = contact_equations_.candidates().state(i);
    g[first] = -at.gap - mode_of(i).leaves_from;
    gdot[first] = -at.rate;
  }
  find_penetration(g);
}

// Shows in the indicators g what penetrates although no feature touches. The position is that of `dynamics`.
void ContactModes::find_penetration(double* g) {
  for (const Guard& guard : guards_) {
    const bool any_closed = std::ranges::any_of(contact_equations_.closed(), [&](int candidate) {
      return contact_equations_.candidates()[candidate].contact == guard.contact;
    });
    if (any_closed || !(guard.allowed < INFINITY)) continue;
    const double depth = -outputs_.gap(guard.contact);
    double& value = g[static_cast<std::ptrdiff_t>(per_candidate) * guard.candidate];
    if (depth > guard.allowed) value = std::max(value, depth);
  }
}

double ContactModes::longest_step(double t, const double* y, const EventSource::SlowSliding& by) {
  if (!sliding_steps_.any(by)) return INFINITY;
  equations_.accelerations_at(t, y, vdot_.data());  // with factors of this position
  return sliding_steps_.longest({vdot_.data(), vdot_.size()}, by);
}

void ContactModes::find_yielding(double* g, std::vector<double*>& out) const {
  for (const int candidate : contact_equations_.closed()) {
    double* const of = g + static_cast<std::ptrdiff_t>(per_candidate) * candidate;
    if (!(of[0] > 0)) out.push_back(of);
    for (std::size_t k = 0; k < contact_groups; ++k) {
      if (of[1 + k] > 0 && !mode_of(candidate).groups[k].moves) out.push_back(of + 1 + k);
    }
  }
}

void ContactModes::indicators_of_closed(const double* vdot, double* g, double* gdot) {
  const auto& forces = contact_equations_.forces();
  double sum = 0;
  for (const auto& force : forces) sum += std::abs(force.normal);
  const double slack = force_rounding * sum;
  const Map<const VectorXd> a(vdot, mechanism_.nv);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const ContactEquations::Entry& entry = contact_equations_.rows().entries[i];
    double* const of = g + static_cast<std::ptrdiff_t>(per_candidate) * entry.candidate;
    double* const rate = gdot + static_cast<std::ptrdiff_t>(per_candidate) * entry.candidate;
    of[0] = entry.is_given ? 1 : forces[i].normal + slack;
    of[per_candidate - 1] = contact_equations_.candidates().margin(entry.candidate) + touch_tolerance;
    rate[0] = rate[per_candidate - 1] = NAN;
    for (int group = 0; group < contact_groups; ++group) {
      const auto at = static_cast<std::size_t>(group);
      const CandidateMode::Group& mode = mode_of(entry.candidate).groups[at];
      if (entry.rows[at] < 0 && !mode.moves) continue;
      rate[1 + group] = NAN;
      if (entry.rows[at] < 0 && entry.moving[at] < 0) {
        of[1 + group] = 1;  // its friction has been set to 0 in motion
        continue;
      }
      if (!mode.moves) {
        of[1 + group] = forces[i].held[at] -
                        contact_equations_.coefficient(entry.candidate, group, false) * forces[i].normal - slack;
        continue;
      }
      // Where the direction turns, this rate is that of the speed.
      const int row = entry.moving[at];
      const double cosine = entry.along[at].dot(mode.direction);
      of[1 + group] = entry.slip[at].dot(mode.direction);
      rate[1 + group] =
          cosine * (contact_equations_.rows().S.row(row).dot(a) + contact_equations_.rows().moving_rates[row]);
    }
  }
}

void ContactModes::remembered_mode(bool* positive) const {
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    const CandidateMode& mode = mode_of(i);
    bool* const of = positive + static_cast<std::ptrdiff_t>(per_candidate) * i;
    of[0] = of[per_candidate - 1] = mode.closed;
    for (std::size_t k = 0; k < contact_groups; ++k) of[1 + k] = mode.closed && mode.groups[k].moves;
  }
}

bool ContactModes::any_penetrates() {
  if (!any()) return false;
  contact_equations_.candidates().read_position(dynamics_);
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    if (!contact_equations_.candidates().is_close(i) || mode_of(i).closed) continue;
    if (contact_equations_.candidates().gap(i) < -watched_depth - mode_of(i).leaves_from &&
        contact_equations_.candidates().is_near(i))
      return true;
  }
  return false;
}

bool ContactModes::may_touch(int candidate) const {
  return contact_equations_.candidates().is_close(candidate) &&
         contact_equations_.candidates().gap(candidate) <= touch_tolerance &&
         contact_equations_.candidates().is_near(candidate);
}

bool ContactModes::update(const double* y) {
  if (!any()) return false;
  const double rest = slow(y + mechanism_.nq);
  std::vector<CandidateMode>& next = updated_;
  next = contact_equations_.modes();
  go_to(y);
  bool touches = false;
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    CandidateMode& mode = next[static_cast<std::size_t>(i)];
    if (mode.closed) continue;
    if (!may_touch(i)) {
      mode.leaves_from = 0;
      continue;
    }
    const CandidateState at = contact_equations_.candidates().state(i);
    touches = touches || (mode.leaves_from == 0 && at.gap <= reached_fraction * touch_tolerance && at.rate < -rest);
  }
  const auto slides = [](const CandidateMode& mode) {
    return mode.closed && std::ranges::any_of(mode.groups, &CandidateMode::Group::moves);
  };
  if (std::ranges::any_of(next, slides)) {
    contact_equations_.build(contact_equations_.closed(), contact_equations_.modes(), true, updated_rows_);
    for (const ContactEquations::Entry& entry : updated_rows_.entries) {
      for (std::size_t k = 0; k < contact_groups; ++k) {
        CandidateMode::Group& group = next[static_cast<std::size_t>(entry.candidate)].groups[k];
        const double speed = entry.slip[k].norm();
        if (group.moves && speed > rest) group.direction = entry.slip[k] / speed;
      }
    }
  }
  contact_equations_.set_modes(next);
  update_guards();
  hidden_.begin();
  return touches;
}

bool ContactModes::any_slips(const double* y) {
  if (contact_equations_.closed().empty()) return false;
  const double rest = slow(y + mechanism_.nq);
  go_to(y);
  contact_equations_.build(contact_equations_.closed(), contact_equations_.modes(), true, updated_rows_);
  return std::ranges::any_of(updated_rows_.entries, [&](const ContactEquations::Entry& entry) {
    const CandidateMode& mode = mode_of(entry.candidate);
    for (std::size_t k = 0; k < contact_groups; ++k) {
      if (!mode.groups[k].moves && entry.slip[k].norm() > rest) return true;
    }
    return false;
  });
}

void ContactModes::update_guards() {
  for (Guard& guard : guards_) {
    const double depth = std::max(0.0, -outputs_.gap(guard.contact));
    guard.allowed = depth + watched_depth;
    guard.least = std::min(guard.least, depth);
    if (depth > guard.least + ContactOutputs::least_overlap) overlapping_ = guard.candidate;
  }
}

void ContactModes::serialize(Archive& archive) {
  std::vector<CandidateMode>& modes = updated_;  // steps allocate no memory
  modes = contact_equations_.modes();
  for (CandidateMode& mode : modes) {
    archive.serialize(mode.closed, mode.leaves_from);
    for (CandidateMode::Group& group : mode.groups) {
      archive.serialize(group.moves, group.direction.x(), group.direction.y(), group.direction.z());
    }
  }
  for (Guard& guard : guards_) archive.serialize(guard.allowed, guard.least);
  if (!archive.reading()) return;
  contact_equations_.set_modes(modes);
  contact_equations_.forget_differences();
  overlapping_ = -1;
}

}  // namespace gelenk

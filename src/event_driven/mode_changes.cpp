// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/mode_changes.h"

#include <algorithm>
#include <utility>

#include "kinematics/loads.h"

namespace gelenk {
namespace {

// Of what is let go and comes to rest again at the same instant.
constexpr int most_returns = 20;
// Of a load: 0: negative; 1: positive.
constexpr int unknown_sign = 2;

}  // namespace

ModeChanges::ModeChanges(const Context& context)
    : mechanism_(context.mechanism),
      dynamics_(context.dynamics),
      equations_(context.equations),
      log_(context.log),
      first_indicator_(context.first_indicator),
      contacts_(context.contacts),
      contact_equations_(context.contacts.equations()),
      joints_(context.joints),
      joint_impacts_(context.joints),
      latches_(context.joints),
      order_(context.contacts, joint_impacts_, context.first_indicator),
      decisions_({context.mechanism, context.dynamics, context.equations, context.joints, context.contacts}),
      triggered_(contact_equations_.modes().size()),
      vdot_(static_cast<std::size_t>(context.mechanism.nv)),
      before_(vdot_.size()),
      unstopped_(vdot_.size()),
      checked_(static_cast<std::size_t>(context.contacts.indicators())),
      checked_rates_(checked_.size()),
      expected_(std::make_unique<bool[]>(checked_.size())) {}

void ModeChanges::start(double t, const double* y) {
  started_ = true;
  jumped_ = false;
  refusal_.clear();
  std::ranges::fill(load_signs_, unknown_sign);
  if (!joints_.empty()) start_joints(t, y, false);
}

void ModeChanges::start_joints(double t, const double* y, bool keeps_latches) {
  joints_.begin_run(keeps_latches);
  latches_.set(t, y, true);
  decide(t, y, Recording::nothing, ModeDecisions::Asked::joints);
  equations_.mode_changed();
}

void ModeChanges::restart(double t, double* y, const LockModes::State& before, double estimated_over) {
  if (joints_.empty()) return;
  joints_.stop_unmoved(y, before, estimated_over);
  start_joints(t, y, true);
  if (joints_.any_wrong_speed(y)) {
    equations_.accelerations_at(t, y, vdot_.data());
    joints_.stop(y);
  }
  joints_.forget_events();
  joints_.record_changes(t, before);
}

bool ModeChanges::is_contact_doubtful(double t, const double* y) {
  return contacts_.any() && (started_ || (jumped_ && !is_consistent(t, y)));
}

bool ModeChanges::recall(double t, double* y) {
  if (joints_.empty() && !contacts_.any()) return false;
  const bool touches = contacts_.update(y);
  if (const int candidate = contacts_.overlapping(); candidate >= 0) {
    const std::string event = log_.report({t, first_indicator_ + ContactModes::per_candidate * candidate, true}).text;
    refusal_ = event.substr(0, event.rfind(": ")) +
               ": shapes overlap, but where they came into contact was not found: use a smaller tolerance or "
               "communication step, or the integrator auto, which can change to time steps where no state needs events";
  }
  const bool jumped = jumped_;
  static_cast<void>(joints_.find_events_at_start(t, y));
  latches_.find_events(t, y, jumped || started_);
  const bool by_joints = joints_.is_triggered();
  const bool by_contacts = touches || is_contact_doubtful(t, y);
  bool changed = by_joints || by_contacts;
  const bool determines = changed || joints_.are_doubtful(t, y, jumped);
  if (determines) {
    std::copy_n(y + mechanism_.nq, before_.size(), before_.begin());
    determine(t, y);
    changed = changed || contacts_.any() || !std::equal(before_.begin(), before_.end(), y + mechanism_.nq);
    if (contacts_.any()) contacts_.begin_step(y);
  } else if (started_ && joints_.any_wrong_speed(y)) {
    equations_.accelerations_at(t, y, vdot_.data());  // with factors of this position
    joints_.stop(y);
    changed = true;
  }
  if (dynamics_.switching_forces().loads().signed_count() > 0) {
    changed = seize(t, y, determines || jumped || started_) || changed;
  }
  started_ = jumped_ = false;
  return changed;
}

void ModeChanges::preview(double t, const double* y) {
  latches_.set(t, y, jumped_ || started_);
  const bool asks_joints = jumped_ || contact_equations_.closed().empty();
  if (!is_contact_doubtful(t, y) && !(asks_joints && joints_.are_doubtful(t, y, true))) return;
  joints_.begin_change();
  decide(t, y, Recording::nothing);
}

// Whether the present modes of contacts obey the laws at (t, y).
bool ModeChanges::is_consistent(double t, const double* y) {
  std::vector<double>& g = checked_;
  contacts_.remembered_mode(expected_.get());
  contacts_.indicator_values(t, y, g.data(), checked_rates_.data());
  redistribute(t, y, nullptr, g.data());
  constexpr int per_candidate = ContactModes::per_candidate;
  for (const int candidate : contact_equations_.closed()) {
    for (int k = 0; k < per_candidate; ++k) {
      const std::size_t i =
          static_cast<std::size_t>(per_candidate) * static_cast<std::size_t>(candidate) + static_cast<std::size_t>(k);
      if ((g[i] > 0) != expected_[i]) return false;
    }
  }
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    if (!contacts_.mode_of(i).closed && contacts_.may_touch(i)) return false;
  }
  return !contacts_.any_slips(y);
}

void ModeChanges::found_contact_event(int indicator, bool positive) {
  constexpr int per_candidate = ContactModes::per_candidate;
  Trigger& trigger = triggered_[static_cast<std::size_t>(indicator / per_candidate)];
  const int which = indicator % per_candidate;
  if (which == per_candidate - 1) {
    trigger.ends = true;
  } else if (which > 0) {
    trigger.groups[static_cast<std::size_t>(which - 1)] = true;
  } else {
    (positive ? trigger.touches : trigger.leaves) = true;
  }
}

void ModeChanges::change(double t, double* y) {
  dynamics_.set_position(y);
  joints_.forget_rebounds(y);
  if (!joints_.is_triggered() && std::ranges::none_of(triggered_, &Trigger::any)) return;
  determine(t, y);
  if (dynamics_.switching_forces().loads().signed_count() > 0) seize(t, y, true);
}

// Impulses, and the modes that follow.
void ModeChanges::determine(double t, double* y) {
  const std::vector<CandidateMode> before = contact_equations_.modes();
  const LockModes::State joints_before = joints_.state();
  struck_acceleration_ = 0;
  joints_.begin_change();
  latches_.switch_found();
  const bool breaks_away = joints_.breaks_away();
  strike(t, y, {}, joints_before);
  if (!decide_or_seize(t, y) && breaks_away) joints_.force_away();
  refuse_ends(t);
  finish(y);
  stop_returning(t, y, joints_before);
  joints_.record_changes(t, joints_before);
  record_contact_changes(t, before);
}

// Brings joints that are returning to rest; their impulses may let go what has come to rest before. What contacts throw
// off so slowly is decided on with the accelerations (lasting), and closing it may set joints in motion.
void ModeChanges::stop_returning(double t, double* y, const LockModes::State& before) {
  std::vector<int> stopped;
  for (int attempt = 0; attempt < most_returns; ++attempt) {
    const std::vector<int> returning = joints_.find_returning(t, y, before, stopped);
    if (!joints_.have_turned(y) && returning.empty()) return;
    if (!returning.empty()) strike(t, y, returning, before);
    decide(t, y, Recording::doubts);
    finish(y);
  }
}

// Cylinders on their flat ends have no points of contact that remain when they tilt.
void ModeChanges::refuse_ends(double t) {
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    if (contact_equations_.candidates()[i].kind != ContactCandidate::Kind::rim) continue;
    const bool touches = contacts_.mode_of(i).closed || contact_equations_.candidates().gap(i) <= touch_tolerance;
    const bool ends = triggered_[static_cast<std::size_t>(i)].ends || contact_equations_.candidates().margin(i) <= 0;
    if (!touches || !ends) continue;
    refusal_ = log_.report({t, first_indicator_ + ContactModes::per_candidate * i, true}).text +
               " with a flat end, whose contacts are not located: use the integrator moreau-jean";
  }
}

// Whether the loads of meshes in the last solution have other signs than at the last call, or are not known.
bool ModeChanges::load_signs_changed() {
  LoadDependence& loads = dynamics_.switching_forces().loads();
  const auto count = static_cast<std::size_t>(loads.signed_count());
  load_indicators_.resize(count);
  load_signs_.resize(count, unknown_sign);
  loads.indicators(load_indicators_.data());
  bool changed = false;
  for (std::size_t i = 0; i < count; ++i) {
    const int sign = load_indicators_[i] > 0 ? 1 : 0;
    changed = changed || sign != load_signs_[i];
    load_signs_[i] = sign;
  }
  return changed;
}

// Where friction of a mesh in motion depends so much on its load that no motion agrees with it, as where a load
// decelerates a self-locking gear, the load rises without limit, and the motion stops at once: an impact without a
// collision (Painleve 1895; Le Suan An 1990). The impulses that stop it agree with the law of the mesh. Otherwise than
// when loads change their signs, it does so only where it is doubtful. Returns whether there is such a friction.
bool ModeChanges::seize(double t, double* y, bool is_doubtful) {
  // Not those of the last solution, which may be of another state: a restored one, or one within the last step.
  equations_.accelerations_at(t, y, vdot_.data());
  if (!load_signs_changed() && !is_doubtful) return false;
  const int force = dynamics_.switching_forces().loads().seized();
  if (force < 0) return false;
  const LockModes::State before = joints_.state();
  struck_acceleration_ = 0;
  strike(t, y, {joints_.stop_friction(force)}, before);
  decide(t, y, Recording::doubts);
  finish(y);
  joints_.record_changes(t, before);
  return true;
}

// The modes that follow at (t, y). What moves keeps moving; on what is at rest accelerations decide. Returns whether
// they are others.
bool ModeChanges::decide(double t, const double* y, Recording records, ModeDecisions::Asked asked) {
  ModeDecisions::Modes next = decisions_.decide(t, y, asked, triggered_);
  dynamics_.set_position(y);
  if (asked == ModeDecisions::Asked::joints) return decisions_.joints().enter(t, std::move(next.joints), records);
  return enter(t, std::move(next), records);
}

// The same after an impact. A mesh in motion may seize together with a bound that has just been reached: no modes agree
// while it moves, since each load of the bound makes friction press the joint on against it.
bool ModeChanges::decide_or_seize(double t, double* y) {
  ModeDecisions::Modes next = decisions_.decide(t, y, ModeDecisions::Asked::all, triggered_);
  dynamics_.set_position(y);
  const int force = decisions_.seizing(t, y);
  if (force < 0) return enter(t, std::move(next), Recording::doubts);
  strike(t, y, {joints_.stop_friction(force)}, joints_.state());
  return decide(t, y, Recording::doubts);
}

bool ModeChanges::enter(double t, ModeDecisions::Modes next, Recording records) {
  const bool changed = decisions_.joints().enter(t, std::move(next.joints), records);
  if (records != Recording::nothing) record_doubt(t);
  return enter_contacts(std::move(next.contacts), records) || changed;
}

// Records what the last decision did not find.
void ModeChanges::record_doubt(double t) {
  if (decisions_.outcome() == ContactDecision::Outcome::found) return;
  const int indicator = first_indicator_ + ContactModes::per_candidate * decisions_.decided_candidate();
  ++counts_.ambiguous;
  log_.add({t, indicator, true, true});
  if (decisions_.outcome() != ContactDecision::Outcome::none) return;
  refusal_ = log_.report({t, indicator, true}).text +
             ", and no contact forces were found that agree with Coulomb's law (as in Painlev\u00e9's paradox)";
}

bool ModeChanges::enter_contacts(std::vector<CandidateMode> next, Recording records) {
  const bool changed = differ(contact_equations_.modes(), next);
  for (CandidateMode& after : next) {
    if (after.closed) after.leaves_from = 0;
    if (!after.closed) after.groups = {};
  }
  const bool are_others = next != contact_equations_.modes();
  contact_equations_.set_modes(next);
  if (are_others && records != Recording::nothing) equations_.mode_changed();
  return changed;
}

// Records how the modes differ from those before.
void ModeChanges::record_contact_changes(double t, const std::vector<CandidateMode>& modes_before) {
  for (std::size_t i = 0; i < modes_before.size(); ++i) {
    const CandidateMode& before = modes_before[i];
    const CandidateMode& after = contact_equations_.modes()[i];
    const int first = first_indicator_ + ContactModes::per_candidate * static_cast<int>(i);
    if (before.closed && !after.closed) log_.add({t, first, false});
    if (!before.closed || !after.closed) continue;
    for (int k = 0; k < contact_groups; ++k) {
      const auto group = static_cast<std::size_t>(k);
      const bool reverses = after.groups[group].moves && before.groups[group].moves &&
                            after.groups[group].direction.dot(before.groups[group].direction) < 0;
      if (reverses || after.groups[group].moves != before.groups[group].moves)
        log_.add({t, first + 1 + k, after.groups[group].moves});
    }
  }
}

void ModeChanges::serialize(Archive& archive) {
  if (joints_.empty() && !contacts_.any()) return;
  archive.serialize(started_, jumped_, counts_.impacts, counts_.closed_series, counts_.ambiguous);
  load_signs_.resize(static_cast<std::size_t>(dynamics_.switching_forces().loads().signed_count()), unknown_sign);
  for (int& sign : load_signs_) archive.serialize_in_range(sign, 0, unknown_sign);
  if (!archive.reading()) return;
  std::ranges::fill(triggered_, Trigger{});  // a step may have been given up between an event and what follows
  refusal_.clear();
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/event_modes.h"

#include <algorithm>

#include "event_driven/contact_modes.h"
#include "event_driven/mode_changes.h"
#include "kinematics/force_modes.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {

namespace {

// Number of places at which modes are looked at within a step, at least: of conditions of expressions alone; and of
// what is held, for each natural unit of time in which loads may come and go.
constexpr int condition_places = 8;
constexpr double held_places = 8;
constexpr double fewest_held_places = 8, most_held_places = 64;
// Where nothing moves, no error bounds the length of a step: unless it is short, at least so many.
constexpr double resting_places = 24;
constexpr double short_step = 0.05;    // natural units
constexpr int most_jumps = 20;         // of states and modes that cause each other at one instant
constexpr double still_speed = 1e-10;  // natural units

}  // namespace

// Conditions of expressions alone, which take no solution of the equations.
class EventModes::KinkProbe final : public ModeProbe {
 public:
  explicit KinkProbe(EventModes& of) : of_(of) {}
  std::size_t count() const override { return static_cast<std::size_t>(of_.kinks_.count()); }
  void distances(double t, const double* y, double* out) override {
    of_.equations_.bring_inputs(t, y);
    of_.dynamics_.set_position(y);
    of_.dynamics_.set_velocity(y + of_.nq_);
    of_.kinks_.distances(out);
  }
  bool is_beyond(const double*) override { return of_.kinks_.are_passed(); }

 private:
  EventModes& of_;
};

// All indicators of joints and expressions, and those of closed contacts.
class EventModes::HeldProbe final : public ModeProbe {
 public:
  explicit HeldProbe(EventModes& of) : of_(of) {}
  std::size_t count() const override { return of_.held_positive_.size(); }
  void distances(double t, const double* y, double* out) override {
    of_.indicator_values(t, y, out, of_.probed_rates_.data());
    const auto own = static_cast<std::size_t>(of_.smooth_indicators());
    constexpr std::size_t each = ContactModes::per_candidate;
    for (std::size_t i = 0; i < count(); ++i) {
      const bool is_judged = i < own || (of_.nothing_moves_ && of_.held_positive_[i - (i - own) % each] != 0);
      out[i] = !is_judged ? 1 : of_.held_positive_[i] != 0 ? out[i] : -out[i];
    }
  }
  bool is_beyond(const double* distances) override {
    return std::any_of(distances, distances + count(), [](double d) { return d < -probe_rounding; });
  }

 private:
  static constexpr double probe_rounding = 1e-9;  // of forces and speeds that rest at the end of their mode

  EventModes& of_;
};

EventModes::EventModes(const Context& context)
    : dynamics_(context.dynamics),
      forces_(context.dynamics.switching_forces()),
      kinks_(dynamics_.kinks()),
      loads_(context.loads),
      equations_(context.equations),
      reads_time_(reads_time(loads_)),
      has_breaks_(gelenk::has_breaks(loads_) || equations_.has_breaks()),
      nq_(context.mechanism.nq),
      nv_(context.mechanism.nv),
      log_(context.log),
      sides_(static_cast<std::size_t>(forces_.count()), mode_of_state),
      present_sides_(sides_.size()),
      g_(2 * sides_.size()),
      gdot_(g_.size()),
      rates_(static_cast<std::size_t>(nq_ + context.mechanism.nv + context.loads.states())),
      locks_(context.equations, dynamics_, nq_, context.mechanism.nv, log_, sides_),
      resets_(loads_, dynamics_, equations_, nq_, nv_),
      outputs_(dynamics_, locks_, sides_),
      contacts_(std::make_unique<ContactModes>(ContactModes::Context{context.mechanism, dynamics_, context.loads,
                                                                     context.equations, context.locates_contacts})),
      changes_(std::make_unique<ModeChanges>(ModeChanges::Context{context.mechanism, dynamics_, context.equations, log_,
                                                                  locks_, *contacts_, own_indicators()})),
      held_positive_(static_cast<std::size_t>(indicators())),
      probed_(held_positive_.size()),
      probed_rates_(held_positive_.size()),
      kink_probe_(std::make_unique<KinkProbe>(*this)),
      mode_probe_(std::make_unique<HeldProbe>(*this)),
      hidden_changes_(std::make_unique<HiddenChanges>(dynamics_, equations_, static_cast<int>(rates_.size()),
                                                      held_positive_.size())) {}

EventModes::~EventModes() = default;

int EventModes::contact_indicators() const { return contacts_->indicators(); }

double EventModes::touch_within(double t0, const double* y0, double t1, const double* y1) {
  return std::min(contacts_->touch_within(t0, y0, t1, y1), hidden_change(t0, y0, t1, y1));
}

// Whether something at rest or closed is loaded by what depends on the time, other than by the motion.
bool EventModes::may_hide_changes() const {
  const bool holds =
      locks_.any_at_rest() || is_latch(any_force) || (nothing_moves_ && !contacts_->equations().closed().empty());
  return holds && (equations_.loads_move() || reads_time_);
}

double EventModes::hidden_change(double t0, const double* y0, double t1, const double* y1) {
  if (!held_) return INFINITY;
  // What moves in contact is bounded by errors, and its forces may be near the ends of their modes in every step.
  const auto at_rest = [&](const double* y) {
    return std::all_of(y + nq_, y + nq_ + nv_, [](double v) { return std::abs(v) < still_speed; });
  };
  nothing_moves_ = at_rest(y0) && at_rest(y1);
  const bool looks_at_all = may_hide_changes();
  if (!looks_at_all && !kinks_.read_time()) return INFINITY;
  ModeProbe& probe = looks_at_all ? *mode_probe_ : *kink_probe_;
  const bool may_be_long = nothing_moves_ && t1 - t0 > short_step;
  const double least = may_be_long ? resting_places : fewest_held_places;
  const double held = std::clamp(std::ceil(held_places * (t1 - t0)), least, most_held_places);
  const int fewest = looks_at_all ? static_cast<int>(held) : condition_places;
  const double out = hidden_changes_->first(probe, fewest, t0, y0, t1, y1);
  static_cast<void>(equations_.bring_inputs(t1, y1));
  if (looks_at_all) {
    indicator_values(t1, y1, probed_.data(), probed_rates_.data());
  } else {
    dynamics_.set_position(y1);
    dynamics_.set_velocity(y1 + nq_);
  }
  return out;
}

double EventModes::next_break(double t) { return std::min(equations_.next_break(t), gelenk::next_break(loads_, t)); }

void EventModes::pass_break() { changes_->inputs_jumped(); }

void EventModes::keep_directions_below(double speed) { contacts_->equations().keep_directions_below(speed); }

double EventModes::longest_step(double t, const double* y, const SlowSliding& by) {
  if (!contacts_->any()) return INFINITY;
  return contacts_->longest_step(t, y, by);
}

void EventModes::indicator_values(double t, const double* y, double* g, double* gdot) {
  const double* vdot = locks_.accelerations(t, y);
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  locks_.indicators(vdot, g, gdot);
  if (kinks_.count() > 0) {
    equations_.bring_inputs(t, y);
    kinks_.indicators(vdot, g + switching_indicators(), gdot + switching_indicators());
  }
  forces_.loads().indicators(g + own_indicators());
  std::fill_n(gdot + own_indicators(), forces_.loads().signed_count(), NAN);
  if (!contacts_->any()) return;
  const int first = smooth_indicators();
  contacts_->indicator_values(t, y, g + first, gdot + first);
  changes_->redistribute(t, y, g, g + first);
}

void EventModes::start(double t, const double* y) {
  resets_.start(t, y);
  contacts_->start();
  changes_->start(t, y);
}

void EventModes::release() {
  contacts_->start();
  if (!locks_.empty()) locks_.release();
}

bool EventModes::recall_mode(double t, double* y) {
  bool changed = changes_->recall(t, y);
  for (int round = 0; resets_.apply(t, y); ++round) {
    changed = true;
    if (round == most_jumps) resets_.refuse_repetition();
    if (!resets_.refusal().empty()) break;
    changes_->inputs_jumped();  // on which modes depend
    changes_->recall(t, y);
  }
  return changed;
}

void EventModes::change_mode(double t, double* y) {
  hold_mode(t, nullptr);  // stops and signs of loads follow from the state, at which the others are decided on
  changes_->change(t, y);
  // On velocities after impacts; modes follow where the next step begins.
  if (resets_.apply(t, y)) changes_->inputs_jumped();
}

EventModes::Present EventModes::present(double t, const double* y, FrictionTreatment friction) {
  if (locks_.empty() && !contacts_->any()) return {};
  const ModePreview preview(*this, t, y);
  Present out;
  if (!locks_.empty()) out.boundary = locks_.treat(friction, t, y);
  if (contacts_->any()) out.contacts = contacts_->held(friction);
  if (friction == FrictionTreatment::present && out.boundary < 0) out.edge = contacts_->edge(t, y);
  if (!locks_.empty()) out.sides = sides_;
  return out;
}

void EventModes::remembered_mode(bool* positive) const {
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    if (!locks_.owns(static_cast<int>(i))) continue;
    positive[2 * i] = sides_[i] == 1;
    positive[2 * i + 1] = sides_[i] == -1;
  }
  contacts_->remembered_mode(positive + smooth_indicators());
}

void EventModes::hold_mode(double t, const bool* positive) {
  held_ = positive != nullptr;
  if (held_) std::copy_n(positive, held_positive_.size(), held_positive_.begin());
  held_from_ = t;
  mode_exit_time_ = INFINITY;
  left_by_forces_.has = false;
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    if (locks_.owns(static_cast<int>(i))) continue;
    sides_[i] = !held_ ? mode_of_state : positive[2 * i] ? 1 : positive[2 * i + 1] ? -1 : 0;
  }
  forces_.hold(held_ || !locks_.empty() ? sides_.data() : nullptr);
  kinks_.hold(held_ ? positive + switching_indicators() : nullptr);
  forces_.loads().hold_signs(held_ ? positive + own_indicators() : nullptr);
}

void EventModes::check(double t, const double* v) {
  dynamics_.set_velocity(v);
  if ((!locks_.all_at_rest() && is_in_other_mode(v)) || contacts_->any_penetrates()) leave_at(t);
}

void EventModes::leave_at(double t) {
  mode_exit_time_ = t;
  left_by_forces_.has = false;
}

bool EventModes::is_in_other_mode(const double* v) {
  forces_.sides(present_sides_.data());
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    if (locks_.keeps_mode(static_cast<int>(i), v)) present_sides_[i] = sides_[i];
  }
  return present_sides_ != sides_ && is_outside();
}

bool EventModes::are_overloaded() const {
  const bool any = locks_.are_overloaded() || contacts_->equations().are_overloaded();
  return any && changes_->are_forces_unique();
}

// At the boundary of the mode a state belongs to either side, as rounding decides.
bool EventModes::is_outside() {
  locks_.indicators(nullptr, g_.data(), gdot_.data());
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (present_sides_[i / 2] == sides_[i / 2]) continue;
    const bool held = sides_[i / 2] == (i % 2 == 0 ? 1 : -1);
    if (held ? g_[i] < 0 : g_[i] > 0) return true;
  }
  return false;
}

bool EventModes::is_latch(int force) const {
  for (int i = 0; i < forces_.locks(); ++i) {
    if (const int latch = forces_.lock(i).latch; latch >= 0 && (latch == force || force == any_force)) return true;
  }
  return false;
}

std::string EventModes::refusal() const {
  if (const int limit = locks_.state().unstoppable; limit >= 0) {
    return log_.report({0, limit, true}).text +
           ", where no force can stop it: closed loops or prescribed motions determine its motion" +
           (is_latch(limit / 2) ? "" : ", which leads beyond");
  }
  if (const std::string& why = changes_->refusal(); !why.empty()) return why;
  if (!resets_.refusal().empty()) return std::string(resets_.refusal());
  return log_.too_many();
}

std::string EventModes::indeterminacy() const {
  const int friction = forces_.loads().undetermined();
  if (friction < 0) return {};
  const std::string text = log_.report({0, 2 * friction, true}).text;
  return "the friction of " + text.substr(0, text.find(" slips")) +
         " depends so much on the load of its bearing, guide or gear that no motion, or more than one, agrees with it";
}

void EventModes::found_event(double t, int indicator, bool positive) {
  if (indicator >= smooth_indicators()) {
    changes_->found_contact_event(indicator - smooth_indicators(), positive);
  } else if (indicator >= switching_indicators() ? indicator < own_indicators() : !locks_.found_event(indicator)) {
    log_.add({t, indicator, positive});
  }  // where the load of friction changes its sign, no mode changes
}

bool EventModes::drift(double t, double* y, double dt) {
  if (!contacts_->equations().closed().empty()) return false;  // friction turns within a step
  equations_.rates_at(t, y, rates_.data());
  for (std::size_t k = 0; k < rates_.size(); ++k) y[k] += dt * rates_[k];
  dynamics_.normalize(y);
  return true;
}

bool EventModes::is_of_impact(int indicator) const {
  if (indicator < switching_indicators()) return locks_.is_of_limit(indicator);
  return indicator >= smooth_indicators() &&
         (indicator - smooth_indicators()) % ContactModes::per_candidate == ContactModes::closed_indicator;
}

bool EventModes::rates(double t, const double* y, double* ydot) {
  equations_.rates_at(t, y, ydot);
  return true;
}

void EventModes::serialize(Archive& archive) {
  resets_.serialize(archive);
  locks_.serialize(archive);
  contacts_->serialize(archive);
  changes_->serialize(archive);
}

ModePreview::ModePreview(EventModes& modes, double t, const double* y) : modes_(modes) {
  if (!modes_.locks().empty()) modes_.locks().keep_state();
  if (modes_.contacts().any()) modes_.contacts().outputs().keep_modes();
  if (!modes_.locks().empty() || modes_.contacts().any()) modes_.changes().preview(t, y);
}

ModePreview::~ModePreview() {
  if (modes_.contacts().any()) modes_.contacts().outputs().return_to_modes();
  if (!modes_.locks().empty()) modes_.locks().return_to_state();
}

}  // namespace gelenk

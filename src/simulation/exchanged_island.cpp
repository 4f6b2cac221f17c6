// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/exchanged_island.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace gelenk {
namespace {

// The longest part of the way from where the step began, along which Newton's method remains on the branch [rad,
// natural units of length]; and limit on their number.
constexpr double longest_stride = 0.1;
constexpr int most_strides = 1000;
// Deviation of the squared norm of a quaternion from 1 beyond which an event normalizes it. The equations use the
// normalized one in any case.
constexpr double norm_tolerance = 1e-6;
// Relative to times: a break as near as this is there.
constexpr double shortest_stretch = 1e-14;

}  // namespace

ExchangedIsland::ExchangedIsland(Island& of, std::vector<Slot> slots, const Independent& independent)
    : island_(of),
      slots_(std::move(slots)),
      nq_(of.mechanism().nq),
      nv_(of.mechanism().nv),
      course_(of.equations_->modes()),
      base_(of.y_),
      target_(of.y_),
      before_(of.y_),
      ydot_(of.y_.size()),
      modes_(course_.size()),
      change_(nv_),
      base_time_(of.time_) {
  of.equations_->revolutions().keep();
  if (of.mechanism().rows == 0) return;
  dependent_ = std::make_unique<DependentCoordinates>(of.mechanism(), *of.dynamics_, independent.coordinates,
                                                      independent.speeds);
  dependent_->set_base(base_.data());
}

bool ExchangedIsland::go_to(double t, const double* x) {
  Formulation& equations = *island_.equations_;
  double* const y = island_.y_.data();
  island_.time_ = t;
  island_.forget_outputs();
  has_jumped_ = false;
  equations.revolutions().return_to_kept();
  set_target(x);
  equations.drives().go_to(t, target_.data());
  if (dependent_ == nullptr) {
    island_.y_ = target_;
    island_.dynamics_->normalize(y);
  } else if (!close(y)) {
    return false;
  }
  equations.modes().locks().clear_rest(y + nq_);
  return true;
}

// The states, and the dependent coordinates and velocities where the step began.
void ExchangedIsland::set_target(const double* x) {
  target_ = base_;
  for (const Slot& slot : slots_) target_[static_cast<std::size_t>(slot.entry)] = x[slot.state] / slot.size;
}

// y <- the states at this part of the way from where the step began; dependent coordinates and velocities remain.
void ExchangedIsland::put(double part, double* y) const {
  for (const Slot& slot : slots_) {
    const auto k = static_cast<std::size_t>(slot.entry);
    y[k] = part == 1 ? target_[k] : base_[k] + part * (target_[k] - base_[k]);
  }
}

bool ExchangedIsland::close(double* y) {
  const double dt = island_.time_ - base_time_;
  find_change();
  dependent_->follow(dt, change_);
  const double farthest = change_.size() == 0 ? 0 : change_.cwiseAbs().maxCoeff();
  is_too_far_ = !(farthest <= most_strides * longest_stride);
  if (is_too_far_) return false;
  const int strides = static_cast<int>(std::ceil(farthest / longest_stride));
  std::copy(target_.begin() + nq_, target_.end(), y + nq_);
  if (strides <= 1) {
    dependent_->displace_base(change_, y);
    put(1, y);
    return dependent_->close(y);
  }
  std::copy_n(base_.begin(), nq_, y);
  Drives& drives = island_.equations_->drives();
  bool closed = true;
  for (int stride = 1; closed && stride <= strides; ++stride) {
    const double part = static_cast<double>(stride) / strides;
    if (island_.mechanism().driven()) drives.go_to(base_time_ + part * dt, target_.data());
    put(part, y);
    closed = dependent_->close(y);
  }
  drives.go_to(island_.time_, target_.data());
  return closed;
}

// The displacements of the independent coordinates since the step began.
void ExchangedIsland::find_change() {
  change_.setZero();
  for (const Slot& slot : slots_) {
    if (slot.speed < 0) continue;
    const auto k = static_cast<std::size_t>(slot.entry);
    if (!slot.begins_quaternion) {
      change_[slot.speed] = target_[k] - base_[k];
    } else {
      const Eigen::Map<const Eigen::Quaterniond> from(base_.data() + k);
      const Eigen::Map<const Eigen::Quaterniond> to(target_.data() + k);
      change_.segment<3>(slot.speed) = 2 * (from.conjugate() * to).vec();
    }
  }
}

int ExchangedIsland::blocked_state() {
  if (dependent_ == nullptr) return -1;
  if (dependent_->blocked() < 0) dependent_->find_blocked_at_base();
  for (const Slot& slot : slots_) {
    if (slot.entry == nq_ + dependent_->blocked()) return static_cast<int>(slot.state);
  }
  return -1;
}

void ExchangedIsland::count_turns() {
  if (island_.mechanism().cuts.empty()) return;
  RevolutionCounter& turns = island_.equations_->revolutions();
  turns.return_to_kept();
  turns.count(island_.time_, island_.y_.data());
}

// Before the first event modes are those of the start.
void ExchangedIsland::evaluate() {
  Formulation& equations = *island_.equations_;
  const double* const y = island_.y_.data();
  std::optional<HeldMode> held;
  if (is_begun_) held.emplace(equations.modes(), base_time_, course_.mode());
  if (!equations.rhs(island_.time_, y, ydot_.data()))
    refuse(equations, island_.time_, y, "the accelerations are not finite");
}

void ExchangedIsland::rates(double* xdot) {
  evaluate();
  island_.equations_->modes().locks().clear_rest(ydot_.data() + nq_);
  for (const Slot& slot : slots_) xdot[slot.state] = slot.size * ydot_[static_cast<std::size_t>(slot.entry)];
}

void ExchangedIsland::end_course() {
  std::optional<HeldMode> held;
  if (is_begun_) held.emplace(island_.equations_->modes(), base_time_, course_.mode());
  course_.end(island_.time_, island_.y_.data());
}

void ExchangedIsland::indicator_values(double* z) {
  if (course_.size() == 0) return;
  end_course();
  for (std::size_t i = 0; i < course_.size(); ++i) {
    const double g = course_.at_end(i);
    constexpr double smallest = std::numeric_limits<double>::min();
    z[i] = (g > 0) == course_.positive(i) ? g : course_.positive(i) ? smallest : -smallest;
  }
}

bool ExchangedIsland::needs_normalization() const {
  return std::ranges::any_of(slots_, [&](const Slot& slot) {
    if (!slot.begins_quaternion) return false;
    const Eigen::Map<const Eigen::Vector4d> Q(target_.data() + slot.entry);
    return !(std::abs(Q.squaredNorm() - 1) <= norm_tolerance);
  });
}

bool ExchangedIsland::complete_step() {
  if (course_.size() > 0) {
    end_course();
    if (course_.any_changed()) return true;
  }
  const bool normalizes = needs_normalization();
  before_ = island_.y_;
  std::copy_n(course_.mode(), modes_.size(), modes_.begin());
  accept();
  begin_step();
  has_jumped_ = before_ != island_.y_;
  return has_jumped_ || normalizes || !std::equal(modes_.begin(), modes_.end(), course_.mode());
}

void ExchangedIsland::accept() {
  Formulation& equations = *island_.equations_;
  equations.revolutions().return_to_kept();
  equations.accepted(island_.time_, island_.y_.data());
}

// Whether inputs or numbers of the loads have jumped since the last event.
bool ExchangedIsland::take_jump() {
  const bool jumped = island_.inputs_jumped_ && island_.equations_->drives().inputs().jumped();
  const bool out = jumped || island_.loads_changed_;
  island_.inputs_jumped_ = island_.loads_changed_ = false;
  return out;
}

// At the present state, as the locator begins one.
void ExchangedIsland::begin_step() {
  const double t = island_.time_;
  EventSource& modes = island_.equations_->modes();
  if (modes.has_breaks()) {
    stretch_end_ = modes.next_break(t + shortest_stretch * std::abs(t));
    modes.begin_stretch(t, stretch_end_);
  }
  if (course_.size() > 0) course_.begin(t, island_.y_.data());
  if (const std::string why = modes.refusal(); !why.empty()) throw RefusedMotion(at_time(t) + why);
  base_ = island_.y_;
  base_time_ = t;
  island_.equations_->revolutions().keep();
  if (dependent_) dependent_->set_base(base_.data());
}

bool ExchangedIsland::pass_event(double* x) {
  const double t = island_.time_;
  Formulation& equations = *island_.equations_;
  EventSource& modes = equations.modes();
  double* const y = island_.y_.data();
  if (!has_jumped_) before_ = island_.y_;
  island_.events_.begin(t);
  island_.events_.begin_part();
  if (is_begun_ && !has_jumped_ && course_.size() > 0) {
    end_course();
    for (std::size_t i = 0; i < course_.size(); ++i) {
      if (course_.changed(i)) modes.found_event(t, static_cast<int>(i), course_.positive(i));
    }
    if (course_.any_changed()) modes.change_mode(t, y);
  }
  if (t >= stretch_end_ - shortest_stretch * std::abs(t)) {
    modes.begin_stretch(NAN, NAN);
    modes.pass_break();
  }
  if (is_begun_) accept();
  if (take_jump()) equations.inputs_changed(t, y);
  const bool normalizes = needs_normalization();
  begin_step();
  is_begun_ = true;
  has_jumped_ = false;
  return write_jumps(normalizes, x);
}

// Of the states that have changed since before_.
bool ExchangedIsland::write_jumps(bool normalizes, double* x) {
  bool any = false;
  int of_quaternion = 0;  // components that follow
  for (const Slot& slot : slots_) {
    const auto k = static_cast<std::size_t>(slot.entry);
    if (slot.begins_quaternion) of_quaternion = 4;
    const bool has_changed = island_.y_[k] != before_[k] || (normalizes && of_quaternion > 0);
    --of_quaternion;
    if (!has_changed) continue;
    x[slot.state] = slot.size * island_.y_[k];
    any = true;
  }
  island_.forget_outputs();
  return any;
}

void ExchangedIsland::serialize(Archive& archive) {
  course_.serialize(archive);
  archive.serialize(base_, base_time_, stretch_end_, is_begun_, has_jumped_, before_);
  island_.equations_->revolutions().serialize_kept(archive);
  if (dependent_) dependent_->serialize(archive);
}

void ExchangedIsland::continue_from_base() {
  EventSource& modes = island_.equations_->modes();
  if (modes.has_breaks() && is_begun_) modes.begin_stretch(base_time_, stretch_end_);
  if (dependent_) dependent_->set_base(base_.data());
}

}  // namespace gelenk

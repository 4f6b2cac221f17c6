// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/impulse_steps.h"

#include <algorithm>
#include <cmath>

#include "kinematics/loads.h"

namespace gelenk {
namespace {

// Displacements by which accelerations are differentiated [rad, natural units of length]: large against their rounding,
// small against what changes stiffness.
constexpr double small_displacement = 1e-6;
// Iterations for the fastest vibration, which end where its frequency changes by no more than this part.
constexpr int vibration_iterations = 12;
constexpr double vibration_tolerance = 0.02;
constexpr double slow = 1;  // rad^2/s^2: slower vibrations limit no steps
// Energies and other outputs contain products of two numbers of the state, of two components of a force, and a mass.
constexpr double largest_number = 1e120;

}  // namespace

void ImpulseSteps::use(ImpulseAccuracy accuracy) {
  stepper_ = std::make_unique<TimeStepper>(with_.mechanism, with_.dynamics, with_.loads, accuracy);
  applied_ = stepper_->state().wrenches;
  if (!with_.locks.empty()) with_.locks.release();
  const auto nv = static_cast<std::size_t>(with_.mechanism.nv);
  for (std::vector<double>* of : {&displacement_, &rest_, &at_rest_}) of->assign(nv, 0.0);
  displaced_.resize(static_cast<std::size_t>(with_.mechanism.nq));
  const int states = with_.loads.states();
  size_ = with_.mechanism.nq + with_.mechanism.nv + states;
  if (states > 0) states_ = std::make_unique<StateSteps>(with_.dynamics, with_.drives, states);
  vibration_.resize(nv);
  for (std::size_t k = 0; k < nv; ++k) vibration_[k] = 1 + 0.3 * static_cast<double>(k) / static_cast<double>(nv);
}

// Finds them by a trial step.
void ImpulseSteps::start(double t, double h, const double* y) {
  trial_.assign(y, y + size_);
  stepper_->forget();
  step(t, h, trial_.data());
  stepper_->forget_motion();
}

bool ImpulseSteps::step(double t, double h, double* y) {
  const auto finite = [&] { return std::all_of(y, y + size_, [](double x) { return std::abs(x) < largest_number; }); };
  if (!finite()) return false;
  with_.drives.go_to(t + h / 2);
  if (states_ && !begin_states(h, y)) return false;
  const bool made = stepper_->step(h, with_.drives.u().data(), y) && (!states_ || finish_states(h, y));
  const ContactState& state = stepper_->state();
  return made && finite() && std::ranges::all_of(state.sums, [](const ContactSum& sum) {
           return sum.force.squaredNorm() < largest_number * largest_number;
         });
}

// The states in the middle of the step at the position and velocity of its start, which is enough for forces.
bool ImpulseSteps::begin_states(double h, const double* y) {
  const double* const v = y + with_.mechanism.nq;
  with_.dynamics.set_position(y);
  with_.dynamics.set_velocity(v);
  // The middle position and the former velocities, for finish_states().
  std::copy_n(y, displaced_.size(), displaced_.data());
  for (std::size_t k = 0; k < displacement_.size(); ++k) displacement_[k] = h / 2 * v[k];
  with_.dynamics.displace(displaced_.data(), displacement_.data());
  std::copy_n(v, at_rest_.size(), at_rest_.data());
  return states_->predict_middle(v + with_.mechanism.nv, h);
}

// Their step at the middle position and the mean velocity.
bool ImpulseSteps::finish_states(double h, double* y) {
  double* const v = y + with_.mechanism.nq;
  for (std::size_t k = 0; k < at_rest_.size(); ++k) at_rest_[k] = (at_rest_[k] + v[k]) / 2;
  with_.dynamics.set_position(displaced_.data());
  with_.dynamics.set_velocity(at_rest_.data());
  return states_->advance(v + with_.mechanism.nv, h);
}

// displacement_ <- the accelerations at rest at y, displaced by x times small_displacement, minus at_rest_, divided by
// it; returns its length, which is NaN if they are not finite.
double ImpulseSteps::change_of_accelerations(const double* y, const std::vector<double>& x) {
  std::copy_n(y, displaced_.size(), displaced_.data());
  for (std::size_t k = 0; k < x.size(); ++k) displacement_[k] = small_displacement * x[k];
  with_.dynamics.displace(displaced_.data(), displacement_.data());
  with_.dynamics.set_position(displaced_.data());
  with_.dynamics.factorize();
  with_.dynamics.set_velocity(rest_.data());
  with_.dynamics.solve(with_.drives.u().data(), displacement_.data());
  double sum = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    displacement_[k] = (displacement_[k] - at_rest_[k]) / small_displacement;
    sum += displacement_[k] * displacement_[k];
  }
  return std::sqrt(sum);
}

// Power iteration: accelerations change by -omega^2 x where the position changes by a mode x. It is made at rest, since
// what changes with velocities, such as centrifugal forces, does not make these steps unstable.
double ImpulseSteps::highest_frequency(double t, const double* y) {
  with_.drives.go_to(t, y);
  std::ranges::fill(at_rest_, 0.0);
  std::ranges::fill(displaced_, 0.0);
  change_of_accelerations(y, rest_);
  for (std::size_t k = 0; k < at_rest_.size(); ++k) at_rest_[k] = small_displacement * displacement_[k];
  double square = 0;
  for (int i = 0; i < vibration_iterations; ++i) {
    double length = 0;
    for (const double x : vibration_) length += x * x;
    length = std::sqrt(length);
    if (!(length > 0 && std::isfinite(length))) break;
    for (double& x : vibration_) x /= length;
    const double before = square;
    square = change_of_accelerations(y, vibration_);
    vibration_.swap(displacement_);
    if (square < slow || std::abs(square - before) < vibration_tolerance * square) break;
  }
  if (square > 0 && std::isfinite(square)) return std::sqrt(square);
  std::ranges::fill(vibration_, 1.0);
  return 0;
}

void ImpulseSteps::serialize(Archive& archive) {
  if (!are_available()) return;
  stepper_->serialize(archive);
  archive.serialize(vibration_);
}

ImpulseSteps::AppliedForces::AppliedForces(ImpulseSteps& steps, const double* y)
    : rows_(steps.with_.dynamics.switching_forces().contact_rows()) {
  const ContactState& state = steps.stepper_->state();
  if (steps.are_required()) {
    steps.with_.dynamics.set_position(y);
    StateReadings& readings = steps.with_.dynamics.readings();
    readings.set_root_poses();
    steps.applied_ = state.wrenches;  // of the same size, so that nothing is allocated
    for (std::size_t i = 0; i < steps.applied_.size(); ++i) {
      Spatial::Force& wrench = steps.applied_[i];
      if (!wrench.f.isZero(0)) wrench.n += readings.link_pose(static_cast<int>(i)).p.cross(wrench.f);
    }
  }
  rows_.apply_forces(steps.are_required() ? steps.applied_.data() : nullptr, state.along.data());
}

ImpulseSteps::AppliedForces::~AppliedForces() { rows_.apply_forces(nullptr, nullptr); }

}  // namespace gelenk

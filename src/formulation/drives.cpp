// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/drives.h"

#include <algorithm>
#include <span>

namespace gelenk {

Drives::Drives(const Mechanism& mechanism, Dynamics& dynamics, Inputs& inputs, const Loads& loads)
    : dynamics_(dynamics),
      inputs_(inputs),
      targets_(mechanism, loads),
      rows_(mechanism.coordinate_rows.size()),
      coordinates_(mechanism.nq),
      states_(loads.states()),
      first_(mechanism.nq + mechanism.nv),
      named_(loads.named.size()),
      targets_follow_states_(states_ > 0 && loads.motions_follow_signals()),
      signals_(states_ == 0 ? 0 : static_cast<std::size_t>(count())),
      others_(signals_) {}

void Drives::go_to(double t) {
  inputs_.go_to(t);
  if (states_ > 0) std::ranges::copy(inputs_.now(), signals_.begin());
  if (!targets_.none()) dynamics_.set_targets(targets_.at(t, inputs_, u().data()));
}

void Drives::go_to(double t, const double* y) {
  set_states(y + first_);
  go_to(t);
}

const std::vector<double>& Drives::u(const Inputs& others) {
  if (states_ == 0) return others.now();
  others_ = signals_;
  std::ranges::copy(others.now(), others_.begin());
  return others_;
}

void Drives::go_to_outputs(double t, const double* y) {
  inputs_.go_to(t);
  if (states_ > 0) std::ranges::copy(inputs_.now(), signals_.begin());
  set_states(y + first_);
  if (targets_.none()) return;
  dynamics_.set_targets(is_at_end_of_step_ ? targets_.at(t, inputs_, u().data())
                                           : targets_.as_read(t, inputs_, u().data()));
}

bool Drives::bring_signals(const double* y) {
  const double* signals = u().data();
  if (named_ > 0) {
    dynamics_.set_position(y);
    dynamics_.set_velocity(y + coordinates_);
    signals = dynamics_.readings().all_signals(signals);
  }
  const std::span<double> inputs = dynamics_.switching_forces().inputs();
  std::copy_n(signals, std::min(u().size() + named_, inputs.size()), inputs.begin());
  return inputs_.moving() || states_ > 0 || named_ > 0;
}

void Drives::targets_at(double t, std::vector<double>& out) {
  out.clear();
  const double* s = targets_.at(t, inputs_, u().data());
  for (std::size_t i = 0; i < rows_; ++i) out.insert(out.end(), {s[3 * i], s[3 * i + 1]});
}

}  // namespace gelenk

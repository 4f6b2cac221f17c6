// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/drives.h"

namespace gelenk {

Drives::Drives(const Mechanism& mechanism, Dynamics& dynamics, Inputs& inputs)
    : dynamics_(dynamics), inputs_(inputs), targets_(mechanism), rows_(mechanism.coordinate_rows.size()) {}

void Drives::go_to(double t) {
  inputs_.go_to(t);
  if (!targets_.none()) dynamics_.set_targets(targets_.at(t, inputs_));
}

void Drives::go_to_outputs(double t) {
  inputs_.go_to(t);
  if (targets_.none()) return;
  dynamics_.set_targets(is_at_end_of_step_ ? targets_.at(t, inputs_) : targets_.as_read(t, inputs_));
}

void Drives::targets_at(double t, std::vector<double>& out) {
  out.clear();
  const double* s = targets_.at(t, inputs_);
  for (std::size_t i = 0; i < rows_; ++i) out.insert(out.end(), {s[3 * i], s[3 * i + 1]});
}

}  // namespace gelenk

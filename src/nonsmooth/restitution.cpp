// SPDX-License-Identifier: BSD-3-Clause
#include "nonsmooth/restitution.h"

#include <algorithm>
#include <cstddef>

namespace gelenk {

bool Restitution::needs_compression() const {
  return std::ranges::any_of(struck_, [](const Struck& at) { return at.poisson && at.restitution > 0; });
}

void Restitution::add_demands(double* b) const {
  for (const Struck& at : struck_) {
    if (!at.poisson) b[at.row] -= at.part * at.restitution * at.sign * at.approach;
  }
}

void Restitution::set_least_impulses(const double* compression, double* least) const {
  for (const Struck& at : struck_) {
    if (at.poisson) least[at.row] = (1 + at.part * at.restitution) * compression[at.row];
  }
}

}  // namespace gelenk

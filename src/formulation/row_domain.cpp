// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/row_domain.h"

#include <algorithm>

#include "mechanism/mechanism.h"
#include "scene/element_numbers.h"

namespace gelenk {

RowDomain::RowDomain(const Mechanism& mechanism, const Dynamics& dynamics)
    : mechanism_(mechanism), dynamics_(dynamics) {
  for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
    if (can_be_undefined(*mechanism.cuts[c].joint)) cuts_.push_back(c);
  }
}

bool RowDomain::is_defined() const {
  return std::ranges::none_of(cuts_,
                              [&](int c) { return is_undefined(*mechanism_.cuts[c].joint, dynamics_.cut_pose(c)); });
}

std::string RowDomain::undefined_reason() const {
  for (const int c : cuts_) {
    const Cut& cut = mechanism_.cuts[c];
    const std::string_view found = near_undefined(*cut.joint, dynamics_.cut_pose(c));
    if (!found.empty()) {
      return filled_in(
          found, {.name = {}, .frames = {{mechanism_.links[cut.link_b].name, {}}}, .joints = {}, .coordinate = {}}, {});
    }
  }
  return {};
}

}  // namespace gelenk

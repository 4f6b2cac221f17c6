// SPDX-License-Identifier: BSD-3-Clause
#include "scene/quantity_groups.h"

#include <algorithm>

namespace gelenk {

std::vector<QuantityGroup> groups(std::span<const Quantity> quantities) {
  std::vector<QuantityGroup> out;
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const std::string_view name = quantities[i].name;
    const std::size_t bracket = name.find('[');
    const std::string base(name.substr(0, bracket));
    const bool array = bracket != std::string_view::npos;
    if (array && !out.empty() && out.back().name == base) {
      ++out.back().size;
      continue;
    }
    const std::string_view unit = quantities[i].unit == "1" ? std::string_view() : quantities[i].unit;
    out.push_back({base, std::string(unit), std::string(quantities[i].description), i, 1, array});
  }
  return out;
}

std::string start_parameter(const std::string& joint, std::string_view quantity) {
  const std::size_t bracket = std::min(quantity.find('['), quantity.size());
  return joint + "." + std::string(quantity.substr(0, bracket)) + "_start" + std::string(quantity.substr(bracket));
}

JointStart free_start(const JointKind& kind) {
  JointStart start;
  start.q.assign(kind.q_zero.begin(), kind.q_zero.end());
  start.v.assign(static_cast<std::size_t>(kind.nv), 0.0);
  start.q_given.assign(start.q.size(), false);
  start.v_given.assign(start.v.size(), false);
  start.q_fixed = start.q_given;
  start.v_fixed = start.v_given;
  start.q_weight.assign(start.q.size(), default_start_weight);
  start.v_weight.assign(start.v.size(), default_start_weight);
  return start;
}

}  // namespace gelenk

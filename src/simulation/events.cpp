// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "simulation/simulation_impl.h"

namespace gelenk {

std::vector<EventReport> Simulation::events() const {
  std::vector<EventReport> out;
  for (const auto& island : impl_->islands) {
    const EventLog& log = island->events();
    for (const Event& event : log.events()) {
      out.insert(std::ranges::upper_bound(out, event.time, {}, &EventReport::time), log.report(event));
    }
  }
  return out;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "simulation/simulation_impl.h"
#include "util/text.h"

namespace gelenk {
namespace {

std::string describe_jump(const Signal& input, double size) {
  return input.name + " has jumped by " + text::rounded(size) + " " + input.unit +
         ": the motion that it prescribes was displaced without passing through the positions between, so that dampers "
         "and friction do not feel it. Let it change gradually, or set its derivatives";
}

}  // namespace

std::vector<EventReport> Simulation::events(bool only_doubtful) const {
  std::vector<EventReport> out;
  const auto add = [&out](EventReport report) {
    out.insert(std::ranges::upper_bound(out, report.time, {}, &EventReport::time), std::move(report));
  };
  impl_->u.each_jump([&](int input, const MotionSamples::Jump& jump) {
    const auto i = static_cast<std::size_t>(input);
    add({jump.time, describe_jump(impl_->inputs[i], jump.size * impl_->input_size[i]), true});
  });
  for (const auto& island : impl_->islands) {
    const EventLog& log = island->events();
    for (const Event& event : log.events()) {
      if (!only_doubtful || event.is_ambiguous || event.indicator == Event::singular_position) add(log.report(event));
    }
  }
  return out;
}

}  // namespace gelenk

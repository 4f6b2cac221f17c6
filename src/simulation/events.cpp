// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "preparation/law_report.h"
#include "simulation/simulation_impl.h"
#include "simulation/stepping_report.h"
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
  for (std::size_t i = 0; i < impl_->inputs.size(); ++i) {
    const MotionSamples::Jump jump = impl_->u.jump(static_cast<int>(i));
    // The jump of a speed is an impact, which is what it means.
    if (jump.size == 0 || impl_->inputs[i].stage != Stage::position) continue;
    add({jump.time, describe_jump(impl_->inputs[i], jump.size * impl_->input_size[i]), true});
  }
  for (const auto& island : impl_->islands) {
    const EventLog& log = island->events();
    for (const Event& event : log.events()) {
      if (!only_doubtful || event.is_doubtful()) add(log.report(event));
    }
    for (const SharedLoadEvent& shared : log.shared_loads())
      add({shared.time, describe_shared_load(impl_->scene, island->loads(), shared.contact, shared.force), true});
    for (const SchemeChange& change : log.scheme_changes())
      add(EventLog::report(change, impl_->scene.units.size_of("m")));
  }
  return out;
}

std::vector<std::string> SteppingReport::warnings() const {
  std::vector<std::string> out;
  for (const auto& island : impl_.islands) {
    const std::vector<EventReport> uncertain = island->events().uncertain();
    for (const EventReport& event : uncertain) out.push_back("t = " + text::rounded(event.time) + " s: " + event.text);
    const auto shared_loads = island->events().all_shared_loads();
    for (const SharedLoadEvent& of : shared_loads)
      out.push_back("t = " + text::rounded(of.time) +
                    " s: " + describe_shared_load(impl_.scene, island->loads(), of.contact, of.force));
    const long more = island->events().uncertain_count() + island->events().shared_count() -
                      static_cast<long>(uncertain.size() + shared_loads.size());
    if (more > 0) out.push_back(std::to_string(more) + " more events have an uncertain outcome");
    if (island->integrator() == nullptr) continue;
    const Integrator::SteppedTime of = island->integrator()->stepped_time();
    if (of.parts == 0) continue;
    std::string line =
        "time steps with impulses from t = " + text::rounded(of.from) + " s to " + text::rounded(of.to) + " s";
    if (of.parts > 1)
      line += ", in " + std::to_string(of.parts) + " parts of " + text::rounded(of.time) + " s together";
    line += ", with an estimated error of " + error_text(of.error, impl_.scene.units.size_of("m"));
    out.push_back(line + ": " + text_of(of.cause));
  }
  return out;
}

}  // namespace gelenk

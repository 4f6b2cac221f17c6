// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/step.h"

#include "fmu/api_call.h"

namespace gelenk {

Status do_step(void* instance, const char* function, CommunicationStep step, std::initializer_list<Place> places,
               StepResult& result) noexcept {
  return call(instance, function, Plant::Kind::co_simulation, between_steps, [&](Instance& of) {
    const auto report = [&](bool is_early) {
      result = {.is_early = is_early, .is_futile = of.stuck(), .time_reached = of.plant().time()};
    };
    expect_places(places);
    try {
      of.step(step.start, step.size);
      report(false);
    } catch (const StepBudgetError& cause) {
      report(of.interface().may_return_early);
      if (!of.interface().may_return_early) throw;
      warn(of, function, cause.what());
    } catch (const StepError&) {
      report(false);
      throw;
    }
    return Status::ok;
  });
}

}  // namespace gelenk

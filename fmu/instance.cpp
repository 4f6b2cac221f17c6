// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/instance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "preparation/report.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr double no_stop = std::numeric_limits<double>::infinity();

std::string seconds(double t) { return "t = " + text::number(t) + " s"; }

}  // namespace

std::string describe(Mode mode, const Vocabulary& of) {
  switch (mode) {
    case Mode::instantiated:
      return std::string("before ") + of.enter_initialization;
    case Mode::initialization:
      return "in initialization mode";
    case Mode::step_complete:
      return "after initialization";
    case Mode::step_failed:
      return "after a discarded step";
    case Mode::terminated:
      return std::string("after ") + of.terminate;
    case Mode::event:
      return "in event mode";
    case Mode::continuous_time:
      return "in continuous-time mode";
    case Mode::configuration:
      return "in configuration mode";
    case Mode::error:
      break;
  }
  return "after an internal error of the FMU";
}

Instance::Instance(std::shared_ptr<const PlantModel> model, Log log, Plant::Kind kind, Interface interface)
    : model_(std::move(model)), interface_(interface), log_(std::move(log)), plant_(model_, kind), stop_(no_stop) {}

void Instance::setup_experiment(std::optional<double> tolerance, double start, std::optional<double> stop) {
  if (!std::isfinite(start))
    throw UsageError("start time: found " + text::number(start) + ", expected a finite number");
  if (tolerance && !(*tolerance > 0 && *tolerance < 1)) {
    throw UsageError("tolerance: found " + text::number(*tolerance) + ", expected a number between 0 and 1");
  }
  if (stop && !(*stop >= start)) {
    throw UsageError("stop time: found " + text::number(*stop) + " s, expected at least the start time " +
                     text::number(start) + " s");
  }
  plant_.set_experiment(start, tolerance.value_or(0));
  stop_ = stop.value_or(no_stop);
}

void Instance::enter_initialization() { enter(Mode::initialization); }

void Instance::exit_initialization() {
  plant_.assemble();
  clock_.start(plant_.time());
  const std::string report = plant_.assembly_report();
  if (!report.empty()) log_.write(Category::events, report);
  for (const std::string& warning : plant_.start_warnings()) log_.write(Category::warning, warning);
  memory_.emplace();
  enter(kind() == Plant::Kind::model_exchange ? Mode::event : Mode::step_complete);
}

void Instance::enter_continuous_time_mode() {
  if (!has_passed_events_)
    throw UsageError(std::string("called before ") + interface_.vocabulary.pass_event +
                     ", which finds the modes in which the motion continues");
  mode_ = Mode::continuous_time;
}

ModelExchange::Event Instance::pass_event() {
  const ModelExchange::Event event = plant_.exchange().pass_event();
  has_passed_events_ = true;
  log_events();
  return event;
}

void Instance::terminate() { enter(Mode::terminated); }

void Instance::reset() {
  plant_ = Plant(model_, plant_.kind());
  memory_.reset();
  clock_ = {};
  stop_ = no_stop;
  has_passed_events_ = false;
  enter(Mode::instantiated);
}

void Instance::step(double current, double h) {
  const StepMemory::InUse memory = use_step_memory();
  if (!std::isfinite(current)) {
    throw UsageError("communication point: found " + text::number(current) + ", expected a finite number");
  }
  if (!(std::isfinite(h) && h > 0)) {
    throw UsageError("communication step: found " + text::number(h) + " s, expected a positive, finite number");
  }
  if (!clock_.continues_at(current, h)) {
    throw UsageError("communication point: found " + seconds(current) + ", but the plant is at " +
                     seconds(clock_.end()) +
                     (current < clock_.end() ? " and cannot go back" : "; steps must be contiguous"));
  }
  if (current + h == current) {
    throw UsageError("communication step: found " + text::number(h) + " s, too small to change " + seconds(current));
  }
  // A millionth of a step allows for rounding by the master.
  if (current + h > stop_ + 1e-6 * h) {
    throw UsageError("communication step: found one to " + seconds(current + h) + ", beyond the stop time " +
                     text::number(stop_) + " s of " + interface_.vocabulary.stop_time);
  }
  Clock next = clock_;
  try {
    plant_.step_to(std::max(next.step(current, h), plant_.time()));
  } catch (const StepBudgetError&) {
    fail_step(false);
    throw;
  } catch (const StepError&) {
    fail_step(true);
    throw;
  }
  clock_ = next;
  mode_ = Mode::step_complete;
  log_events();
}

void Instance::log_events() {
  for (const EventReport& event : plant_.events(!log_.is_enabled(Category::events))) {
    log_.write(event.is_doubtful ? Category::warning : Category::events, describe_event(event));
  }
}

SavedState* Instance::save() {
  auto state = std::make_unique<SavedState>();
  write(state->archive);
  return adopt(std::move(state));
}

SavedState* Instance::adopt(std::unique_ptr<SavedState> state) {
  SavedState* adopted = state.get();
  states_.emplace(adopted, std::move(state));
  return adopted;
}

SavedState* Instance::find(const void* state) const {
  const auto found = states_.find(state);
  return found == states_.end() ? nullptr : found->second.get();
}

void Instance::restore(SavedState& state) {
  if (mode_ == Mode::error) plant_ = Plant(model_, plant_.kind());  // its members may be inconsistent
  if (state.own) return read(state.archive);
  Archive before;
  write(before);
  try {
    read(state.archive);
  } catch (...) {
    read(before);
    throw;
  }
  state.own = true;
}

void Instance::write(Archive& archive) {
  archive.start_writing();
  serialize(archive);
}

void Instance::read(Archive& archive) {
  archive.start_reading();
  serialize(archive);
  archive.finish();
}

// The mode is followed by the kind, as a summand: the same layout as without model exchange.
void Instance::serialize(Archive& archive) {
  constexpr int kinds = 16;
  const bool exchanges = kind() == Plant::Kind::model_exchange;
  int code = std::countr_zero(static_cast<unsigned>(mode_)) + (exchanges ? kinds : 0);
  archive.serialize_in_range(code, 0, kinds + std::countr_zero(static_cast<unsigned>(last_mode)));
  if ((code >= kinds) != exchanges) {
    throw std::invalid_argument(std::string("found a state of an instance for ") +
                                (exchanges ? "co-simulation, expected one for model exchange"
                                           : "model exchange, expected one for co-simulation"));
  }
  const auto mode = static_cast<Mode>(1U << static_cast<unsigned>(code % kinds));
  const unsigned others = exchanges ? between_steps : exchanging;
  if (mode == Mode::error || mode == Mode::configuration || (static_cast<unsigned>(mode) & others) != 0)
    throw std::invalid_argument("found a mode in which states cannot be saved");
  archive.serialize(stuck_, stop_);
  if (exchanges) archive.serialize(has_passed_events_);
  clock_.serialize(archive);
  plant_.serialize(archive);
  mode_ = mode;
}

void Instance::fail_step(bool stuck) {
  clock_.start(plant_.time());
  mode_ = Mode::step_failed;
  stuck_ = stuck;
}

void Instance::enter(Mode mode) {
  mode_ = mode;
  log_.write(Category::events, log_.instance_name() + " is now " + describe(mode, interface_.vocabulary));
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Instance: the implementation of an fmi2Component and an fmi3Instance, with its mode in the FMI state machine.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "fmu/clock.h"
#include "fmu/log.h"
#include "fmu/runtime/plant.h"
#include "fmu/saved_state.h"
#include "fmu/status.h"
#include "fmu/step_memory.h"

namespace gelenk {

// State machines of co-simulation, FMI 2.0, section 4.2.4, and of model exchange, section 3.2.3. Those of FMI 3.0 add
// the configuration mode. Bits, so that sets of modes can be formed.
enum class Mode : unsigned {
  instantiated = 1,
  initialization = 2,
  step_complete = 4,
  step_failed = 8,  // a step was discarded: the plant is at the time reached and can continue from there
  terminated = 16,
  error = 32,  // internal error: only reset and free are allowed
  event = 64,
  continuous_time = 128,
  configuration = 256,
};
inline constexpr Mode last_mode = Mode::configuration;
constexpr unsigned operator|(Mode a, Mode b) { return static_cast<unsigned>(a) | static_cast<unsigned>(b); }
constexpr unsigned operator|(unsigned a, Mode b) { return a | static_cast<unsigned>(b); }

inline constexpr unsigned between_steps = Mode::step_complete | Mode::step_failed;
inline constexpr unsigned exchanging = Mode::event | Mode::continuous_time;

// A phrase such as "in initialization mode", which completes "fmi2DoStep: called ...".
std::string describe(Mode mode, const Vocabulary& of);

class Instance {
 public:
  Instance(std::shared_ptr<const PlantModel> model, Log log, Plant::Kind kind, Interface interface);

  Mode mode() const { return mode_; }
  Plant::Kind kind() const { return plant_.kind(); }
  const Interface& interface() const { return interface_; }
  Log& log() { return log_; }
  Plant& plant() { return plant_; }

  // Transitions of the state machine; the caller has checked the mode. They throw what Plant throws.
  void setup_experiment(std::optional<double> tolerance, double start, std::optional<double> stop);
  void enter_initialization();
  void exit_initialization();
  // Of FMI 3.0: enters or leaves configuration mode. There are no structural parameters that it serves to set.
  void configure(bool on) { enter(on ? Mode::configuration : Mode::instantiated); }
  void terminate();
  void reset();
  // Of model exchange.
  void enter_event_mode() { mode_ = Mode::event; }
  void enter_continuous_time_mode();
  // Throws StepError; nothing is then changed.
  ModelExchange::Event pass_event();
  void fail() { mode_ = Mode::error; }

  // Serves this thread from the memory for steps, after initialization, for the lifetime of the result.
  StepMemory::InUse use_step_memory() const { return StepMemory::InUse(memory_ ? &*memory_ : nullptr); }
  // Advances from the master's time `current` by h > 0 [s]. Throws StepError (the mode is then step_failed) and
  // UsageError (no change).
  void step(double current, double h);
  // Whether the last step failed such that a retry can only succeed with other inputs.
  bool stuck() const { return mode_ == Mode::step_failed && stuck_; }

  // FMU states belong to the instance that created them and are freed with it.
  SavedState* save();
  void save(SavedState& state) { write(state.archive); }
  // Returns null for a state that does not belong to this instance.
  SavedState* find(const void* state) const;
  // Throws what Plant::serialize throws; the instance is then unchanged.
  void restore(SavedState& state);
  SavedState* adopt(std::unique_ptr<SavedState> state);
  void free(SavedState* state) { states_.erase(state); }

 private:
  void write(Archive& archive);
  void read(Archive& archive);
  void serialize(Archive& archive);
  void fail_step(bool stuck);
  void enter(Mode mode);
  void log_events();

  std::shared_ptr<const PlantModel> model_;
  Interface interface_;
  Log log_;
  std::optional<StepMemory> memory_;  // outlives what is in it
  Plant plant_;
  Clock clock_;
  Mode mode_ = Mode::instantiated;
  bool stuck_ = false;              // in mode step_failed: see stuck()
  bool has_passed_events_ = false;  // of model exchange: the one at the start
  double stop_;                     // stop time [s]; infinite: none given
  std::map<const void*, std::unique_ptr<SavedState>> states_;
};

}  // namespace gelenk

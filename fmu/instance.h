// SPDX-License-Identifier: BSD-3-Clause
// Instance: what stands behind an fmi2Component. Knows in which mode it is and what it has told the master.
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

namespace gelenk {

// FMI 2.0, section 4.2.4 (state machine of a slave); bits, so that calls can name the modes they are allowed in.
enum class Mode : unsigned {
  instantiated = 1,
  initialization = 2,
  step_complete = 4,
  step_failed = 8,  // a step was discarded: the plant stands at the time reached and can go on from there
  terminated = 16,
  error = 32,  // a fault of our own: only reset and free are left
};
constexpr unsigned operator|(Mode a, Mode b) { return static_cast<unsigned>(a) | static_cast<unsigned>(b); }
constexpr unsigned operator|(unsigned a, Mode b) { return a | static_cast<unsigned>(b); }

// "in initialization mode": completes "fmi2DoStep was called ...".
const char* words(Mode mode);

class Instance {
 public:
  Instance(std::shared_ptr<const PlantModel> model, Log log);

  Mode mode() const { return mode_; }
  Log& log() { return log_; }
  Plant& plant() { return plant_; }

  // The calls of the state machine; the caller has checked the mode. They throw what Plant throws.
  void setup_experiment(std::optional<double> tolerance, double start, std::optional<double> stop);
  void enter_initialization();
  void exit_initialization();
  void terminate();
  void reset();
  void fail() { mode_ = Mode::error; }

  // Advances by h > 0 from the master's time. Throws StepError (then in step_failed) and UsageError (no change).
  void step(double current, double h);
  // Whether the last step failed where trying again helps only with other inputs.
  bool stuck() const { return mode_ == Mode::step_failed && stuck_; }

  // FMU states belong to the instance that made them, and are gone with it.
  SavedState* save();
  void save(SavedState& over) { write(over.archive); }
  // Null: this is none of this instance's.
  SavedState* find(fmi2FMUstate state) const;
  // Throws what Plant::serialize throws, and stays as it was.
  void restore(SavedState& state);
  SavedState* adopt(std::unique_ptr<SavedState> state);
  void free(SavedState* state) { states_.erase(state); }

 private:
  void write(Archive& archive);
  void read(Archive& archive);
  void serialize(Archive& archive);
  void left_at_plant_time(bool stuck);
  void enter(Mode mode);

  std::shared_ptr<const PlantModel> model_;
  Log log_;
  Plant plant_;
  Clock clock_;
  Mode mode_ = Mode::instantiated;
  bool stuck_ = false;  // of step_failed: see stuck()
  double stop_;         // s; infinite: none given
  std::map<const void*, std::unique_ptr<SavedState>> states_;
};

}  // namespace gelenk

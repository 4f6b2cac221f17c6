// SPDX-License-Identifier: BSD-3-Clause
// The loop over the communication points of a run: sampled inputs are set, outputs are recorded.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <span>
#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

// An input that is constant during a run. `moves`: it is a prescribed motion, with time derivatives.
struct ConstantInput {
  int input = 0;
  double value = 0;
  bool moves = false;
};

// The inputs and outputs of a run, by their indices.
struct Channels {
  static constexpr int motion_columns = 5;  // value and time derivatives of orders 1 to 4

  std::vector<int> held;     // inputs that are held in a step: a column each in the table of sampled inputs
  std::vector<int> motions;  // inputs that follow a polynomial: then motion_columns each
  std::vector<ConstantInput> constants;
  std::vector<int> readings;  // outputs; diagnostic i is -1 - i

  std::size_t columns() const { return held.size() + motion_columns * motions.size(); }
};

// Where a leg of a run ends early: at a time of the clock, or when another thread asks for it.
struct Interruption {
  using Clock = std::chrono::steady_clock;

  Clock::time_point deadline = Clock::time_point::max();
  const std::atomic<bool>* stop = nullptr;

  bool is_due() const {
    return (stop != nullptr && stop->load(std::memory_order_relaxed)) ||
           (deadline != Clock::time_point::max() && Clock::now() >= deadline);
  }
};

// A table of numbers with any layout.
struct Rows {
  double* first = nullptr;
  std::ptrdiff_t row = 0, column = 0;  // strides

  double* at(std::size_t i) const { return first + static_cast<std::ptrdiff_t>(i) * row; }
};

// A leg of a run from times[0], the present time: step k ends at times[k + 1] and writes row k of `rows`.
struct Leg {
  std::span<const double> times;
  std::span<const double> inputs;  // a row of channels.columns() numbers for each step
  Rows rows;
  Interruption until;
};

// The steps that were completed, and the events in them.
struct Recorded {
  std::size_t steps = 0;
  std::vector<EventReport> events;
};

// Sets the inputs: those in a row of the table, and the constants.
void set_inputs(Simulation& simulation, const Channels& channels, std::span<const double> row);

// Writes the values of the readings, `stride` numbers apart.
void read_channels(Simulation& simulation, const Channels& channels, double* out, std::ptrdiff_t stride);

// Runs a leg. At least one step is made, so that repeated calls end. Throws what step_to() throws; `done` is then
// valid, too.
void run_leg(Simulation& simulation, const Channels& channels, const Leg& leg, Recorded& done);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "runs/trajectory.h"

#include <iterator>

namespace gelenk {

void set_inputs(Simulation& simulation, const Channels& channels, std::span<const double> row) {
  const double* value = row.data();
  for (const int input : channels.held) simulation.set_input(input, *value++);
  for (const int input : channels.motions) {
    simulation.set_input(input, *value++);
    for (int order = 1; order < Channels::motion_columns; ++order) {
      simulation.set_input_derivative(input, order, *value++);
    }
  }
  for (const ConstantInput& constant : channels.constants) {
    simulation.set_input(constant.input, constant.value);
    if (!constant.moves) continue;
    for (int order = 1; order < Channels::motion_columns; ++order) {
      simulation.set_input_derivative(constant.input, order, 0);
    }
  }
}

void read_channels(Simulation& simulation, const Channels& channels, double* out, std::ptrdiff_t stride) {
  for (const int reading : channels.readings) {
    *out = reading >= 0 ? simulation.output(reading) : simulation.diagnostic(-1 - reading);
    out += stride;
  }
}

void run_leg(Simulation& simulation, const Channels& channels, const Leg& leg, Recorded& done) {
  const std::size_t columns = channels.columns();
  for (std::size_t k = 0; k + 1 < leg.times.size(); ++k) {
    set_inputs(simulation, channels, leg.inputs.subspan(k * columns, columns));
    simulation.step_to(leg.times[k + 1]);
    std::vector<EventReport> events = simulation.events();
    done.events.insert(done.events.end(), std::make_move_iterator(events.begin()),
                       std::make_move_iterator(events.end()));
    read_channels(simulation, channels, leg.rows.at(k), leg.rows.column);
    ++done.steps;
    if (leg.until.is_due()) return;
  }
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// What stands behind a Simulation; for simulation.cpp and simulation_derivatives.cpp alone.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "preparation/adjustment.h"
#include "simulation/island.h"
#include "simulation/simulation.h"

namespace gelenk {

// Whether the integrator of one of the islands says so.
inline bool any_integrator(const std::vector<std::unique_ptr<Island>>& islands, bool (Integrator::*says)() const) {
  return std::ranges::any_of(islands, [&](const auto& island) {
    const Integrator* integrator = island->integrator();
    return integrator != nullptr && (integrator->*says)();
  });
}

struct Simulation::Impl {
  explicit Impl(const Scene& given)
      : given(given),
        scene(in_units(given, natural_units(given))),
        tuned(scene),
        reduced(reduce(scene)),
        inputs(input_signals(scene)),
        outputs(output_signals(scene)),
        diagnostics(diagnostic_signals()),
        u(inputs.size()),
        size(size_of(reduced)),
        log(inputs.size()) {
    for (std::size_t i = 0; i < inputs.size(); ++i) u.set(static_cast<int>(i), inputs[i].start);
    sizes_of(inputs, input_size);
    sizes_of(outputs, output_size);
    sizes_of(diagnostics, diagnostic_size);
  }

  static Scene in_units(Scene scene, const UnitSystem& units) {
    convert(scene, units);
    return scene;
  }
  void sizes_of(const std::vector<Signal>& signals, std::vector<double>& sizes) const {
    for (const Signal& signal : signals) sizes.push_back(scene.units.size_of(signal.unit));
  }

  Scene given;           // in SI, as all that the user sees
  Scene scene;           // in natural units, as all that follows
  Scene tuned;           // in natural units, while it is taken over
  ReducedScene reduced;  // before the start values are known
  std::vector<Signal> inputs, outputs, diagnostics;
  std::vector<double> input_size, output_size, diagnostic_size;  // the SI value of 1 in natural units
  Inputs u;
  ModelSize size;

  // From initialize() on.
  PreparedScene prepared;
  std::vector<MovedFrame> moved;  // frames of the scene that are not where they are in `given`
  std::vector<std::unique_ptr<Island>> islands;
  std::vector<int> island_of_input;
  std::unique_ptr<Outputs> readings;
  std::optional<LoadMaker> load_maker;
  std::vector<Loads> other_loads;  // by island: to be filled in when tuned
  double immobile_energy = 0;      // J, potential, of what stands still
  double time = 0;
  bool initialized = false;
  bool runs = false;       // with integrators
  InputLog log;            // for islands with a history
  bool cut_short = false;  // the last advance was
  IndependentOutputs independent;
  std::vector<Independent> independent_by_island;
  std::vector<StateVariable> states;
  std::unique_ptr<Sensitivity> sensitivity;  // made when first asked for

  Eigen::VectorXd sizes_of_states() const;  // as output_size; of their derivatives, too
  void prepare_start();  // closes the loops, of a scene whose numbers were rounded, too (assembled_start.cpp)
  void close_loops();
  void prepare_or_advise(double tolerance);
  void take(AdjustedScene adjusted);
  void tell_moves();
  void make_islands();
  void find_independent();
  void start_at_equilibrium();       // the start becomes a rest (start_at_equilibrium.cpp)
  int known_input(int index) const;  // throws std::out_of_range
  void check_inputs(double end) const;
  void advance(double end);
  void exchange_past(Archive& archive);
  void replay(const std::vector<ReplayPath>& ways);
  double advance_islands(double end, bool continues, std::size_t& moved);
  Energy energy();
  double largest_gap(const std::vector<double>& (Kinematics::*of)() const);
  std::vector<std::string> names_of_coordinates(int island) const;  // independent ones
  Independent independent_of(int island, const std::vector<bool>& coordinates, const std::vector<bool>& speeds) const;
};

}  // namespace gelenk

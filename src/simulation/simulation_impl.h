// SPDX-License-Identifier: BSD-3-Clause
// The implementation of Simulation, for this module only.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "preparation/adjustment.h"
#include "preparation/loads.h"
#include "scene/formulas.h"
#include "simulation/island.h"
#include "simulation/sensitivity.h"
#include "simulation/simulation.h"
#include "simulation/trim.h"

namespace gelenk {

// Whether the predicate holds for the integrator of any island.
inline bool any_integrator(const std::vector<std::unique_ptr<Island>>& islands, bool (Integrator::*predicate)() const) {
  return std::ranges::any_of(islands, [&](const auto& island) {
    const Integrator* integrator = island->integrator();
    return integrator != nullptr && (integrator->*predicate)();
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
        u(inputs.size(), reads_time(scene)),
        size(size_of(reduced)),
        log(inputs_at_start(inputs, u)) {
    sizes_of(inputs, input_size);
    sizes_of(outputs, output_size);
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      if (outputs[k].section == sections::states)
        output_size[k] = size_of(scene.states[static_cast<std::size_t>(outputs[k].element)], scene.units);
    }
    sizes_of(diagnostics, diagnostic_size);
  }

  // Sets the start values of the inputs, and declares those that prescribe motions.
  static const Inputs& inputs_at_start(const std::vector<Signal>& signals, Inputs& u);
  static Scene in_units(Scene scene, const UnitSystem& units) {
    convert(scene, units);
    return scene;
  }
  void sizes_of(const std::vector<Signal>& signals, std::vector<double>& sizes) const {
    for (const Signal& signal : signals) sizes.push_back(scene.units.size_of(signal.unit));
  }

  Scene given;           // the user's scene, in SI units
  Scene scene;           // in natural units, as are all members below unless noted
  Scene tuned;           // workspace of tune()
  ReducedScene reduced;  // before the start values are known
  std::vector<Signal> inputs, outputs, diagnostics;
  std::vector<double> input_size, output_size, diagnostic_size;  // SI value of one natural unit
  Inputs u;
  ModelSize size;

  // Defined by initialize() or assemble().
  PreparedScene prepared;
  std::vector<MovedFrame> moved;  // frames of the scene whose pose differs from that in `given`
  std::vector<std::unique_ptr<Island>> islands;
  std::vector<std::vector<int>> islands_of_input;       // on which it acts
  std::vector<std::vector<int>> islands_showing_input;  // of which named expressions read it
  std::unique_ptr<Outputs> readings;
  std::optional<LoadAssembler> load_assembler;
  std::vector<Loads> other_loads;  // by island: workspace of tune()
  double immobile_energy = 0;      // potential energy of immobile bodies
  double time = 0;
  bool initialized = false;
  bool runs = false;       // whether there are integrators
  InputLog log;            // for islands with a history
  bool cut_short = false;  // whether the last advance ended early
  long worst_step = 0;     // the most evaluations in one communication step
  IndependentOutputs independent;
  std::vector<Independent> independent_by_island;
  std::vector<int> states;                   // outputs
  std::unique_ptr<Sensitivity> sensitivity;  // created on first use

  Eigen::VectorXd sizes_of_states() const;  // SI values of natural units; same for derivatives
  void prepare_start();  // closes the loops, adjusting frames if numbers were rounded (assembled_start.cpp)
  void close_loops();
  void prepare_or_advise(double tolerance);
  void adopt(AdjustedScene adjusted);
  void report_moves();
  void make_islands();
  void find_independent();
  void start_at_equilibrium();  // moves the start to an equilibrium
  void refuse_touching_equilibrium();
  Trim trim(const EquilibriumRequest& request);
  void add_residuals(int island, const EquilibriumRequest& request, const Equilibrium& here, Trim& out) const;
  Equilibrium found_from(const Island& island, const EquilibriumProblem& of,
                         const std::vector<std::string>& coordinates) const;
  std::vector<int> mechanisms_of_input(int input) const;
  EquilibriumRequest part_of(const EquilibriumRequest& request, int island) const;
  std::vector<int> independent_accelerations(int island, EquilibriumRequest* request) const;
  EquilibriumProblem at_rest(const Island& island, const std::vector<MotionLaw::Derivatives>& targets) const;
  int checked_input(int index) const;  // throws std::out_of_range
  void check_inputs(double end) const;
  void renew_motions();
  void notify_of_input(int input, bool jumped);
  void advance(double end);
  long evaluations() const;
  void serialize_replay(Archive& archive);
  void replay(const std::vector<ReplayPath>& paths);
  void replay(Island& island, const ReplayPath& path, std::size_t newer);
  void roll_back(Island& island, bool logged) { replay(island, island.roll_back(), logged ? 1 : 0); }
  long permitted_evaluations(double span) const;
  std::string describe_cut_step(double t, double end, long evaluations) const;
  double advance_islands(double end, bool continues, bool logged, std::size_t& moved);
  Energy energy();
  double law_excess();
  double max_constraint_error(const std::vector<double>& (Kinematics::*errors)() const);
  std::vector<std::string> names_of_coordinates(int island) const;  // of the independent ones
  Independent independent_of(int island, const std::vector<bool>& coordinates, const std::vector<bool>& speeds) const;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/runtime/plant_derivatives.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "modelDescription/capabilities.h"
#include "simulation/state_derivatives.h"
#include "util/text.h"

namespace gelenk {
namespace {

const Variable& variable(const Catalog& catalog, unsigned reference) {
  if (const Variable* found = catalog.find(reference)) return *found;
  throw UsageError("value reference: found " + std::to_string(reference) + ", expected less than " +
                   std::to_string(catalog.variables().size()));
}

// The index of an output among the simulation's states, or -1.
int state_of(const std::vector<int>& states, int output) {
  const auto found = std::ranges::find(states, output);
  return found == states.end() ? -1 : static_cast<int>(found - states.begin());
}

void check_determined(const Simulation& simulation, int output, double derivative) {
  if (!std::isnan(derivative)) return;
  throw NotDifferentiable(simulation.outputs()[static_cast<std::size_t>(output)].name +
                          ": its derivatives are not determined, since friction and limits hold the joints of its loop "
                          "redundantly");
}

class Directions {
 public:
  Directions(const Catalog& catalog, Simulation& simulation)
      : catalog_(catalog),
        simulation_(simulation),
        derivatives_(simulation),
        dx_(derivatives_.states().size(), 0.0),
        du_(simulation.inputs().size(), 0.0) {}

  void seed(unsigned reference, double value) {
    const Variable& known = variable(catalog_, reference);
    const int state = known.source == Source::output ? state_of(derivatives_.states(), known.index) : -1;
    if (known.source != Source::input && state < 0) {
      throw UsageError("known: found " + known.name + ", expected an input or a state");
    }
    if (!std::isfinite(value)) {
      throw UsageError("dvKnown of " + known.name + ": found " + text::number(value) + ", expected a finite number");
    }
    (known.source == Source::input ? du_[static_cast<std::size_t>(known.index)]
                                   : dx_[static_cast<std::size_t>(state)]) += value;
  }

  // The row of an unknown: index of the output or, for rates of quaternions, of the state after all outputs.
  Eigen::Index row(unsigned reference) const {
    const Variable& unknown = variable(catalog_, reference);
    if (unknown.source == Source::output) return unknown.index;
    if (unknown.source == Source::rate && unknown.derivative_of >= 0) {
      const Variable& state = catalog_.variables()[static_cast<std::size_t>(unknown.derivative_of)];
      return static_cast<Eigen::Index>(simulation_.outputs().size()) + state_of(derivatives_.states(), state.index);
    }
    throw UsageError("unknown: found " + unknown.name + ", expected an output or the derivative of a state");
  }

  void run(const std::vector<Eigen::Index>& rows, double* out) {
    const DirectionalDerivative derivative = derivatives_.directional_derivative(dx_, du_);
    for (const Eigen::Index r : rows) {
      const bool of_output = r < derivative.outputs.rows();
      const Eigen::Index state = r - derivative.outputs.rows();
      *out = of_output ? derivative.outputs(r, 0) : derivative.rates(state, 0);
      const int named = of_output ? static_cast<int>(r) : derivatives_.states()[static_cast<std::size_t>(state)];
      check_determined(simulation_, named, *out);
      ++out;
    }
  }

 private:
  const Catalog& catalog_;
  const Simulation& simulation_;
  StateDerivatives derivatives_;
  std::vector<double> dx_, du_;
};

}  // namespace

void directional_derivative(Plant& plant, References unknown, References known, const double* seed, double* out) {
  const PlantModel::States& declared = plant.model().states();
  Simulation& simulation = plant.simulation();
  StateDerivatives(simulation).take_states(declared.independent);
  Directions directions(declared.catalog, simulation);
  std::vector<Eigen::Index> rows;
  for (const unsigned reference : unknown) rows.push_back(directions.row(reference));
  for (const unsigned reference : known) directions.seed(reference, *seed++);
  directions.run(rows, out);
}

void output_derivatives(Plant& plant, References outputs, const int* orders, double* out) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const Variable& v = variable(plant.catalog(), outputs[i]);
    if (v.source != Source::output) throw UsageError(v.name + " is not an output: only outputs have time derivatives");
    if (orders[i] < 1 || orders[i] > max_output_derivative_order) {
      throw UsageError("order: found " + std::to_string(orders[i]) + " for " + v.name + ", expected 1 to " +
                       std::to_string(max_output_derivative_order));
    }
    indices.push_back(v.index);
  }
  const Eigen::MatrixX2d found = StateDerivatives(plant.simulation()).output_derivatives();
  for (std::size_t i = 0; i < indices.size(); ++i) {
    out[i] = found(indices[i], orders[i] - 1);
    check_determined(plant.simulation(), indices[i], out[i]);
  }
}

}  // namespace gelenk

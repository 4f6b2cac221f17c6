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

  // The column of a known among states and inputs.
  Eigen::Index column(unsigned reference) const {
    const Variable& known = variable(catalog_, reference);
    const auto states = static_cast<Eigen::Index>(dx_.size());
    if (known.source == Source::input) return states + known.index;
    const int state = known.source == Source::output ? state_of(derivatives_.states(), known.index) : -1;
    if (state < 0) throw UsageError("known: found " + known.name + ", expected an input or a state");
    return state;
  }

  void seed(unsigned reference, const char* argument, double value) {
    const auto entry = static_cast<std::size_t>(column(reference));
    check_finite(argument, reference, value);
    (entry < dx_.size() ? dx_[entry] : du_[entry - dx_.size()]) += value;
  }

  void check_finite(const char* argument, unsigned reference, double value) const {
    if (std::isfinite(value)) return;
    throw UsageError(std::string(argument) + " of " + variable(catalog_, reference).name + ": found " +
                     text::number(value) + ", expected a finite number");
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
      check_determined(simulation_, named(r), *out);
      ++out;
    }
  }

  // out[k] = sum of seed[i] times the entry in rows[i] and columns[k] of the Jacobian.
  void run_adjoint(const std::vector<Eigen::Index>& rows, const double* seed, const std::vector<Eigen::Index>& columns,
                   double* out) {
    const Linearization all = derivatives_.linearize();
    const Eigen::Index outputs = all.C.rows();
    const Eigen::Index states = all.A.cols();
    for (const Eigen::Index c : columns) {
      const bool of_state = c < states;
      const auto of_outputs = of_state ? all.C.col(c) : all.D.col(c - states);
      const auto of_rates = of_state ? all.A.col(c) : all.B.col(c - states);
      *out = 0;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const double entry = rows[i] < outputs ? of_outputs[rows[i]] : of_rates[rows[i] - outputs];
        check_determined(simulation_, named(rows[i]), entry);
        *out += seed[i] * entry;
      }
      ++out;
    }
  }

 private:
  // The output that names a row.
  int named(Eigen::Index row) const {
    const auto outputs = static_cast<Eigen::Index>(simulation_.outputs().size());
    return row < outputs ? static_cast<int>(row) : derivatives_.states()[static_cast<std::size_t>(row - outputs)];
  }

  const Catalog& catalog_;
  const Simulation& simulation_;
  StateDerivatives derivatives_;
  std::vector<double> dx_, du_;
};

}  // namespace

void directional_derivative(Plant& plant, References unknown, References known, NamedSeed seed, double* out) {
  const PlantModel::States& declared = plant.model().states();
  Simulation& simulation = plant.simulation();
  StateDerivatives(simulation).take_states(declared.independent);
  Directions directions(declared.catalog, simulation);
  std::vector<Eigen::Index> rows;
  for (const unsigned reference : unknown) rows.push_back(directions.row(reference));
  for (std::size_t k = 0; k < known.size(); ++k) directions.seed(known[k], seed.name, seed.values[k]);
  directions.run(rows, out);
}

void adjoint_derivative(Plant& plant, References unknown, References known, NamedSeed seed, double* out) {
  const PlantModel::States& declared = plant.model().states();
  Simulation& simulation = plant.simulation();
  StateDerivatives(simulation).take_states(declared.independent);
  Directions directions(declared.catalog, simulation);
  std::vector<Eigen::Index> rows, columns;
  for (std::size_t i = 0; i < unknown.size(); ++i) {
    rows.push_back(directions.row(unknown[i]));
    directions.check_finite(seed.name, unknown[i], seed.values[i]);
  }
  for (const unsigned reference : known) columns.push_back(directions.column(reference));
  directions.run_adjoint(rows, seed.values, columns, out);
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

// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/catalog.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "joint/kinds.h"
#include "modelDescription/units.h"
#include "scene/signals.h"
#include "scene/wanted_outputs.h"

namespace gelenk {
namespace {

std::string type_of_unit(const std::string& unit) {
  const std::string_view measured = quantity(unit);
  return measured.empty() ? std::string() : "Gelenk." + std::string(measured);
}

Variable described(const Signal& signal, Causality causality, Source source, std::size_t index) {
  Variable v;
  v.name = signal.name;
  v.description = signal.description;
  v.unit = signal.unit;
  v.display_unit = default_display_unit(signal.unit);
  v.type_name = type_of_unit(signal.unit);
  v.causality = causality;
  v.source = source;
  v.index = static_cast<int>(index);
  return v;
}

// The meaning of an enumeration's numbers, as part of its description: ": 1 projection, 2 baumgarte".
std::string numbered(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    text += (i == 0 ? ": " : ", ") + std::to_string(i + 1) + " " + items[i];
  }
  return text;
}

// The nearest power of ten; 0 for 0.
double power_of_ten(double x) { return x > 0 ? std::pow(10.0, std::round(std::log10(x))) : 0; }

}  // namespace

Catalog::Catalog(const Scene& scene) {
  add_inputs(scene);
  add_outputs(scene);
  add_parameters(scene);
  rates_begin_ = static_cast<int>(variables_.size());
  for (std::size_t j = 0; j < kinds_.size(); ++j) {
    for (int i = 0; i < kinds_[j]->nq; ++i) {
      if (!kinds_[j]->is_of_quaternion(i)) continue;
      const Variable& coordinate = variables_[static_cast<std::size_t>(output_variable(first_output_[j] + i))];
      Variable v;
      v.name = "der(" + coordinate.name + ")";
      v.description = scene.joints[j].name + ": time derivative of the " + std::string(kinds_[j]->q[i].description);
      v.unit = "1/s";
      v.source = Source::rate;
      v.index = static_cast<int>(rates_.size());
      variables_.push_back(std::move(v));
      rates_.push_back({static_cast<int>(j), i});
    }
  }
  add_diagnostics();
  add_nominals(scene);
  if (!scene.outputs.empty()) hide_unwanted(scene);
}

void Catalog::hide_unwanted(const Scene& scene) {
  const std::vector<bool> wanted = wanted_outputs(scene);
  for (Variable& v : variables_) {
    const bool shown =
        v.source == Source::output ? wanted[static_cast<std::size_t>(v.index)] : v.source != Source::rate;
    if (shown) continue;
    v.hidden = true;
    v.causality = Causality::local;
  }
}

void Catalog::add_inputs(const Scene& scene) {
  const std::vector<Signal> signals = input_signals(scene);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    variables_.push_back(described(signals[i], Causality::input, Source::input, i));
    variables_.back().start = signals[i].start;
  }
}

void Catalog::add_outputs(const Scene& scene) {
  outputs_begin_ = static_cast<int>(variables_.size());
  const std::vector<Signal> signals = output_signals(scene);
  int next = 0;
  for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
    kinds_.push_back(find_joint_kind(scene.joints[static_cast<std::size_t>(j)].type));
    first_output_.push_back(next);
    while (next < static_cast<int>(signals.size()) && signals[static_cast<std::size_t>(next)].joint == j) ++next;
  }
  for (std::size_t i = 0; i < signals.size(); ++i) {
    variables_.push_back(described(signals[i], Causality::output, Source::output, i));
    joint_of_.push_back(signals[i].joint);
  }
}

void Catalog::add_parameters(const Scene& scene) {
  parameters_ = scene_parameters(scene);
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const Parameter& p = parameters_[i];
    Variable v;
    v.name = p.name;
    v.description = p.description + numbered(p.items);
    v.unit = p.unit;
    v.display_unit = default_display_unit(p.unit);
    v.type_name = type_of_unit(p.unit);
    v.causality = Causality::parameter;
    v.variability = p.tunable ? Variability::tunable : Variability::fixed;
    v.type = p.type;
    v.source = Source::parameter;
    v.index = static_cast<int>(i);
    v.start = p.get(scene);
    v.min = p.min;
    v.max = p.max;
    variables_.push_back(std::move(v));
  }
}

void Catalog::add_diagnostics() {
  const std::vector<Signal> signals = diagnostic_signals();
  for (std::size_t i = 0; i < signals.size(); ++i) {
    variables_.push_back(described(signals[i], Causality::local, Source::diagnostic, i));
    // Counts are Real, since an Integer of FMI would overflow after an hour.
    if (signals[i].name.starts_with("solver.")) variables_.back().variability = Variability::discrete;
    const auto which = static_cast<Diagnostic>(i);
    if (which != Diagnostic::potential_energy && which != Diagnostic::total_energy) variables_.back().min = 0;
  }
}

// The magnitudes of forces, torques and energies are estimated from the weight and its work over the length of the
// largest body.
void Catalog::add_nominals(const Scene& scene) {
  double mass = 0;
  double length = 0;
  for (const Body& body : scene.bodies) mass += body.mass;
  for (const Joint& joint : scene.joints) {
    length = std::max({length, joint.parent.X_BF.p.norm(), joint.child.X_BF.p.norm()});
  }
  const double weight = mass * scene.gravity.norm();
  for (Variable& v : variables_) {
    if (v.causality == Causality::parameter) continue;
    if (v.unit == "N") v.nominal = power_of_ten(weight);
    if (v.unit == "N.m" || v.unit == "J") v.nominal = power_of_ten(weight * length);
    if (v.name.starts_with("constraints.")) v.nominal = scene.experiment.tolerance;
    if (v.source == Source::output && v.unit == "J" && v.name.ends_with(".kinetic")) v.min = 0;
  }
  for (const ElementState& state : scene.states) {
    const auto named = std::ranges::find(variables_, state.name, &Variable::name);
    if (state.nominal > 0) named->nominal = state.nominal;
  }
}

void Catalog::declare(int state, int derivative) {
  variables_[static_cast<std::size_t>(derivative)].derivative_of = state;
  for (const int shown : {state, derivative}) variables_[static_cast<std::size_t>(shown)].hidden = false;
  states_.push_back({state, derivative});
}

void Catalog::declare_states(const IndependentOutputs& independent) {
  states_.clear();
  for (Variable& v : variables_) v.derivative_of = -1;
  const auto among = [](const std::vector<int>& outputs, int output) {
    return std::ranges::find(outputs, output) != outputs.end();
  };
  for (std::size_t j = 0; j < kinds_.size(); ++j) {
    const JointKind& kind = *kinds_[j];
    const int q = first_output_[j];
    const int v = q + kind.nq;
    const int a = v + kind.nv;
    for (int i = 0; i < kind.nq; ++i) {
      if (kind.is_of_quaternion(i) || !among(independent.coordinates, q + i)) continue;
      declare(output_variable(q + i), output_variable(v + i));
    }
    for (int i = 0; i < kind.nv; ++i) {
      if (among(independent.speeds, v + i)) declare(output_variable(v + i), output_variable(a + i));
    }
    for (std::size_t r = 0; r < rates_.size(); ++r) {
      const int coordinate = q + rates_[r].component;
      if (rates_[r].joint != static_cast<int>(j) || !among(independent.coordinates, coordinate)) continue;
      declare(output_variable(coordinate), rates_begin_ + static_cast<int>(r));
    }
  }
  for (const int state : independent.elements) declare(output_variable(state), output_variable(state + 1));
  std::ranges::sort(states_, {}, &State::derivative);
}

}  // namespace gelenk

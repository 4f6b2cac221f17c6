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
  add_rates(scene);
  add_diagnostics();
  add_time();
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

// Those of quaternions are always shown, others as far as their states are declared.
void Catalog::add_rates(const Scene& scene) {
  rates_begin_ = static_cast<int>(variables_.size());
  const std::vector<Signal> signals = output_signals(scene);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const Signal& of = signals[i];
    const bool can_be_state = of.level == 0 || of.level == 1 || (of.section == sections::states && of.group == 0);
    if (!can_be_state) continue;
    const JointKind* kind = of.joint < 0 ? nullptr : kinds_[static_cast<std::size_t>(of.joint)];
    const bool is_of_quaternion = kind != nullptr && of.level == 0 && kind->is_of_quaternion(of.component);
    if (!is_of_quaternion && of.derivative < 0) continue;
    Rate rate{.of = static_cast<int>(i), .same_as = of.derivative};
    Variable v;
    v.name = "der(" + of.name + ")";
    if (is_of_quaternion) {
      rate.joint = of.joint;
      rate.component = of.component;
      v.description = scene.joints[static_cast<std::size_t>(of.joint)].name + ": time derivative of the " +
                      std::string(kind->q[static_cast<std::size_t>(of.component)].description);
      v.unit = "1/s";
    } else {
      const Signal& same = signals[static_cast<std::size_t>(of.derivative)];
      v = described(same, Causality::local, Source::rate, 0);
      v.name = "der(" + of.name + ")";
      v.description = "time derivative of " + of.name + "; equal to " + same.name;
      v.hidden = true;
    }
    v.source = Source::rate;
    v.index = static_cast<int>(rates_.size());
    variables_.push_back(std::move(v));
    rates_.push_back(rate);
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

// No signal has this name (check/names.cpp).
void Catalog::add_time() {
  Variable v;
  v.name = "time";
  v.description = "simulation time";
  v.unit = "s";
  v.type_name = type_of_unit(v.unit);
  v.causality = Causality::independent;
  v.source = Source::time;
  v.hidden = true;
  variables_.push_back(std::move(v));
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

void Catalog::declare_states(const IndependentOutputs& independent) {
  for (const State& state : states_) {
    Variable& former = variables_[static_cast<std::size_t>(state.derivative)];
    former.derivative_of = -1;
    former.hidden = former.hidden || rates_[static_cast<std::size_t>(former.index)].same_as >= 0;
  }
  states_.clear();
  const std::vector<int> states = independent.states();
  for (std::size_t r = 0; r < rates_.size(); ++r) {
    if (std::ranges::find(states, rates_[r].of) == states.end()) continue;
    const State declared{.variable = output_variable(rates_[r].of), .derivative = rates_begin_ + static_cast<int>(r)};
    variables_[static_cast<std::size_t>(declared.derivative)].derivative_of = declared.variable;
    for (const int shown : {declared.variable, declared.derivative})
      variables_[static_cast<std::size_t>(shown)].hidden = false;
    states_.push_back(declared);
  }
}

}  // namespace gelenk

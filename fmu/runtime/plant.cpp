// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/runtime/plant.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "joint/kinds.h"
#include "modelDescription/fingerprint.h"
#include "scene_file/read.h"
#include "simulation/start_report.h"
#include "simulation/state_derivatives.h"
#include "util/text.h"

namespace gelenk {
namespace {

std::size_t inputs_of(const Catalog& catalog) {
  std::size_t n = 0;
  for (const Variable& v : catalog.variables()) n += v.source == Source::input ? 1 : 0;
  return n;
}

void take_starts(const Catalog& catalog, Inputs& inputs) {
  for (const Variable& v : catalog.variables()) {
    if (v.source == Source::input) inputs.set(v.index, v.start.value_or(0));
  }
}

}  // namespace

PlantModel::PlantModel(std::string_view scene_json, const std::string& file)
    : scene(read_scene_json(scene_json, file)), catalog(scene), guid(fingerprint(scene_json)) {}

const PlantModel::States& PlantModel::states() const {
  std::call_once(states_once_, [this] {
    Simulation simulation(scene);
    simulation.assemble();
    States found{catalog, StateDerivatives(simulation).independent(), {}, {}};
    found.catalog.declare_states(found.independent);
    found.index_of.assign(catalog.variables().size(), -1);
    found.index_of_derivative = found.index_of;
    int index = 0;
    for (const State& state : found.catalog.states()) {
      found.index_of[static_cast<std::size_t>(state.variable)] = index;
      found.index_of_derivative[static_cast<std::size_t>(state.derivative)] = index++;
    }
    states_ = std::move(found);
  });
  return *states_;
}

int PlantModel::indicators() const {
  std::call_once(indicators_once_, [this] {
    if (ModelExchange::refusal(scene).empty()) indicators_ = ModelExchange::indicators_of(scene);
  });
  return indicators_;
}

Plant::Plant(std::shared_ptr<const PlantModel> model, Kind kind)
    : model_(std::move(model)),
      scene_(model_->scene),
      settings_(model_->catalog, scene_),
      assembled_(settings_),
      inputs_(inputs_of(model_->catalog)),
      first_inputs_(inputs_),
      kind_(kind) {
  take_starts(model_->catalog, inputs_);
}

void Plant::set_experiment(double start, double tolerance) {
  start_ = start;
  tolerance_ = tolerance;
  discard_simulation();
}

void Plant::discard_simulation() {
  exchange_.reset();
  simulation_.reset();
}

void Plant::assemble() {
  if (simulation_) return;
  const Scene& own = settings_ == Settings(catalog(), model_->scene) ? scene_ : checked(scene_);
  const bool exchanges = kind_ == Kind::model_exchange;
  Simulation fresh(exchanges ? ModelExchange::prepared(own) : own);
  for (int i = 0; i < static_cast<int>(inputs_.count()); ++i) {
    fresh.set_input(i, inputs_.value(i));
    for (int order = 1; order <= Inputs::highest_order; ++order) {
      fresh.set_input_derivative(i, order, inputs_.derivative(i, order));
    }
  }
  fresh.initialize(start_, requested_tolerance());
  first_inputs_ = inputs_;
  simulation_.emplace(std::move(fresh));
  assembled_ = settings_;
  if (exchanges) make_exchange();
}

void Plant::make_exchange() {
  const PlantModel::States& declared = model_->states();
  StateDerivatives(*simulation_).take_states(declared.independent);
  std::vector<int> outputs;
  for (const State& state : declared.catalog.states())
    outputs.push_back(catalog().variables()[static_cast<std::size_t>(state.variable)].index);
  exchange_ = std::make_unique<ModelExchange>(*simulation_, std::move(outputs));
}

double Plant::requested_tolerance() const {
  const double own = scene_.experiment.tolerance;
  const bool is_changed = own != model_->scene.experiment.tolerance;
  return is_changed || (tolerance_confirmed_ && tolerance_ > own) ? 0 : tolerance_;
}

std::string Plant::assembly_report() const {
  return simulation_ ? StartReport(*simulation_).assembly() : std::string();
}

std::vector<std::string> Plant::start_warnings() const {
  return simulation_ ? StartReport(*simulation_).warnings() : std::vector<std::string>();
}

Simulation& Plant::simulation() {
  assemble();
  if (exchange_) exchange_->show();
  return *simulation_;
}

ModelExchange& Plant::exchange() {
  assemble();
  return *exchange_;
}

std::vector<double> Plant::indicator_values() {
  std::vector<double> out(static_cast<std::size_t>(model_->indicators()));
  if (kind_ == Kind::model_exchange) exchange().indicator_values(out.data());
  return out;
}

double Plant::nominal(std::size_t state) const {
  const State& of = model_->states().catalog.states()[state];
  const double known = catalog().variables()[static_cast<std::size_t>(of.variable)].nominal;
  return known > 0 ? known : 1;
}

double Plant::get(int variable) {
  const Variable& v = catalog().variables()[static_cast<std::size_t>(variable)];
  const auto index = static_cast<std::size_t>(v.index);
  switch (v.source) {
    case Source::input:
      return input(v.index);
    case Source::parameter:
      return catalog().parameters()[index].get(scene_);
    case Source::output:
      return simulation().output(v.index);
    case Source::diagnostic:
      return simulation().diagnostic(v.index);
    case Source::rate:
      return rate(variable, catalog().rates()[index]);
    case Source::time:
      return time();
  }
  return 0;
}

double Plant::rate(int variable, const Rate& rate) {
  if (kind_ == Kind::model_exchange) {
    const int state = model_->states().index_of_derivative[static_cast<std::size_t>(variable)];
    if (state >= 0) return exchange().rates()[static_cast<std::size_t>(state)];
  }
  Simulation& present = simulation();
  if (rate.same_as >= 0) return present.output(rate.same_as);
  std::array<double, 13> state{};  // the free joint has the most coordinates and velocities
  std::array<double, 7> qdot{};
  const AnyJoint& joint = *scene_.joints[static_cast<std::size_t>(rate.joint)].is;
  const JointKind& kind = kind_of(joint);
  const int first = catalog().first_output(rate.joint);
  for (int i = 0; i < kind.nq + kind.nv; ++i) state[static_cast<std::size_t>(i)] = present.output(first + i);
  coordinate_rates(joint, state.data(), state.data() + kind.nq, qdot.data());
  return qdot[static_cast<std::size_t>(rate.component)];
}

void Plant::check(int variable, double value) const {
  const Variable& v = catalog().variables()[static_cast<std::size_t>(variable)];
  if (v.source == Source::parameter) {
    check_parameter(catalog().parameters()[static_cast<std::size_t>(v.index)], value);
  } else if (v.source != Source::input && !is_settable_state(variable)) {
    throw std::invalid_argument(v.name + " is computed by the plant and cannot be set");
  } else if (!std::isfinite(value)) {
    throw std::invalid_argument(
        v.name + ": found " + text::number(value) + ", expected a finite number; the value remains " +
        text::number(v.source == Source::input ? input(v.index) : present_state(variable)) + " " + v.unit);
  }
}

// With model exchange the importer sets states after initialization, also by fmi2SetReal.
bool Plant::is_settable_state(int variable) const {
  return exchange_ != nullptr && model_->states().index_of[static_cast<std::size_t>(variable)] >= 0;
}

double Plant::present_state(int variable) const {
  return exchange_->states()[static_cast<std::size_t>(model_->states().index_of[static_cast<std::size_t>(variable)])];
}

void Plant::check_input_derivative(int variable, int order, double value) const {
  const Variable& v = catalog().variables()[static_cast<std::size_t>(variable)];
  if (v.source != Source::input)
    throw std::invalid_argument(v.name + ": found a variable that is not an input, expected an input");
  const std::string fault = Inputs::fault(order, value);
  if (!fault.empty()) throw std::invalid_argument(v.name + ": " + fault);
}

void Plant::set_input_derivative(int variable, int order, double value) {
  check_input_derivative(variable, order, value);
  const Variable& v = catalog().variables()[static_cast<std::size_t>(variable)];
  inputs_.set_derivative(v.index, order, value);
  if (simulation_) simulation_->set_input_derivative(v.index, order, value);
}

void Plant::set(int variable, double value) {
  check(variable, value);
  const Variable& v = catalog().variables()[static_cast<std::size_t>(variable)];
  const auto index = static_cast<std::size_t>(v.index);
  if (v.source == Source::input) {
    inputs_.set(v.index, value);
    if (simulation_) simulation_->set_input(v.index, value);
    if (exchange_) exchange_->inputs_changed();
    return;
  }
  if (v.source == Source::output) {
    const int state = model_->states().index_of[static_cast<std::size_t>(variable)];
    return exchange_->set_state(static_cast<std::size_t>(state), value);
  }
  const Parameter& parameter = catalog().parameters()[index];
  if (parameter.name == "solver.tolerance") {
    const double requested = requested_tolerance();
    tolerance_confirmed_ = true;
    if (requested_tolerance() != requested) discard_simulation();
  }
  if (value == parameter.get(scene_)) return;
  set_parameter(scene_, parameter, value);
  settings_ = Settings(catalog(), scene_);
  discard_simulation();
}

void Plant::tune(int variable, double value) {
  const Variable& v = catalog().variables()[static_cast<std::size_t>(variable)];
  if (v.variability != Variability::tunable) return set(variable, value);
  const Parameter& parameter = catalog().parameters()[static_cast<std::size_t>(v.index)];
  check_parameter(parameter, value);
  if (value == parameter.get(scene_)) return;
  set_parameter(scene_, parameter, value);
  settings_.values[static_cast<std::size_t>(v.index)] = value;
  simulation_->tune(scene_);
  if (exchange_) exchange_->inputs_changed();
}

void Plant::serialize(Archive& archive) {
  bool assembled = simulation_.has_value();
  double start = start_;
  double tolerance = std::copysign(tolerance_, tolerance_confirmed_ ? -1 : 1);  // the sign contains the flag
  Settings when_assembled = assembled_;
  Settings present = settings_;
  archive.serialize(assembled, start, tolerance);
  Inputs first = first_inputs_;
  first.serialize(archive);
  inputs_.serialize(archive);
  when_assembled.serialize(archive);
  present.serialize(archive);
  if (archive.reading()) {
    const bool confirmed = std::signbit(tolerance);
    tolerance = std::abs(tolerance);
    const bool same = start == start_ && tolerance == tolerance_ && confirmed == tolerance_confirmed_ &&
                      when_assembled == assembled_ && first == first_inputs_;
    if (!assembled || !same) discard_simulation();
    start_ = start;
    tolerance_ = tolerance;
    tolerance_confirmed_ = confirmed;
    if (assembled) {
      std::swap(inputs_, first);
      adopt(when_assembled, present);
      inputs_ = std::move(first);
    } else if (settings_ != present) {
      present.put(catalog(), scene_);
      settings_ = std::move(present);
    }
  }
  if (assembled) exchange_ ? exchange_->serialize(archive) : simulation_->serialize(archive);
}

// Adopts the settings of a run that was assembled with `assembled` and tuned to `present`.
void Plant::adopt(const Settings& assembled, const Settings& present) {
  if (!simulation_) {
    assembled.put(catalog(), scene_);
    settings_ = assembled;
    assemble();
  }
  if (present == settings_) return;
  present.put(catalog(), scene_);
  settings_ = present;
  simulation_->tune(scene_);
}

}  // namespace gelenk

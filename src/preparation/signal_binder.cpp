// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/signal_binder.h"

#include <algorithm>
#include <tuple>

#include "outputs/sensor_reading.h"
#include "scene/formulas.h"

namespace gelenk {
namespace {

NamedQuantity quantity_of(const JointQuantity& of, const JointPlace& place) {
  const auto component = static_cast<std::size_t>(of.component);
  NamedQuantity out;
  out.is_rate = of.is_rate;
  if (place.role == JointPlace::Role::merged) {
    out.moves = false;
    out.value = of.is_rate ? 0 : place.q[component];
    return out;
  }
  const bool in_tree = place.role == JointPlace::Role::tree;
  out.cut = in_tree ? -1 : place.index;
  out.q = (in_tree ? place.iq : 0) + of.component;
  out.v = (in_tree ? place.iv : 0) + of.component;
  out.sign = (of.is_rate ? place.v_sign : place.q_sign)[component];
  return out;
}

bool equal(const NamedQuantity& a, const NamedQuantity& b) {
  if (a.reading != nullptr || b.reading != nullptr) return a.reading == b.reading;
  const auto key = [](const NamedQuantity& of) { return std::tuple(of.cut, of.q, of.is_rate, of.moves, of.value); };
  return key(a) == key(b);
}

// Returns its index among the signals.
int add(const NamedQuantity& quantity, Loads& loads) {
  const auto known = std::ranges::find_if(loads.named, [&](const auto& one) { return equal(one, quantity); });
  const auto k = static_cast<int>(known - loads.named.begin());
  if (known == loads.named.end()) loads.named.push_back(quantity);
  return loads.first_named() + k;
}

}  // namespace

SignalBinder::SignalBinder(const Scene& scene, const ReducedScene& reduced, int first_input)
    : scene_(scene),
      reduced_(reduced),
      first_input_(first_input),
      signals_(first_input + static_cast<int>(scene.inputs.size()) + (reads_time(scene) ? 1 : 0)) {}

void SignalBinder::bind(Formula& formula, const Mechanism& mechanism, Loads& loads) {
  if (formula.reads_forces() && force_units_.empty()) {
    for (Signal& signal : force_signals(scene_)) force_units_.emplace(std::move(signal.name), std::move(signal.unit));
  }
  for (std::size_t k = 0; k < formula.signal_names().size(); ++k) {
    const std::string& name = formula.signal_names()[k];
    const auto force = formula.reads_forces() ? force_units_.find(name) : force_units_.end();
    if (force != force_units_.end()) {
      formula.bind_signal(k, -1, scene_.units.size_of(force->second));
      continue;
    }
    const Bound at = find(name, mechanism, loads);
    formula.bind_signal(k, at.index, at.size);
  }
}

SignalBinder::Bound SignalBinder::find(std::string_view name, const Mechanism& mechanism, Loads& loads) {
  if (name == time_signal) return {.index = signals_ - 1};
  const auto input = std::ranges::find(scene_.inputs, name, &SceneInput::name);
  if (input != scene_.inputs.end()) {
    const int index = first_input_ + static_cast<int>(input - scene_.inputs.begin());
    return {.index = index, .size = scene_.units.size_of(input->unit)};
  }
  const auto state = std::ranges::find(scene_.states, name, &ElementState::name);
  if (state != scene_.states.end()) {
    const auto number = static_cast<int>(state - scene_.states.begin());
    const auto among = std::ranges::find(mechanism.states, number) - mechanism.states.begin();
    return {.index = loads.first_state + static_cast<int>(among), .size = size_of(*state, scene_.units)};
  }
  if (const std::optional<SensorOutput> of = find_sensor_output(scene_, name)) {
    const Sensor& sensor = scene_.sensors[static_cast<std::size_t>(of->sensor)];
    const SignalGroup& group = kind_of(*sensor.is).outputs[static_cast<std::size_t>(of->group)];
    NamedQuantity quantity;
    quantity.reading = readings_[std::string(name)];
    if (quantity.reading == nullptr) {
      quantity.reading = sensor_reading(scene_, reduced_, sensor, of->group, of->component);
      readings_[std::string(name)] = quantity.reading;
    }
    return {.index = add(quantity, loads), .size = scene_.units.size_of(group.unit)};
  }
  const std::optional<JointQuantity> of = find_coordinate(scene_, name);
  if (!of) return {.index = -1};  // a force of what was removed, such as friction from a scene that is looked at only
  const NamedQuantity coordinate = quantity_of(*of, reduced_.joints[static_cast<std::size_t>(of->joint)]);
  return {.index = add(coordinate, loads), .size = scene_.units.size_of(of->unit)};
}

}  // namespace gelenk

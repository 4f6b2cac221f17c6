// SPDX-License-Identifier: BSD-3-Clause
// Sources of the outputs, and their values as double; outputs_dual.cpp has the types for automatic differentiation.
#include <algorithm>

#include "element/kinds.h"
#include "mechanism/mechanism.h"
#include "outputs/outputs_impl.h"
#include "scene/formulas.h"
#include "scene/scene.h"
#include "scene/touching_laws.h"

namespace gelenk {
Outputs::Outputs(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& signals,
                 const std::vector<std::vector<SwitchingForce>>& switching_forces)
    : scene_(scene), reduced_(reduced) {
  for (const Sensor& sensor : scene.sensors) {
    ports_.emplace_back(scene, reduced, sensor, kind_of(*sensor.is).reads_reaction);
    std::vector<LawOfSensor>& laws = laws_of_sensors_.emplace_back();
    int number = static_cast<int>(scene.contacts.size());
    for (const TouchingLawOfJoint& law : touching_laws_of_joints(scene)) {
      const std::string& joint = scene.joints[static_cast<std::size_t>(law.joint)].name;
      if (kind_of(*sensor.is).reads_reaction && sensor.joints.front() == joint) laws.push_back({number, law.turns()});
      ++number;
    }
  }
  for (const Force& force : scene.forces) force_ports_.emplace_back(scene, reduced, force, false);
  for (const Signal& signal : signals) sources_.push_back(source_of(scene, signal, switching_forces));
  find_named_forces(scene, switching_forces);
}

Outputs::Source Outputs::source_of(const Scene& scene, const Signal& signal,
                                   const SwitchingForces& switching_forces) const {
  if (signal.level == 3) return joint_force_source(signal, switching_forces);
  return signal.joint >= 0 ? joint_source(signal) : element_source(scene, signal);
}

// Of the rates and the expressions that name any.
void Outputs::find_named_forces(const Scene& scene, const SwitchingForces& switching_forces) {
  rates_of_forces_.resize(reduced_.islands.size());
  const auto reads_forces = [](const Source& source) { return source.kind == Kind::expression_of_forces; };
  if (std::ranges::none_of(sources_, reads_forces) && first_with_rate_of_forces(scene) == nullptr) return;
  const std::vector<Signal> forces = force_signals(scene);
  for (Source& source : sources_) {
    if (!reads_forces(source)) continue;
    const std::vector<int>& expressions = reduced_.islands[static_cast<std::size_t>(source.island)].expressions;
    const int number = expressions[static_cast<std::size_t>(source.index)];
    source.group = static_cast<int>(named_forces_.size());
    named_forces_.push_back(
        sources_of(scene.expressions[static_cast<std::size_t>(number)].value, forces, scene, switching_forces));
  }
  for (std::size_t i = 0; i < reduced_.islands.size(); ++i) {
    const std::vector<int>& states = reduced_.islands[i].states;
    for (std::size_t k = 0; k < states.size(); ++k) {
      const Formula& rate = scene.states[static_cast<std::size_t>(states[k])].rate;
      if (!rate.reads_forces()) continue;
      rates_of_forces_[i].push_back({static_cast<int>(k), sources_of(rate, forces, scene, switching_forces)});
    }
  }
}

// Of what a formula names: forces have a source.
std::vector<Outputs::Source> Outputs::sources_of(const Formula& formula, const std::vector<Signal>& forces,
                                                 const Scene& scene, const SwitchingForces& switching_forces) const {
  std::vector<Source> out;
  for (const std::string& name : formula.signal_names()) {
    const auto found = std::ranges::find(forces, name, &Signal::name);
    if (found != forces.end() && found->section == sections::sensors &&
        !laws_of_sensors_[static_cast<std::size_t>(found->element)].empty())
      throw SceneError({(scene.file.empty() ? "" : scene.file + ": ") + "found an expression that names " + name +
                        ", the reaction of a joint with friction in several directions or a limit of its swing, which "
                        "expressions do not know; expected names of other outputs"});
    out.push_back(found == forces.end() ? Source() : source_of(scene, *found, switching_forces));
  }
  return out;
}

Outputs::Entry Outputs::entry(int output) const {
  const Source& s = sources_[output];
  switch (s.kind) {
    case Kind::tree_q:
      return {s.index, s.sign};
    case Kind::tree_v:
      return {reduced_.islands[s.island].nq + s.index, s.sign};
    case Kind::tree_a:
      return {reduced_.islands[s.island].nq + reduced_.islands[s.island].nv + s.index, s.sign};
    case Kind::state:
      return {reduced_.islands[s.island].nq + 2 * reduced_.islands[s.island].nv + s.index, 1};
    default:
      return {none, 0};
  }
}

Outputs::Source Outputs::joint_source(const Signal& signal) const {
  const JointPlace& place = reduced_.joints[signal.joint];
  const int c = signal.component;
  Source source;
  if (place.role == JointPlace::Role::merged) {
    source.sign = signal.level == 0 ? place.q[c] : 0;
    return source;
  }
  source.island = place.island;
  const Mechanism& mechanism = reduced_.islands[place.island];
  source.sign = signal.level == 0 ? place.q_sign[c] : place.v_sign[c];
  if (place.role == JointPlace::Role::tree) {
    static constexpr Kind kinds[] = {Kind::tree_q, Kind::tree_v, Kind::tree_a};
    static constexpr Stage stage[] = {Stage::position, Stage::position, Stage::acceleration};
    source.kind = kinds[signal.level];
    source.stage = stage[signal.level];
    source.index = (signal.level == 0 ? place.iq : place.iv) + c;
    return source;
  }
  static constexpr Kind kinds[] = {Kind::cut_q, Kind::cut_v, Kind::cut_a};
  static constexpr Stage cut_stages[] = {Stage::position, Stage::position, Stage::acceleration};
  source.kind = kinds[signal.level];
  source.stage = cut_stages[signal.level];
  source.index = signal.level == 0 ? place.iq + c : place.index;
  source.component = place.iv - mechanism.cuts[place.index].iv + c;
  return source;
}

// Of an immobile joint the force is 0: its bodies are held without it.
Outputs::Source Outputs::joint_force_source(const Signal& signal,
                                            const std::vector<std::vector<SwitchingForce>>& switching_forces) const {
  Source source;
  source.sign = 0;
  const JointPlace& place = reduced_.joints[signal.joint];
  if (place.role == JointPlace::Role::merged) return source;
  const std::string_view group = joint_force_kinds()[static_cast<std::size_t>(signal.element)].group;
  const std::vector<SwitchingForce>& among = switching_forces[static_cast<std::size_t>(place.island)];
  const auto found = std::ranges::find_if(among, [&](const SwitchingForce& of) {
    return of.joint == signal.joint && of.component == signal.component && of.group == group;
  });
  if (found == among.end()) return source;
  source.kind = signal.group == 0 ? Kind::joint_force : Kind::joint_mode;
  source.stage = Stage::acceleration;
  source.island = place.island;
  source.index = static_cast<int>(found - among.begin());
  return source;
}

Outputs::Source Outputs::named_source(const Signal& signal) const {
  Source out;
  const bool is_state = signal.section == sections::states;
  out.kind = !is_state ? Kind::expression : signal.group == 0 ? Kind::state : Kind::state_rate;
  out.stage = signal.stage;
  for (std::size_t i = 0; i < reduced_.islands.size(); ++i) {
    const std::vector<int>& among = is_state ? reduced_.islands[i].states : reduced_.islands[i].expressions;
    const auto found = std::ranges::find(among, signal.element);
    if (found == among.end()) continue;
    out.island = static_cast<int>(i);
    out.index = static_cast<int>(found - among.begin());
  }
  if (!is_state && scene_.expressions[static_cast<std::size_t>(signal.element)].value.reads_forces())
    out.kind = Kind::expression_of_forces;
  return out;
}

Outputs::Source Outputs::element_source(const Scene& scene, const Signal& signal) const {
  Source out;
  out.index = signal.element;
  out.group = signal.group;
  out.component = signal.component;
  if (signal.section == sections::states || signal.section == sections::expressions) return named_source(signal);
  out.stage = signal.stage == Stage::acceleration ? Stage::acceleration : Stage::velocity;
  if (signal.section == sections::sensors) {
    const auto i = static_cast<std::size_t>(signal.element);
    out.kind = kind_of(*scene.sensors[i].is).of_whole ? Kind::whole : Kind::sensor;
    out.island = out.kind == Kind::whole ? none : ports_[i].island;
    return out;
  }
  if (signal.section == sections::forces) {
    out.kind = Kind::force;
    out.island = force_ports_[static_cast<std::size_t>(signal.element)].island;
    return out;
  }
  if (signal.section == sections::contacts) {
    const bool is_of_joint = static_cast<std::size_t>(signal.element) >= scene.contacts.size();
    const auto touches = [&](const Mechanism& mechanism) {
      const auto is_this = [&](const auto& law) { return law.contact == signal.element; };
      return is_of_joint
                 ? std::ranges::any_of(mechanism.swings, is_this) || std::ranges::any_of(mechanism.frictions, is_this)
                 : !mechanism.shapes.empty();
    };
    const auto found = std::ranges::find_if(reduced_.islands, touches);
    out.kind = found == reduced_.islands.end() ? Kind::constant : Kind::contact;
    out.stage = Stage::acceleration;
    out.island = found == reduced_.islands.end() ? none : static_cast<int>(found - reduced_.islands.begin());
    out.sign = 0;
    return out;
  }
  out.island = reduced_.constraints[static_cast<std::size_t>(signal.element)].island;
  out.kind = out.island < 0 ? Kind::constant : Kind::constraint;
  if (out.island < 0) out.sign = 0;
  return out;
}

double Outputs::constant(int output) const { return constant(sources_[output]); }

double Outputs::constant(const Source& s) const {
  if (s.kind == Kind::constant) return s.sign;
  return s.kind == Kind::force ? force_value<double>(s, nullptr) : sensor_value<double>(s, nullptr);
}

template double Outputs::value(int, const Reading&) const;
template void Outputs::rates_of_forces(int, const std::vector<Formula>&, const Reading&, double*) const;
template double Outputs::of_energy(int, const Energy&) const;

}  // namespace gelenk

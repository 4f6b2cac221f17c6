// SPDX-License-Identifier: BSD-3-Clause
#include "equations/scene_equations.h"

#include <algorithm>
#include <utility>

#include "dynamics/dynamics.h"
#include "kinematics/visit.h"
#include "mechanism/mechanism.h"
#include "preparation/loads.h"
#include "recorded/motion_terms.h"
#include "recorded/recorded_island.h"
#include "scene/formulas.h"
#include "scene/signals.h"
#include "scene/touching_laws.h"
#include "simulation/simulation.h"
#include "simulation/start_report.h"

namespace gelenk {
namespace {

using recording::Recorded;

std::string prefix_of(const Scene& scene) { return (scene.file.empty() ? scene.name : scene.file) + ": "; }

std::string name_of(const Cut& cut, const Scene& scene) {
  if (cut.constraint >= 0) return scene.constraints[static_cast<std::size_t>(cut.constraint)].name;
  std::string out;
  for (const int joint : cut.scene_joints)
    out += (out.empty() ? "" : ", ") + scene.joints[static_cast<std::size_t>(joint)].name;
  return out;
}

// With loops that close although dimensions were rounded, in SI units.
Scene closed(const Scene& scene) {
  Simulation simulation(scene);
  simulation.assemble();
  return StartReport(simulation).adjusted_scene();
}

PreparedScene prepared_scene(const Scene& scene, const std::vector<Signal>& signals) {
  Inputs inputs(signals.size(), reads_time(scene));
  for (std::size_t i = 0; i < signals.size(); ++i) inputs.set(static_cast<int>(i), signals[i].start);
  return prepare(scene, reduce(scene), 0, inputs);
}

void append(const std::vector<Recorded>& from, std::vector<expression::Term>& to) {
  for (const Recorded& x : from) to.push_back(x.term());
}

void note_swings(const Scene& scene, const Mechanism& mechanism, std::vector<std::string>& notes) {
  for (const Swing& swing : mechanism.swings)
    notes.push_back(name_of_touching_law(scene, swing.contact) +
                    " is left out; the equations hold where it is not reached.");
}

}  // namespace

TracedScene::TracedScene(const Scene& scene)
    : scene_(closed(scene)), prepared_(prepared_scene(scene_, input_signals(scene_))) {
  loads_ = make_loads(scene_, prepared_.reduced);
  immobile_energy_ = immobile_energy(scene_, prepared_.reduced);
  arguments_.resize(prepared_.islands.size());
  name_inputs();
  std::vector<std::string> refused;
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    name_coordinates(i, arguments_[i]);
    name_targets(i, arguments_[i]);
    note_size(i);
    note_modes(i, arguments_[i], refused);
    note_swings(scene_, prepared_.islands[i].mechanism, equations_.notes);
  }
  if (!refused.empty()) throw SceneError(refused);
  if (equations_.v.empty()) throw SceneError({prefix_of(scene_) + "joints: found none that moves, expected one"});
  for (std::size_t i = 0; i < arguments_.size(); ++i) trace(i);
}

std::string TracedScene::coordinate_name(int joint, int component) const {
  for (const Signal& signal : output_signals(scene_)) {
    if (signal.joint == joint && signal.component == component && signal.level == 0) return signal.name;
  }
  return scene_.joints[static_cast<std::size_t>(joint)].name;
}

void TracedScene::name_coordinates(std::size_t island, IslandArguments& of) {
  const PreparedIsland& prepared = prepared_.islands[island];
  const Mechanism& mechanism = prepared.mechanism;
  of.q = static_cast<int>(equations_.q.size());
  of.v = static_cast<int>(equations_.v.size());
  of.row = static_cast<int>(equations_.rows.size());
  of.q_sign.assign(static_cast<std::size_t>(mechanism.nq), 1);
  of.v_sign.assign(static_cast<std::size_t>(mechanism.nv), 1);
  std::vector<EquationArgument> q(of.q_sign.size());
  std::vector<EquationArgument> v(of.v_sign.size());
  for (const Signal& signal : output_signals(scene_)) {
    if (signal.joint < 0 || signal.level > 1) continue;
    const JointPlace& place = prepared_.reduced.joints[static_cast<std::size_t>(signal.joint)];
    if (place.role != JointPlace::Role::tree || place.island != static_cast<int>(island)) continue;
    const bool is_rate = signal.level == 1;
    const auto k = static_cast<std::size_t>(is_rate ? place.iv : place.iq) + static_cast<std::size_t>(signal.component);
    const double sign = (is_rate ? place.v_sign : place.q_sign)[static_cast<std::size_t>(signal.component)];
    (is_rate ? of.v_sign : of.q_sign)[k] = sign;
    const double start = sign * (is_rate ? prepared.start.v : prepared.start.q)[k];
    (is_rate ? v : q)[k] = {signal.name, signal.unit, signal.description, start};
  }
  std::ranges::move(q, std::back_inserter(equations_.q));
  std::ranges::move(v, std::back_inserter(equations_.v));
  for (const Cut& cut : mechanism.cuts) {
    for (int r = 0; r < cut.rows; ++r) equations_.rows.push_back(name_of(cut, scene_));
  }
  for (const CoordinateRow& row : mechanism.coordinate_rows)
    equations_.rows.push_back(scene_.constraints[static_cast<std::size_t>(row.constraint)].name);
}

// Inputs, the time and the element states of all islands.
void TracedScene::name_inputs() {
  for (const Signal& signal : input_signals(scene_))
    equations_.u.push_back({signal.name, signal.unit, signal.description, signal.start});
  if (reads_time(scene_)) equations_.u.push_back({"t", "s", "time", 0});
  signals_ = equations_.u.size();
  equations_.reads_time = reads_time(scene_);
  equations_.inputs = static_cast<int>(signals_) - (equations_.reads_time ? 1 : 0);
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    arguments_[i].state = static_cast<int>(equations_.u.size());
    for (const int number : prepared_.islands[i].mechanism.states) {
      const ElementState& state = scene_.states[static_cast<std::size_t>(number)];
      equations_.u.push_back({state.name, state.unit, "element state", state.start});
      equations_.states.push_back(state.name);
    }
  }
}

// Of prescribed motions, that are no inputs: value, speed and acceleration.
void TracedScene::name_targets(std::size_t island, IslandArguments& of) {
  static constexpr const char* of_order[] = {"value", "speed", "acceleration"};
  const Mechanism& mechanism = prepared_.islands[island].mechanism;
  of.targets.assign(3 * mechanism.coordinate_rows.size(), -1);
  for (std::size_t i = 0; i < mechanism.coordinate_rows.size(); ++i) {
    const CoordinateRow& row = mechanism.coordinate_rows[i];
    if (!row.moves()) continue;
    row.for_inputs([&](int input, int order) {
      if (order < 3) of.targets[3 * i + static_cast<std::size_t>(order)] = input;
    });
    const std::string& name = scene_.constraints[static_cast<std::size_t>(row.constraint)].name;
    equations_.prescribed.push_back(name);
    const MotionLaw::Derivatives start = row.law ? row.law->at(0) : MotionLaw::Derivatives{row.constant};
    for (std::size_t order = row.holds_position ? 0 : 1; order < 3; ++order) {
      int& target = of.targets[3 * i + order];
      if (target >= 0) continue;
      target = static_cast<int>(equations_.u.size());
      const std::string text = std::string(of_order[order]) + " of the motion that " + name + " prescribes";
      equations_.u.push_back({name + "." + of_order[order], "", text, start[order]});
    }
  }
}

void TracedScene::note_size(std::size_t island) {
  const Mechanism& mechanism = prepared_.islands[island].mechanism;
  double length = 1;
  for (const Link& link : mechanism.links) length += link.X_PJ.p.norm();
  equations_.length = std::max(equations_.length, length);
  if (make_dynamics(mechanism, loads_[island])->kinks().count() > 0) equations_.has_kinks = true;
}

// What the equations leave out, and what they cannot say.
void TracedScene::note_modes(std::size_t island, IslandArguments& of, std::vector<std::string>& refused) {
  const Mechanism& mechanism = prepared_.islands[island].mechanism;
  const Loads& loads = loads_[island];
  const std::string prefix = prefix_of(scene_);
  const auto refuse = [&](const std::string& what) { refused.push_back(prefix + what); };
  std::vector<std::string> names;  // by force with modes
  const auto note = [&](const auto& force, bool of_cut) {
    using Law = std::decay_t<decltype(force.element)>;
    const std::string& name = names.emplace_back(coordinate_name(force.joint, force.component));
    const std::string group(Law::group);
    of.slides.push_back(Sticks<Law>);
    if constexpr (HoldsJoint<Law>) {
      if (force.component > 0) return;
      const std::string& joint = scene_.joints[static_cast<std::size_t>(force.joint)].name;
      if (force.element.inputs().empty())
        return refuse("joints." + joint +
                      ".lock: found a lock that is always engaged; expected a joint of type weld, or an input that "
                      "engages the lock");
      equations_.notes.push_back(joint + ": its " + group + " is left out; the equations hold while it is released.");
    } else if constexpr (Sticks<Law>) {
      if (of_cut)
        return refuse(name +
                      ": found friction of a joint that closes a loop; equations can be handed out for friction "
                      "of joints of the tree only");
      equations_.notes.push_back(name +
                                 ": friction acts as in sliding; that it may hold the joint at rest is left out.");
    } else {
      equations_.notes.push_back(name + ": its " + group + " is left out; the equations hold where it is not reached.");
    }
  };
  loads.tree.each_switching([&](const auto& force) { note(force, false); });
  for (const JointLoads& cut : loads.cuts) cut.each_switching([&](const auto& force) { note(force, true); });
  for (const int force : friction_by_loads(mechanism, loads))
    refuse(names[static_cast<std::size_t>(force)] +
           ": found friction that depends on the forces in bearings, guides or gears, which the equations determine; "
           "expected friction by numbers or by expressions of the speed");
  note_contents(island, refused);
}

// The same of what joints do not have along single coordinates.
void TracedScene::note_contents(std::size_t island, std::vector<std::string>& refused) {
  const Mechanism& mechanism = prepared_.islands[island].mechanism;
  const Loads& loads = loads_[island];
  const std::string prefix = prefix_of(scene_);
  const auto refuse = [&](const std::string& what) { refused.push_back(prefix + what); };
  for (const LinkFriction& friction : mechanism.frictions)
    refuse(name_of_touching_law(scene_, friction.contact) +
           ": found friction along several velocities together; equations can be handed out for friction along single "
           "coordinates only");
  for (const int contact : mechanism.contact_table.contacts) {
    if (contact < 0) continue;
    refuse(scene_.contacts[static_cast<std::size_t>(contact)].name +
           ": found contacts between shapes; equations are handed out for mechanisms without");
    break;
  }
  const std::string rest = ", which equations do not contain; expected names of inputs, states and coordinates";
  if (std::ranges::any_of(loads.named, [](const NamedQuantity& of) { return of.reading != nullptr; })) {
    for (const FormulaReader& reader : formula_readers(scene_)) {
      for (const std::string& signal : reader.signals) {
        if (find_sensor_output(scene_, signal))
          refuse(reader.place.name + ": found an expression that names the output '" + signal + "' of a sensor" + rest);
      }
    }
  }
  for (std::size_t k = 0; k < loads.rates.size(); ++k) {
    if (loads.rates[k].reads_forces())
      refuse(scene_.states[static_cast<std::size_t>(mechanism.states[k])].name +
             ": found a rate that depends on forces or accelerations" + rest);
  }
  if (!loads.resets.empty())
    equations_.notes.emplace_back("Jumps of states are left out: the rates hold between them.");
}

template <class T>
std::vector<T> TracedScene::targets(std::size_t island, const T* u) const {
  const IslandArguments& of = arguments_[island];
  std::vector<T> out;
  for (std::size_t i = 0; i < of.targets.size(); ++i) {
    const CoordinateRow& row = prepared_.islands[island].mechanism.coordinate_rows[i / 3];
    out.push_back(of.targets[i] >= 0 ? u[of.targets[i]] : T(i % 3 == 0 ? row.constant : 0));
  }
  return out;
}

template <class T>
std::vector<T> TracedScene::signals(std::size_t island, const T* u) const {
  std::vector<T> out(u, u + signals_);
  const int first = arguments_[island].state;
  for (int k = 0; k < loads_[island].states(); ++k) out.push_back(u[first + k]);
  return out;
}

std::vector<std::string> TracedScene::hidden_branches(std::size_t island, const RecordedIsland& recorded) const {
  static constexpr const char* found =
      "found a law with branches or a table, which equations do not contain; expected "
      "one that is smooth, or an expression without tables";
  const PreparedIsland& prepared = prepared_.islands[island];
  std::vector<std::string> out;
  const auto add = [&](const std::string& name) { out.push_back(prefix_of(scene_) + name + ": " + found); };
  for (const int force : forces_with_hidden_branches(prepared.mechanism, loads_[island], recorded))
    add(force < 0 ? "gravity_field" : scene_.forces[static_cast<std::size_t>(force)].name);
  const HiddenAtJoints at =
      joints_with_hidden_branches(prepared.mechanism, loads_[island], prepared.cut_start, recorded);
  for (const HiddenAtJoints::Along& along : at.elements) add(coordinate_name(along.joint, along.component));
  for (const int cut : at.cuts) add(name_of(prepared.mechanism.cuts[static_cast<std::size_t>(cut)], scene_));
  for (const int row : at.coordinate_rows) {
    const int constraint = prepared.mechanism.coordinate_rows[static_cast<std::size_t>(row)].constraint;
    add(scene_.constraints[static_cast<std::size_t>(constraint)].name);
  }
  for (const int state : at.states)
    add(scene_.states[static_cast<std::size_t>(prepared.mechanism.states[static_cast<std::size_t>(state)])].name);
  if (out.empty()) add(scene_.name);
  return out;
}

void TracedScene::trace(std::size_t island) {
  const recording::Recording recording(equations_.graph);
  const IslandArguments& of = arguments_[island];
  const PreparedIsland& prepared = prepared_.islands[island];
  const auto nq = static_cast<int>(equations_.q.size());
  const auto nv = static_cast<int>(equations_.v.size());
  RecordedIsland recorded;
  for (std::size_t k = 0; k < of.q_sign.size(); ++k)
    recorded.q.push_back(Recorded(of.q_sign[k]) * Recorded::variable(of.q + static_cast<int>(k)));
  for (std::size_t k = 0; k < of.v_sign.size(); ++k)
    recorded.v.push_back(Recorded(of.v_sign[k]) * Recorded::variable(nq + of.v + static_cast<int>(k)));
  std::vector<Recorded> u;
  for (std::size_t k = 0; k < equations_.u.size(); ++k) u.push_back(Recorded::variable(nq + nv + static_cast<int>(k)));
  recorded.targets = targets(island, u.data());
  recorded.signals = signals(island, u.data());
  try {
    record(prepared.mechanism, loads_[island], prepared.cut_start, recorded);
  } catch (const recording::HiddenBranch&) {
    // Named quantities are as unknown as inputs.
    for (int k = nq + nv + static_cast<int>(u.size());
         static_cast<int>(recorded.signals.size()) < loads_[island].signals(); ++k)
      recorded.signals.push_back(Recorded::variable(k));
    throw SceneError(hidden_branches(island, recorded));
  }
  // From the mechanism's signs to the user's.
  const auto n = of.v_sign.size();
  for (std::size_t k = 0; k < n; ++k) {
    recorded.h[k] *= Recorded(of.v_sign[k]);
    for (std::size_t i = 0; i < n; ++i) recorded.M[k * n + i] *= Recorded(of.v_sign[k] * of.v_sign[i]);
  }
  for (std::size_t i = 0; i < recorded.J.size(); ++i) recorded.J[i] *= Recorded(of.v_sign[i % n]);
  for (std::size_t k = 0; k < of.q_sign.size(); ++k) recorded.qdot[k] *= Recorded(of.q_sign[k]);

  SceneEquations& out = equations_;
  const expression::Term zero = out.graph.constant(0);
  const auto all = static_cast<std::size_t>(nv);
  const auto first = static_cast<std::size_t>(of.v);
  if (out.M.empty()) out.M.assign(all * all, zero);
  const std::vector<expression::Term> M = terms(recorded.M);
  for (std::size_t k = 0; k < M.size(); ++k) out.M[(first + k / n) * all + first + k % n] = M[k];
  const std::vector<expression::Term> J = terms(recorded.J);
  const std::size_t rows_before = out.J.size();
  out.J.resize(rows_before + recorded.gamma.size() * all, zero);
  for (std::size_t k = 0; k < J.size(); ++k) out.J[rows_before + k / n * all + first + k % n] = J[k];
  append(recorded.h, out.h);
  append(recorded.gamma, out.gamma);
  append(recorded.Phi, out.Phi);
  append(recorded.rate, out.rate);
  append(recorded.qdot, out.qdot);
  append(recorded.rates, out.rates);
  const Recorded before_kinetic = out.kinetic < 0 ? Recorded(0) : Recorded::of(out.kinetic);
  const Recorded before_potential = out.potential < 0 ? Recorded(immobile_energy_) : Recorded::of(out.potential);
  out.kinetic = (before_kinetic + recorded.kinetic).term();
  out.potential = (before_potential + recorded.potential).term();
}

}  // namespace gelenk

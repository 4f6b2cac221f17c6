// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/loads.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "element/forces/force.h"
#include "element/joint_forces/registry.h"
#include "element/locking.h"
#include "element/motors/registry.h"
#include "joint/kinds.h"
#include "preparation/signal_binder.h"
#include "scene/element_numbers.h"
#include "scene/formulas.h"
#include "scene/motions.h"
#include "scene/signals.h"
#include "scene/touching_laws.h"

namespace gelenk {
namespace {

// Removes all loads; the lists keep their capacity.
void clear(Loads& loads) {
  const auto clear_list = [](auto& list) { list.clear(); };
  each_list(loads.tree.lists, clear_list);
  for (JointLoads& cut : loads.cuts) each_list(cut.lists, clear_list);
  clear_forces(*loads.forces);
  loads.inputs.clear();
  loads.rates.clear();
  loads.resets.clear();
  loads.values.clear();
  loads.named.clear();
  loads.losses.clear();
  loads.motions.clear();
  loads.potential_offset = 0;
}

// Whether the element exerts no force with its current parameters.
template <class E>
bool is_idle(const E& element) {
  if constexpr (requires { element.is_idle(); }) return element.is_idle();
  return false;
}

// Fills `out` with the loads of a scene, one entry per island.
struct LoadCollector {
  const Scene& scene;
  const ReducedScene& reduced;
  const std::unordered_map<std::string_view, int>&body_number, &joint_number;
  SignalBinder binder;
  std::vector<Loads>& out;
  std::vector<int> branches{};          // by island: of its expressions so far
  std::optional<FormulaNames> names{};  // once a motion has asked for them

  void prepare() {
    out.resize(reduced.islands.size());
    branches.assign(out.size(), 0);
    for (std::size_t i = 0; i < out.size(); ++i) prepare(reduced.islands[i], out[i]);
  }

  void prepare(const Mechanism& mechanism, Loads& loads) const {
    clear(loads);
    loads.R_0W = mechanism.X_W0.R.transpose();
    loads.p_W0 = mechanism.X_W0.p;
    loads.gravity = loads.R_0W * scene.gravity;
    for (std::size_t i = 1; i < mechanism.links.size(); ++i) {
      const Spatial::Inertia& G = mechanism.links[i].G;
      loads.potential_offset -= G.m * scene.gravity.dot(mechanism.X_W0.p);
      if (mechanism.planar) loads.potential_offset -= loads.gravity.z() * (G.m * mechanism.heights[i] + G.h.z());
    }
    // Capacity also for idle loads, which are omitted but may become active when parameters change.
    reserve_capacity(loads.tree, mechanism.nv);
    loads.cuts.resize(mechanism.cuts.size());
    for (std::size_t c = 0; c < mechanism.cuts.size(); ++c) reserve_capacity(loads.cuts[c], mechanism.cuts[c].nv);
    loads.added_inertia.assign(mechanism.nv, 0);
    if (loads.branches == nullptr) loads.branches = std::make_shared<HeldBranches>();
    loads.contacts = touching_laws(scene);
  }

  static void reserve_capacity(JointLoads& loads, int nv) {
    std::apply([&](const auto&... kind) { (reserve(loads, kind, nv), ...); }, JointForces().all());
  }
  template <class E>
  static void reserve(JointLoads& loads, const E&, int nv) {
    std::get<std::vector<AlongCoordinate<E>>>(loads.lists).reserve(static_cast<std::size_t>(nv));
  }
  template <class E>
  static void reserve(JointLoads&, const std::optional<E>&, int) {}

  // The list for forces along a joint; null if the joint is immobile or has been replaced.
  JointLoads* along(const JointPlace& place) const {
    if (place.role == JointPlace::Role::merged || place.role == JointPlace::Role::rod) return nullptr;
    Loads& loads = out[place.island];
    return place.role == JointPlace::Role::cut ? &loads.cuts[place.index] : &loads.tree;
  }

  void motor(int m, int input) {
    const Motor& motor = scene.motors[m];
    const JointPlace& place = reduced.joints[joint_number.at(motor.joints.front())];
    JointLoads* const to = along(place);
    if (to == nullptr) return;
    Loads& loads = out[place.island];
    for (int i = 0; i < input_count(*motor.is); ++i) loads.inputs.push_back(input + i);
    const bool cut = place.role == JointPlace::Role::cut;
    const int j = joint_number.at(motor.joints.front());
    const int along = component_of(kind_of(*scene.joints[j].is), motor.coordinate);
    std::visit(
        [&]<class E>(const E& element) {
          add(*to, element, place, cut, along, input, j);
          std::get<std::vector<AlongCoordinate<E>>>(to->lists).back().owner = m;
        },
        *motor.is);
    if (!cut) loads.added_inertia[place.iv + along] += inertia_of(*motor.is);
  }

  void effort(const JointEffort& effort) {
    const int j = joint_number.at(effort.joint);
    const JointPlace& place = reduced.joints[j];
    JointLoads* const to = along(place);
    if (to == nullptr) return;
    add(*to, JointLaw{.force = effort.value}, place, place.role == JointPlace::Role::cut, 0, 0, j);
    const auto of = std::ranges::find(scene.components, effort.component, &Component::name) - scene.components.begin();
    std::get<std::vector<AlongCoordinate<JointLaw>>>(to->lists).back().owner = static_cast<int>(of);
  }
  void inertia(const Component& component) {
    if (component.joints.empty()) return;
    const JointPlace& place = reduced.joints[joint_number.at(component.joints.front())];
    if (along(place) == nullptr || place.role == JointPlace::Role::cut) return;
    out[place.island].added_inertia[place.iv] += inertia_of(*component.is);
  }

  // input: its first one.
  void joint(int j, int input) {
    const JointPlace& place = reduced.joints[j];
    JointLoads* const to = along(place);
    if (to == nullptr) return;
    const std::vector<Stored<JointForces>>& forces = scene.joints[j].along;
    for (int i = 0; i < static_cast<int>(forces.size()); ++i) {
      std::apply(
          [&](const auto&... force) {
            ((add_if_active(*to, force, place, i, input, j), input += own_input_count(force)), ...);
          },
          forces[i]->all());
    }
  }

  template <class E>
  static int own_input_count(const E& element) {
    if constexpr (requires { *element; }) {
      return element ? count_of(own_inputs(*element)) : 0;
    } else {
      return count_of(own_inputs(element));
    }
  }

  template <class E>
  void add_if_active(JointLoads& to, const E& element, const JointPlace& place, int i, int input, int joint) {
    const bool cut = place.role == JointPlace::Role::cut;
    for (int k = 0; k < own_input_count(element); ++k) out[place.island].inputs.push_back(input + k);
    if constexpr (requires { *element; }) {
      if (element) add(to, *element, place, cut, i, input, joint);
    } else {
      if (!is_idle(element)) add(to, element, place, cut, i, input, joint);
    }
  }

  template <class E>
  void add(JointLoads& to, const E& element, const JointPlace& place, bool cut, int i, int input, int joint) {
    const auto push_along = [&](const E& part, int i) {
      std::get<std::vector<AlongCoordinate<E>>>(to.lists).push_back(
          {part, (cut ? 0 : place.iq) + i, (cut ? 0 : place.iv) + i, place.v_sign[i], input, joint, i});
    };
    const auto push = [&](const E& part) { push_along(part, i); };
    push(element);
    if constexpr (HoldsJoint<E>) {
      for (int k = 1; k < static_cast<int>(place.v_sign.size()); ++k) push_along(element, k);
    }
    if constexpr (HasFormula<E>) {
      auto& added = std::get<std::vector<AlongCoordinate<E>>>(to.lists).back();
      if (added.has_formula()) bind(added.element.formula(), place.island);
    }
    if constexpr (requires { element.excess(); }) {
      if (const std::optional<E> part = element.excess()) push(*part);
    }
  }

  void gravity_field() {
    for (std::size_t b = 0; scene.gravity_field && b < scene.bodies.size(); ++b) {
      const Body& body = scene.bodies[b];
      const int island = reduced.bodies[b].island;
      if (island < 0 || body.mass == 0) continue;
      const BodyFrame at{.body = body.name, .X_BF = {Eigen::Matrix3d::Identity(), body.com}};
      add_gravity(*out[static_cast<std::size_t>(island)].forces, *scene.gravity_field, body.mass, attach(island, at));
    }
  }

  // Binds the expressions of forces between bodies.
  void bind_forces() {
    for (int i = 0; i < static_cast<int>(out.size()); ++i)
      each_formula(*out[static_cast<std::size_t>(i)].forces, [&](Formula& formula, int) { bind(formula, i); });
  }

  void bind(Formula& formula, int island) {
    int& first = branches[static_cast<std::size_t>(island)];
    bind_signals(formula, island);
    formula.bind_branches(out[static_cast<std::size_t>(island)].branches.get(), first);
    first += formula.branches();
  }

  void bind_signals(Formula& formula, int island) {
    Loads& loads = out[static_cast<std::size_t>(island)];
    binder.bind(formula, reduced.islands[static_cast<std::size_t>(island)], loads);
    for (const int signal : formula.signals()) {
      const bool is_given = signal >= 0 && signal < loads.first_named();  // -1: a force
      if (is_given && std::ranges::find(loads.inputs, signal) == loads.inputs.end()) loads.inputs.push_back(signal);
    }
  }

  void states() {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i].first_state = binder.signals();
      for (const int number : reduced.islands[i].states) {
        const ElementState& state = scene.states[static_cast<std::size_t>(number)];
        out[i].rates.push_back(state.rate);
        out[i].rates.back().set_sizes(size_of(state, scene.units), {});
        for (const StateReset& reset : state.resets) {
          out[i].resets.push_back({static_cast<int>(out[i].rates.size()) - 1, reset.when, reset.to});
          out[i].resets.back().to.set_sizes(size_of(state, scene.units), {});
        }
      }
    }
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (Formula& rate : out[i].rates) bind(rate, static_cast<int>(i));
      for (PlacedReset& reset : out[i].resets) {
        bind(reset.when, static_cast<int>(i));
        bind_signals(reset.to, static_cast<int>(i));  // its kinks are no events
      }
      for (const int number : reduced.islands[i].expressions) {
        const NamedExpression& of = scene.expressions[static_cast<std::size_t>(number)];
        Formula& value = out[i].values.emplace_back(of.value);
        value.set_sizes(scene.units.size_of(of.unit), {});
        binder.bind(value, reduced.islands[i], out[i]);  // its kinks are no events
      }
    }
  }

  // Only the acceleration may have kinks.
  MotionOfSignals bound_motion(const Constraint& constraint, int island) {
    if (!names) names = formula_names(scene);
    MotionOfSignals of = motion_of_signals(scene, *find_motion_of_signals(constraint), *names);
    for (Formula& formula : of) {
      if (!formula.is_given()) continue;
      &formula == &of.back() ? bind(formula, island) : bind_signals(formula, island);
    }
    return of;
  }

  // Registers the inputs of coordinate constraints, and binds the expressions of their losses.
  void coordinate_rows() {
    for (std::size_t i = 0; i < reduced.islands.size(); ++i) {
      for (const CoordinateRow& row : reduced.islands[i].coordinate_rows) {
        row.for_inputs([&](int input, int) { out[i].inputs.push_back(input); });
        const Constraint& constraint = scene.constraints[static_cast<std::size_t>(row.constraint)];
        std::array<Formula, 3>& motion = out[i].motions.emplace_back();
        if (row.follows_signals) motion = bound_motion(constraint, static_cast<int>(i));
        MeshLosses& added = out[i].losses.emplace_back(losses_of(*constraint.is));
        MeshLosses::each(added, [&](Formula& formula) {
          MeshLosses::names_load(formula) ? bind_signals(formula, static_cast<int>(i))
                                          : bind(formula, static_cast<int>(i));
        });
      }
    }
  }

  void force(int f, int input) {
    const Force& force = scene.forces[f];
    int island = -1;
    for (const BodyFrame& frame : force.frames) island = std::max(island, island_of(frame));
    if (island < 0) return;
    for (int i = 0; i < input_count(*force.is); ++i) out[island].inputs.push_back(input + i);
    std::array<Attachment, max_force_ports> at;
    for (std::size_t k = 0; k < force.frames.size(); ++k) at[k] = attach(island, force.frames[k]);
    add_force(*out[island].forces, *force.is, at, input, f);
  }

 private:
  // -1: immobile.
  int island_of(const BodyFrame& frame) const {
    return frame.body == ground ? -1 : reduced.bodies[body_number.at(frame.body)].island;
  }

  Attachment attach(int island, const BodyFrame& frame) const {
    const BodyPlace found = place(scene, reduced, island, frame);
    const Mechanism& mechanism = reduced.islands[island];
    return {found.link, found.X_LB.p, found.X_LB.R, mechanism.planar ? mechanism.heights[found.link] : 0};
  }
};

}  // namespace

LoadAssembler::LoadAssembler(const Scene& scene, const ReducedScene& reduced)
    : scene_(scene), reduced_(reduced), inputs_(first_inputs(scene)) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) body_number_[scene.bodies[b].name] = static_cast<int>(b);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) joint_number_[scene.joints[j].name] = static_cast<int>(j);
}

void LoadAssembler::fill(std::vector<Loads>& loads) const {
  LoadCollector collector{
      scene_, reduced_, body_number_, joint_number_, SignalBinder(scene_, reduced_, inputs_.back().front()), loads};
  collector.prepare();
  collector.states();
  for (std::size_t m = 0; m < scene_.motors.size(); ++m)
    collector.motor(static_cast<int>(m), inputs_[sections::motors][m]);
  for (const Component& component : scene_.components) collector.inertia(component);
  for (const JointEffort& effort : scene_.efforts) collector.effort(effort);
  for (int j = 0; j < static_cast<int>(scene_.joints.size()); ++j)
    collector.joint(j, inputs_[sections::joints][static_cast<std::size_t>(j)]);
  for (std::size_t f = 0; f < scene_.forces.size(); ++f) {
    collector.force(static_cast<int>(f), inputs_[sections::forces][f]);
  }
  collector.gravity_field();
  collector.bind_forces();
  collector.coordinate_rows();
  for (Loads& of : loads) {
    of.only_along_tree =
        is_empty(*of.forces) && std::ranges::all_of(of.cuts, [](const JointLoads& on) { return on.empty(); });
  }
}

std::vector<Loads> make_loads(const Scene& scene, const ReducedScene& reduced) {
  std::vector<Loads> loads;
  LoadAssembler(scene, reduced).fill(loads);
  return loads;
}

namespace {

// Potential energy [J] of an element at the coordinate q.
template <class E>
double stored_energy(const E& element, double q) {
  if constexpr (requires { element.energy(q); }) return element.energy(q);
  return 0;
}
template <class E>
double stored_energy(const std::optional<E>& element, double q) {
  return element ? stored_energy(*element, q) : 0;
}

// Potential energy [J] of a force whose ports are all immobile; 0 otherwise.
double immobile_energy(const Scene& scene, const ReducedScene& reduced, const Force& force) {
  std::array<Pose3, max_force_ports> at;
  for (std::size_t k = 0; k < force.frames.size(); ++k) {
    const BodyPlace found = place(scene, reduced, -1, force.frames[k]);
    if (found.island >= 0) return 0;
    at[k] = found.X_LB;
  }
  return energy_at(*force.is, at);
}

}  // namespace

double immobile_energy(const Scene& scene, const ReducedScene& reduced) {
  double sum = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const BodyPlace& place = reduced.bodies[b];
    if (place.island < 0) sum -= scene.bodies[b].mass * scene.gravity.dot(place.X_LB.point(scene.bodies[b].com));
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const std::vector<Stored<JointForces>>& along = scene.joints[j].along;
    const std::vector<double>& q = reduced.joints[j].q;
    for (std::size_t i = 0; i < q.size() && i < along.size(); ++i) {
      if (!find_joint_kind(scene.joints[j].type)->springs()) continue;
      std::apply([&](const auto&... force) { ((sum += stored_energy(force, q[i])), ...); }, along[i]->all());
    }
  }
  for (const Force& force : scene.forces) sum += immobile_energy(scene, reduced, force);
  return sum;
}

}  // namespace gelenk

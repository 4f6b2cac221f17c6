// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/dependencies.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "joint/kinds.h"
#include "scene/formulas.h"
#include "scene/name_index.h"
#include "scene/touching_laws.h"
#include "simulation/start_report.h"
#include "util/disjoint_sets.h"

namespace gelenk {
namespace {

Knowns listed(const std::set<int>& indices) {
  return std::make_shared<const std::vector<int>>(indices.begin(), indices.end());
}

// The knowns on which the outputs of one island can depend.
struct IslandKnowns {
  std::set<int> positions, states;  // the coordinates among the states; all states
  int speeds = 0;                   // number of velocities among the states
  Knowns of_positions, of_states;   // `positions` and `states` as lists

  void list() {
    of_positions = listed(positions);
    of_states = listed(states);
  }
};

// The bodies at an element's ports, one of the two for a joint, without the ground.
std::vector<int> moving_bodies(const Scene& scene, const NameIndex& numbers, const ElementPlace& element) {
  std::vector<int> out;
  for (const BodyFrame& frame : element.frames) out.push_back(numbers.body(frame.body));
  for (const std::string& name : element.joints) {
    if (name.empty()) continue;
    const Joint& joint = scene.joints[static_cast<std::size_t>(numbers.joint(name))];
    const int child = numbers.body(joint.child.body);
    out.push_back(child >= 0 ? child : numbers.body(joint.parent.body));
  }
  std::erase(out, -1);
  return out;
}

// For each body of the scene, the number of its cluster: bodies connected by joints, not via the ground. A force
// directly affects the accelerations of its own cluster only; it acts on the rest of the island through springs, that
// is, through states.
std::vector<int> clusters_of(const Scene& scene, const NameIndex& numbers) {
  DisjointSets sets(scene.bodies.size());
  for (const Joint& joint : scene.joints) {
    const int parent = numbers.body(joint.parent.body);
    const int child = numbers.body(joint.child.body);
    if (parent >= 0 && child >= 0) sets.join(parent, child);
  }
  // Constraints transmit forces directly, too.
  for (const Constraint& constraint : scene.constraints) {
    const std::vector<int> bodies = moving_bodies(scene, numbers, constraint);
    for (std::size_t i = 1; i < bodies.size(); ++i) sets.join(bodies[0], bodies[i]);
  }
  std::vector<int> out;
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) out.push_back(sets.find(b));
  return out;
}

// Parameters that move joints can couple islands and make immobile loops movable.
bool geometry_may_change(const Scene& scene) {
  return std::ranges::any_of(scene.parameters,
                             [](const std::string& path) { return path.find(".position") != std::string::npos; });
}

class DependencyAnalysis {
 public:
  DependencyAnalysis(const Simulation& simulation, const Catalog& catalog)
      : scene_(simulation.scene()),
        reduced_(StartReport(simulation).prepared().reduced),
        signals_(simulation.outputs()),
        catalog_(catalog),
        numbers_(scene_),
        islands_(reduced_.islands.size()),
        cluster_(clusters_of(scene_, numbers_)),
        inputs_of_(scene_.bodies.size()) {
    collect_states(simulation);
    collect_inputs(simulation.inputs());
  }

  std::vector<Knowns> run() {
    std::vector<Knowns> out(catalog_.variables().size(), no_knowns_);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Variable& v = catalog_.variables()[i];
      if (v.source == Source::rate) out[i] = of_rate(catalog_.rates()[static_cast<std::size_t>(v.index)], out);
      if (v.source != Source::output) continue;
      const Signal& signal = signals_[static_cast<std::size_t>(v.index)];
      const auto variable = static_cast<int>(i);
      out[i] = signal.joint >= 0                    ? of_joint(signal, variable)
               : signal.section >= sections::states ? of_named(signal, variable)
                                                    : of_element(signal);
    }
    return out;
  }

 private:
  void collect_states(const Simulation& simulation) {
    for (const State& state : catalog_.states()) {
      const Variable& v = catalog_.variables()[static_cast<std::size_t>(state.variable)];
      const Signal& signal = signals_[static_cast<std::size_t>(v.index)];
      IslandKnowns& island = islands_[static_cast<std::size_t>(island_of_named(signal))];
      if (signal.level == 0) island.positions.insert(state.variable);
      if (signal.level == 1) ++island.speeds;
      island.states.insert(state.variable);
    }
    for (std::size_t p = 0; p < islands_.size(); ++p) {
      const MobilityAnalysis& mobility = StartReport(simulation).prepared().islands[p].mobility;
      // Inputs that prescribe motions determine all coupled motions directly.
      structure_is_known_ = structure_is_known_ && islands_[p].speeds == reduced_.islands[p].nv - mobility.rank &&
                            !follows_input(reduced_.islands[p]);
      all_islands_.positions.insert(islands_[p].positions.begin(), islands_[p].positions.end());
      all_islands_.states.insert(islands_[p].states.begin(), islands_[p].states.end());
    }
    // Which bodies touch changes during a run.
    structure_is_known_ = structure_is_known_ && !geometry_may_change(scene_) && !has_touching_laws(scene_);
    for (IslandKnowns& island : islands_) island.list();
    all_islands_.list();
  }

  int island_of_named(const Signal& signal) const {
    if (signal.joint >= 0) return reduced_.joints[static_cast<std::size_t>(signal.joint)].island;
    const auto has = [&](const Mechanism& of) {
      const std::vector<int>& among = signal.section == sections::states ? of.states : of.expressions;
      return std::ranges::find(among, signal.element) != among.end();
    };
    return static_cast<int>(std::ranges::find_if(reduced_.islands, has) - reduced_.islands.begin());
  }

  // Inputs are the first variables.
  void collect_inputs(const std::vector<Signal>& inputs) {
    std::set<int> all;
    for (int i = 0; i < static_cast<int>(inputs.size()); ++i) {
      const Signal& input = inputs[static_cast<std::size_t>(i)];
      all.insert(i);
      if (input.section == sections::constraints) continue;  // a prescribed motion: see structure_is_known_
      for (const ElementPlace& on : places_of(input)) {
        for (const int body : moving_bodies(scene_, numbers_, on))
          inputs_of_[static_cast<std::size_t>(cluster_[static_cast<std::size_t>(body)])].insert(i);
      }
    }
    all.insert(all_islands_.states.begin(), all_islands_.states.end());
    all_knowns_ = listed(all);
  }

  // Where an input acts.
  std::vector<ElementPlace> places_of(const Signal& input) const {
    if (input.section >= 0) return {element_of(input)};
    if (input.joint >= 0) return {joint_place(input.joint)};
    return readers_of(scene_, input.name);
  }

  const ElementPlace& element_of(const Signal& signal) const {
    const ElementPlace* out = nullptr;
    int section = 0;
    each_section(scene_, [&](const Section&, const auto& elements) {
      if (section++ == signal.section) out = &elements[static_cast<std::size_t>(signal.element)];
    });
    return *out;
  }

  ElementPlace joint_place(int joint) const {
    return {
        .name = {}, .frames = {}, .joints = {scene_.joints[static_cast<std::size_t>(joint)].name}, .coordinate = {}};
  }

  static bool follows_input(const Mechanism& mechanism) {
    return std::ranges::any_of(mechanism.coordinate_rows, [](const CoordinateRow& row) { return row.input >= 0; });
  }

  // island: -1 for what is immobile.
  const IslandKnowns& knowns_of(int island) const {
    if (!structure_is_known_) return all_islands_;
    return island < 0 ? immobile_ : islands_[static_cast<std::size_t>(island)];
  }

  // The states of an island and the inputs that act directly on these bodies.
  Knowns of_accelerations(const std::vector<int>& bodies, int island) {
    if (!structure_is_known_) return all_knowns_;
    std::set<int> clusters;
    for (const int body : bodies) clusters.insert(cluster_[static_cast<std::size_t>(body)]);
    Knowns& out = accelerations_[{island, clusters}];
    if (out) return out;
    std::set<int> on = knowns_of(island).states;
    for (const int cluster : clusters) {
      const std::set<int>& inputs = inputs_of_[static_cast<std::size_t>(cluster)];
      on.insert(inputs.begin(), inputs.end());
    }
    out = listed(on);
    return out;
  }

  Knowns of_joint(const Signal& signal, int variable) {
    const auto j = static_cast<std::size_t>(signal.joint);
    const JointPlace& place = reduced_.joints[j];
    const bool moves = place.role != JointPlace::Role::merged;
    const IslandKnowns& p = knowns_of(moves ? place.island : -1);
    if (p.states.contains(variable)) return of_state(signal, variable);
    if (!structure_is_known_) return all_knowns_;
    if (signal.level >= 2) {
      return moves ? of_accelerations(moving_bodies(scene_, numbers_, joint_place(signal.joint)), place.island)
                   : no_knowns_;
    }
    return signal.level == 0 ? p.of_positions : p.of_states;
  }

  // A state depends on itself; a component of a quaternion on all four, through their normalization.
  Knowns of_state(const Signal& signal, int variable) const {
    const JointKind& kind = *find_joint_kind(scene_.joints[static_cast<std::size_t>(signal.joint)].type);
    if (signal.level != 0 || !kind.is_of_quaternion(signal.component)) return listed({variable});
    const int first = variable - (signal.component - (kind.nq - 4));
    return listed({first, first + 1, first + 2, first + 3});
  }

  // The rate of a component of a quaternion depends on the states of the joint. found: of all outputs.
  Knowns of_rate(const Rate& rate, const std::vector<Knowns>& found) const {
    if (rate.same_as >= 0) return found[static_cast<std::size_t>(catalog_.output_variable(rate.same_as))];
    const JointPlace& place = reduced_.joints[static_cast<std::size_t>(rate.joint)];
    return structure_is_known_ ? knowns_of(place.role == JointPlace::Role::merged ? -1 : place.island).of_states
                               : all_knowns_;
  }

  // An element state depends on itself; its rate, and a named expression, on the states of its island and the inputs
  // that the expression names.
  Knowns of_named(const Signal& signal, int variable) {
    const bool is_state = signal.section == sections::states;
    if (is_state && signal.group == 0) return listed({variable});
    if (!structure_is_known_) return all_knowns_;
    std::set<int> on = knowns_of(island_of_named(signal)).states;
    const auto element = static_cast<std::size_t>(signal.element);
    const Formula& formula = is_state ? scene_.states[element].rate : scene_.expressions[element].value;
    const std::span<const std::string> names = formula.signal_names();
    for (std::size_t i = 0; i < catalog_.variables().size(); ++i) {
      const Variable& v = catalog_.variables()[i];
      if (v.source == Source::input && std::ranges::find(names, v.name) != names.end()) on.insert(static_cast<int>(i));
    }
    if (formula.reads_forces()) add_all_inputs(island_of_named(signal), on);
    return listed(on);
  }

  // Those that act anywhere on an island.
  void add_all_inputs(int island, std::set<int>& on) const {
    for (std::size_t body = 0; body < scene_.bodies.size(); ++body) {
      if (reduced_.bodies[body].island != island) continue;
      const std::set<int>& inputs = inputs_of_[static_cast<std::size_t>(cluster_[body])];
      on.insert(inputs.begin(), inputs.end());
    }
  }

  Knowns of_element(const Signal& signal) {
    if (!structure_is_known_) return all_knowns_;
    const ElementPlace& element = element_of(signal);
    const bool whole = signal.section == sections::sensors &&
                       kind_of(*scene_.sensors[static_cast<std::size_t>(signal.element)].is).of_whole;
    const int island = island_of(element);
    if (signal.section == sections::constraints && island < 0) return no_knowns_;
    if (signal.stage == Stage::acceleration) {
      return of_accelerations(moving_bodies(scene_, numbers_, element), island);
    }
    const IslandKnowns& from = whole ? all_islands_ : knowns_of(island);
    return signal.stage == Stage::position ? from.of_positions : from.of_states;
  }

  // The island on which an element acts; -1 if all its ports are immobile.
  int island_of(const ElementPlace& element) const {
    int out = -1;
    for (const BodyFrame& frame : element.frames) out = std::max(out, place(scene_, reduced_, -1, frame).island);
    for (const std::string& name : element.joints) {
      if (name.empty()) continue;
      out = std::max(out, reduced_.joints[static_cast<std::size_t>(numbers_.joint(name))].island);
    }
    return out;
  }

  const Scene& scene_;
  const ReducedScene& reduced_;
  const std::vector<Signal>& signals_;
  const Catalog& catalog_;
  NameIndex numbers_;
  std::vector<IslandKnowns> islands_;
  std::vector<int> cluster_;                                       // by body
  std::vector<std::set<int>> inputs_of_;                           // by cluster
  std::map<std::pair<int, std::set<int>>, Knowns> accelerations_;  // by island and clusters
  IslandKnowns all_islands_;
  Knowns no_knowns_ = listed({});
  IslandKnowns immobile_{.positions = {}, .states = {}, .of_positions = no_knowns_, .of_states = no_knowns_};
  Knowns all_knowns_;               // states and inputs
  bool structure_is_known_ = true;  // the states determine every island, and no parameter can change the islands
};

}  // namespace

std::vector<Knowns> dependencies_of(const Simulation& simulation, const Catalog& catalog) {
  return DependencyAnalysis(simulation, catalog).run();
}

std::vector<Knowns> initial_dependencies_of(const Catalog& catalog, const std::vector<Knowns>& dependencies) {
  std::set<int> parameters;
  const auto& variables = catalog.variables();
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const bool is_method_setting = variables[i].name.starts_with("solver.") && variables[i].name != "solver.start";
    if (variables[i].source == Source::parameter && !is_method_setting) parameters.insert(static_cast<int>(i));
  }
  std::map<std::vector<int>, Knowns> with_inputs;
  std::vector<Knowns> out;
  for (const Knowns& on : dependencies) {
    std::vector<int> inputs;
    for (const int known : *on) {
      if (variables[static_cast<std::size_t>(known)].source == Source::input) inputs.push_back(known);
    }
    Knowns& initial = with_inputs[inputs];
    if (!initial) {
      std::set<int> indices = parameters;
      indices.insert(inputs.begin(), inputs.end());
      initial = listed(indices);
    }
    out.push_back(initial);
  }
  return out;
}

}  // namespace gelenk

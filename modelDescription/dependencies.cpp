// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/dependencies.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "joint/registry.h"
#include "mechanism/disjoint_sets.h"
#include "scene/name_index.h"
#include "simulation/start_report.h"

namespace gelenk {
namespace {

Knowns listed(const std::set<int>& indices) {
  return std::make_shared<const std::vector<int>>(indices.begin(), indices.end());
}

// What the outputs of one part can depend on.
struct Part {
  std::set<int> positions, states;  // states that are coordinates; those and speeds
  int speeds = 0;                   // among the states
  Knowns of_positions, of_states;   // the same, listed

  void list() {
    of_positions = listed(positions);
    of_states = listed(states);
  }
};

// The bodies at an element's ports without the ground, of a joint one of the two.
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

// By body of the scene: bodies with the same number hang together by joints, without the ground. A force is felt at
// once by these, by others of the part only through springs, so through states.
std::vector<int> clusters_of(const Scene& scene, const NameIndex& numbers) {
  DisjointSets sets(scene.bodies.size());
  for (const Joint& joint : scene.joints) {
    const int parent = numbers.body(joint.parent.body);
    const int child = numbers.body(joint.child.body);
    if (parent >= 0 && child >= 0) sets.join(parent, child);
  }
  // What constraints couple feels forces at once, too.
  for (const Constraint& constraint : scene.constraints) {
    const std::vector<int> bodies = moving_bodies(scene, numbers, constraint);
    for (std::size_t i = 1; i < bodies.size(); ++i) sets.join(bodies[0], bodies[i]);
  }
  std::vector<int> out;
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) out.push_back(sets.find(b));
  return out;
}

// Parameters that move joints can couple parts, and free what loops hold still.
bool geometry_may_change(const Scene& scene) {
  return std::ranges::any_of(scene.parameters,
                             [](const std::string& path) { return path.find(".position") != std::string::npos; });
}

class Finder {
 public:
  Finder(const Simulation& simulation, const Catalog& catalog)
      : scene_(simulation.scene()),
        reduced_(StartReport(simulation).prepared().reduced),
        signals_(simulation.outputs()),
        catalog_(catalog),
        numbers_(scene_),
        parts_(reduced_.islands.size()),
        cluster_(clusters_of(scene_, numbers_)),
        inputs_of_(scene_.bodies.size()) {
    collect_states(simulation);
    collect_inputs(simulation.inputs());
  }

  std::vector<Knowns> run() {
    std::vector<Knowns> out(catalog_.variables().size(), nothing_);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Variable& v = catalog_.variables()[i];
      if (v.source == Source::rate) out[i] = of_rate(catalog_.rates()[static_cast<std::size_t>(v.index)]);
      if (v.source != Source::output) continue;
      const Signal& signal = signals_[static_cast<std::size_t>(v.index)];
      out[i] = signal.joint >= 0 ? of_joint(signal, static_cast<int>(i)) : of_element(signal);
    }
    return out;
  }

 private:
  void collect_states(const Simulation& simulation) {
    for (const State& state : catalog_.states()) {
      const Variable& v = catalog_.variables()[static_cast<std::size_t>(state.variable)];
      const Signal& signal = signals_[static_cast<std::size_t>(v.index)];
      Part& part = parts_[static_cast<std::size_t>(reduced_.joints[static_cast<std::size_t>(signal.joint)].island)];
      if (signal.level == 0) part.positions.insert(state.variable);
      if (signal.level == 1) ++part.speeds;
      part.states.insert(state.variable);
    }
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const MobilityAnalysis& mobility = StartReport(simulation).prepared().islands[p].mobility;
      // By inputs that are motions whatever moves with them is determined at once.
      known_ =
          known_ && parts_[p].speeds == reduced_.islands[p].nv - mobility.rank && !follows_input(reduced_.islands[p]);
      whole_.positions.insert(parts_[p].positions.begin(), parts_[p].positions.end());
      whole_.states.insert(parts_[p].states.begin(), parts_[p].states.end());
    }
    known_ = known_ && !geometry_may_change(scene_);
    for (Part& part : parts_) part.list();
    whole_.list();
  }

  // They are the first variables.
  void collect_inputs(const std::vector<Signal>& inputs) {
    std::set<int> all;
    for (int i = 0; i < static_cast<int>(inputs.size()); ++i) {
      const Signal& input = inputs[static_cast<std::size_t>(i)];
      all.insert(i);
      if (input.section == sections::constraints) continue;  // whatever moves with it: see known_
      for (const int body : moving_bodies(scene_, numbers_, element_of(input))) {
        inputs_of_[static_cast<std::size_t>(cluster_[static_cast<std::size_t>(body)])].insert(i);
      }
    }
    all.insert(whole_.states.begin(), whole_.states.end());
    all_ = listed(all);
  }

  const ElementPlace& element_of(const Signal& signal) const {
    const ElementPlace* out = nullptr;
    int section = 0;
    each_section(scene_, [&](const Section&, const auto& elements) {
      if (section++ == signal.section) out = &elements[static_cast<std::size_t>(signal.element)];
    });
    return *out;
  }

  static bool follows_input(const Mechanism& mechanism) {
    return std::ranges::any_of(mechanism.coordinate_rows, [](const CoordinateRow& row) { return row.input >= 0; });
  }

  // island: none where something stands still.
  const Part& part(int island) const {
    if (!known_) return whole_;
    return island < 0 ? still_ : parts_[static_cast<std::size_t>(island)];
  }

  // The states of a part, and the inputs that bodies of it feel.
  Knowns of_accelerations(const std::vector<int>& bodies, int island) {
    if (!known_) return all_;
    std::set<int> clusters;
    for (const int body : bodies) clusters.insert(cluster_[static_cast<std::size_t>(body)]);
    Knowns& out = accelerations_[{island, clusters}];
    if (out) return out;
    std::set<int> on = part(island).states;
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
    const Part& p = part(moves ? place.island : -1);
    if (p.states.contains(variable)) return of_state(signal, variable);
    if (!known_) return all_;
    if (signal.level == 2) {
      const ElementPlace at{.name = {}, .frames = {}, .joints = {scene_.joints[j].name}, .coordinate = {}};
      return moves ? of_accelerations(moving_bodies(scene_, numbers_, at), place.island) : nothing_;
    }
    return signal.level == 0 ? p.of_positions : p.of_states;
  }

  // Itself; a quaternion's component through the length that is kept all four.
  Knowns of_state(const Signal& signal, int variable) const {
    const JointKind& kind = *find_joint_kind(scene_.joints[static_cast<std::size_t>(signal.joint)].type);
    const int component = signal.component - (kind.nq - 4);
    if (signal.level != 0 || !kind.has_quaternion() || component < 0) return listed({variable});
    const int first = variable - component;
    return listed({first, first + 1, first + 2, first + 3});
  }

  // Of a quaternion's component: by the states of its joint.
  Knowns of_rate(const Rate& rate) const {
    const JointPlace& place = reduced_.joints[static_cast<std::size_t>(rate.joint)];
    return known_ ? part(place.role == JointPlace::Role::merged ? -1 : place.island).of_states : all_;
  }

  Knowns of_element(const Signal& signal) {
    if (!known_) return all_;
    const ElementPlace& element = element_of(signal);
    const bool whole = signal.section == sections::sensors &&
                       kind_of(scene_.sensors[static_cast<std::size_t>(signal.element)].is).of_whole;
    const int island = island_of(element);
    if (signal.section == sections::constraints && island < 0) return nothing_;
    if (signal.stage == Stage::acceleration) {
      return of_accelerations(moving_bodies(scene_, numbers_, element), island);
    }
    const Part& from = whole ? whole_ : part(island);
    return signal.stage == Stage::position ? from.of_positions : from.of_states;
  }

  // -1: all that it is at stands still.
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
  std::vector<Part> parts_;
  std::vector<int> cluster_;                                       // by body
  std::vector<std::set<int>> inputs_of_;                           // by cluster
  std::map<std::pair<int, std::set<int>>, Knowns> accelerations_;  // by island and clusters
  Part whole_;
  Knowns nothing_ = listed({});
  Part still_{.positions = {}, .states = {}, .of_positions = nothing_, .of_states = nothing_};
  Knowns all_;         // states and inputs
  bool known_ = true;  // the states make up every part, and parts stay what they are
};

}  // namespace

std::vector<Knowns> dependencies_of(const Simulation& simulation, const Catalog& catalog) {
  return Finder(simulation, catalog).run();
}

std::vector<Knowns> initial_dependencies_of(const Catalog& catalog, const std::vector<Knowns>& dependencies) {
  std::set<int> parameters;
  const auto& variables = catalog.variables();
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const bool of_methods = variables[i].name.starts_with("solver.") && variables[i].name != "solver.start";
    if (variables[i].source == Source::parameter && !of_methods) parameters.insert(static_cast<int>(i));
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

// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/dependencies.h"

#include <algorithm>

#include "joint/registry.h"
#include "mechanism/sets.h"

namespace gelenk {
namespace {

// What the outputs of one part can depend on.
struct Part {
  std::set<int> positions, states;  // states that are coordinates; those and speeds
  int speeds = 0;                   // among the states
};

// -1: the ground.
int body_number(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.bodies, name, &Body::name);
  return found == scene.bodies.end() ? -1 : static_cast<int>(found - scene.bodies.begin());
}

// By body of the scene: bodies with the same number hang together by joints, without the ground. A force is felt at
// once by these, by others of the part only through springs, so through states.
std::vector<int> clusters_of(const Scene& scene) {
  Sets sets(scene.bodies.size());
  for (const Joint& joint : scene.joints) {
    const int parent = body_number(scene, joint.parent.body);
    const int child = body_number(scene, joint.child.body);
    if (parent >= 0 && child >= 0) sets.join(parent, child);
  }
  // What constraints couple feels forces at once, too.
  const auto joint_body = [&](const std::string& name) {
    const auto joint = std::ranges::find(scene.joints, name, &Joint::name);
    if (joint == scene.joints.end()) return -1;
    return std::max(body_number(scene, joint->parent.body), body_number(scene, joint->child.body));
  };
  for (const Constraint& c : scene.constraints) {
    const int first = c.joint.empty() ? body_number(scene, c.at.body) : joint_body(c.joint);
    for (const int other :
         {c.joint.empty() ? body_number(scene, c.on.body) : -1, joint_body(c.other), joint_body(c.carrier)}) {
      if (first >= 0 && other >= 0) sets.join(first, other);
    }
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
  Finder(const Simulation& simulation, const Catalogue& catalogue)
      : scene_(simulation.scene()),
        reduced_(simulation.prepared().reduced),
        signals_(simulation.outputs()),
        catalogue_(catalogue),
        parts_(reduced_.islands.size()),
        cluster_(clusters_of(scene_)),
        inputs_of_(scene_.bodies.size()) {
    collect_states(simulation);
    collect_inputs();
  }

  std::vector<std::set<int>> run() {
    std::vector<std::set<int>> out(catalogue_.variables().size());
    std::size_t sensor_outputs = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Variable& v = catalogue_.variables()[i];
      if (v.source == Source::rate) out[i] = of_rate(catalogue_.rates()[static_cast<std::size_t>(v.index)]);
      if (v.source != Source::output) continue;
      const Signal& signal = signals_[static_cast<std::size_t>(v.index)];
      out[i] = signal.joint >= 0 ? of_joint(signal, static_cast<int>(i)) : of_sensor(sensor_outputs++);
    }
    return out;
  }

 private:
  void collect_states(const Simulation& simulation) {
    for (const State& state : catalogue_.states()) {
      const Variable& v = catalogue_.variables()[static_cast<std::size_t>(state.variable)];
      const Signal& signal = signals_[static_cast<std::size_t>(v.index)];
      Part& part = parts_[static_cast<std::size_t>(reduced_.joints[static_cast<std::size_t>(signal.joint)].island)];
      if (signal.level == 0) part.positions.insert(state.variable);
      if (signal.level == 1) ++part.speeds;
      part.states.insert(state.variable);
    }
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const Structure& structure = simulation.prepared().islands[p].structure;
      // By inputs that are motions whatever moves with them is determined at once.
      known_ =
          known_ && parts_[p].speeds == reduced_.islands[p].nv - structure.rank && !follows_input(reduced_.islands[p]);
      whole_.positions.insert(parts_[p].positions.begin(), parts_[p].positions.end());
      whole_.states.insert(parts_[p].states.begin(), parts_[p].states.end());
    }
    known_ = known_ && !geometry_may_change(scene_);
  }

  // In the order of input_signals(), which are the first variables.
  void collect_inputs() {
    int next = 0;
    const auto add = [&](const std::string& body, int count) {
      std::set<int>& inputs =
          inputs_of_[static_cast<std::size_t>(cluster_[static_cast<std::size_t>(body_number(scene_, body))])];
      for (int i = 0; i < count; ++i) {
        inputs.insert(next);
        all_.insert(next++);
      }
    };
    for (const Motor& motor : scene_.motors) {
      add(moving_body(*std::ranges::find(scene_.joints, motor.joint, &Joint::name)), 1);
    }
    for (const Force& force : scene_.forces) {
      if (force.type == ForceType::wrench && force.input) add(force.at.body, 6);
    }
    for (const Constraint& c : scene_.constraints) {
      if (c.type == ConstraintType::motion && c.motion.is_input()) all_.insert(next++);
    }
    all_.insert(whole_.states.begin(), whole_.states.end());
  }

  static bool follows_input(const Mechanism& mechanism) {
    return std::ranges::any_of(mechanism.coordinate_rows, [](const CoordinateRow& row) { return row.input >= 0; });
  }

  // One of the two that is not the ground.
  static const std::string& moving_body(const Joint& joint) {
    return joint.child.body != ground ? joint.child.body : joint.parent.body;
  }

  // island: none where something stands still.
  const Part& part(int island) const {
    static const Part nothing;
    if (!known_) return whole_;
    return island < 0 ? nothing : parts_[static_cast<std::size_t>(island)];
  }

  // The states of a part, and the inputs that a body of it feels.
  std::set<int> of_accelerations(const std::string& moving, const Part& part) const {
    if (!known_) return all_;
    std::set<int> out = part.states;
    const int body = body_number(scene_, moving);
    const std::set<int>& inputs = inputs_of_[static_cast<std::size_t>(cluster_[static_cast<std::size_t>(body)])];
    out.insert(inputs.begin(), inputs.end());
    return out;
  }

  std::set<int> of_joint(const Signal& signal, int variable) const {
    const auto j = static_cast<std::size_t>(signal.joint);
    const JointPlace& place = reduced_.joints[j];
    const bool moves = place.role != JointPlace::Role::merged;
    const Part& p = part(moves ? place.island : -1);
    if (p.states.contains(variable)) return of_state(signal, variable);
    if (!known_) return all_;
    if (signal.level == 2) return moves ? of_accelerations(moving_body(scene_.joints[j]), p) : std::set<int>();
    return signal.level == 0 ? p.positions : p.states;
  }

  // Itself; a quaternion's component through the length that is kept all four.
  std::set<int> of_state(const Signal& signal, int variable) const {
    const JointKind& kind = *find_joint_kind(scene_.joints[static_cast<std::size_t>(signal.joint)].type);
    const int component = signal.component - (kind.nq - 4);
    if (signal.level != 0 || !kind.has_quaternion() || component < 0) return {variable};
    const int first = variable - component;
    return {first, first + 1, first + 2, first + 3};
  }

  // Of a quaternion's component: by the states of its joint.
  std::set<int> of_rate(const Rate& rate) const {
    const JointPlace& place = reduced_.joints[static_cast<std::size_t>(rate.joint)];
    return known_ ? part(place.role == JointPlace::Role::merged ? -1 : place.island).states : all_;
  }

  std::set<int> of_sensor(std::size_t output) const {
    for (const Sensor& sensor : scene_.sensors) {
      const std::size_t size = size_of(sensor);
      if (output < size) return of_sensor(sensor, output);
      output -= size;
    }
    return of_constraint(output);
  }

  std::set<int> of_constraint(std::size_t output) const {
    for (std::size_t i = 0; i < scene_.constraints.size(); ++i) {
      const Constraint& c = scene_.constraints[i];
      const std::size_t size = c.type == ConstraintType::rolling ? 6 : 1;
      if (output >= size) {
        output -= size;
        continue;
      }
      const int island = reduced_.constraints[i].island;
      if (!known_) return all_;
      if (island < 0) return {};
      const bool force = output < 3;  // else the contact point
      if (!force) return part(island).positions;
      const auto joint = std::ranges::find(scene_.joints, c.joint, &Joint::name);
      const std::string& body = joint != scene_.joints.end() ? moving_body(*joint)
                                : c.at.body != ground        ? c.at.body
                                                             : c.on.body;
      return of_accelerations(body, part(island));
    }
    return all_;
  }

  static std::size_t size_of(const Sensor& sensor) {
    if (sensor.type == SensorType::reaction) return 6;
    return sensor.type == SensorType::frame ? 13 : 3;
  }

  std::set<int> of_sensor(const Sensor& sensor, std::size_t component) const {
    if (!known_) return all_;
    if (sensor.type == SensorType::energy) return component == 1 ? whole_.positions : whole_.states;
    if (sensor.type == SensorType::frame) {
      const Part& p = part(place(scene_, reduced_, -1, sensor.frame).island);
      return component < 7 ? p.positions : p.states;
    }
    const auto joint = std::ranges::find(scene_.joints, sensor.joint, &Joint::name);
    const int island = reduced_.joints[static_cast<std::size_t>(joint - scene_.joints.begin())].island;
    return of_accelerations(moving_body(*joint), part(island));
  }

  const Scene& scene_;
  const ReducedScene& reduced_;
  const std::vector<Signal>& signals_;
  const Catalogue& catalogue_;
  std::vector<Part> parts_;
  std::vector<int> cluster_;              // by body
  std::vector<std::set<int>> inputs_of_;  // by cluster
  Part whole_;
  std::set<int> all_;  // states and inputs
  bool known_ = true;  // the states make up every part, and parts stay what they are
};

}  // namespace

std::vector<std::set<int>> dependencies_of(const Simulation& simulation, const Catalogue& catalogue) {
  return Finder(simulation, catalogue).run();
}

std::vector<std::set<int>> initial_dependencies_of(const Catalogue& catalogue,
                                                   const std::vector<std::set<int>>& dependencies) {
  std::set<int> parameters;
  const auto& variables = catalogue.variables();
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const bool of_methods = variables[i].name.starts_with("solver.") && variables[i].name != "solver.start";
    if (variables[i].source == Source::parameter && !of_methods) parameters.insert(static_cast<int>(i));
  }
  std::vector<std::set<int>> out(dependencies.size(), parameters);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (const int known : dependencies[i]) {
      if (variables[static_cast<std::size_t>(known)].source == Source::input) out[i].insert(known);
    }
  }
  return out;
}

}  // namespace gelenk

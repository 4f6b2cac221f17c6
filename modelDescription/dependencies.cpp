// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/dependencies.h"

#include <algorithm>

#include "dynamics/model.h"

namespace gelenk {
namespace {

// What the outputs of one part can depend on.
struct Part {
  std::set<int> positions, states, all;  // states that are coordinates; those and speeds; those and inputs
  int speeds = 0;                        // among the states
};

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
        parts_(reduced_.islands.size()) {
    for (std::size_t i = 0; i < catalogue.variables().size(); ++i) {
      if (catalogue.variables()[i].source == Source::input) inputs_.push_back(static_cast<int>(i));
    }
    collect(simulation);
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
  void collect(const Simulation& simulation) {
    for (const State& state : catalogue_.states()) {
      const Variable& v = catalogue_.variables()[static_cast<std::size_t>(state.variable)];
      const Signal& signal = signals_[static_cast<std::size_t>(v.index)];
      Part& part = parts_[static_cast<std::size_t>(reduced_.joints[static_cast<std::size_t>(signal.joint)].island)];
      if (signal.level == 0) part.positions.insert(state.variable);
      if (signal.level == 1) ++part.speeds;
      part.states.insert(state.variable);
    }
    const std::vector<Loads> loads = make_loads(scene_, reduced_);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const Structure& structure = simulation.prepared().islands[p].structure;
      known_ = known_ && parts_[p].speeds == reduced_.islands[p].nv - structure.rank;
      parts_[p].all = parts_[p].states;
      for (const int input : loads[p].inputs) parts_[p].all.insert(inputs_[static_cast<std::size_t>(input)]);
    }
    for (const Part& part : parts_) add(whole_, part);
    whole_.all.insert(inputs_.begin(), inputs_.end());
    known_ = known_ && !geometry_may_change(scene_);
  }

  static void add(Part& to, const Part& part) {
    to.positions.insert(part.positions.begin(), part.positions.end());
    to.states.insert(part.states.begin(), part.states.end());
    to.all.insert(part.all.begin(), part.all.end());
  }

  // island: none where something stands still.
  const Part& part(int island) const {
    static const Part nothing;
    if (!known_) return whole_;
    return island < 0 ? nothing : parts_[static_cast<std::size_t>(island)];
  }

  std::set<int> of_joint(const Signal& signal, int variable) const {
    const JointPlace& place = reduced_.joints[static_cast<std::size_t>(signal.joint)];
    const Part& p = part(place.role == JointPlace::Role::merged ? -1 : place.island);
    if (signal.level == 2) return p.all;
    if (p.states.contains(variable)) return {variable};
    return known_ ? (signal.level == 0 ? p.positions : p.states) : p.all;
  }

  // Of a quaternion's component: the quaternion and the speeds of its joint.
  std::set<int> of_rate(const Rate& rate) const {
    const JointPlace& place = reduced_.joints[static_cast<std::size_t>(rate.joint)];
    const Part& p = part(place.role == JointPlace::Role::merged ? -1 : place.island);
    return known_ ? p.states : p.all;
  }

  std::set<int> of_sensor(std::size_t output) const {
    for (const Sensor& sensor : scene_.sensors) {
      const std::size_t size = size_of(sensor);
      if (output < size) return of_sensor(sensor, output);
      output -= size;
    }
    return whole_.all;
  }

  static std::size_t size_of(const Sensor& sensor) {
    if (sensor.type == SensorType::reaction) return 6;
    return sensor.type == SensorType::frame ? 13 : 3;
  }

  std::set<int> of_sensor(const Sensor& sensor, std::size_t component) const {
    if (!known_) return whole_.all;
    if (sensor.type == SensorType::energy) return component == 1 ? whole_.positions : whole_.states;
    if (sensor.type == SensorType::frame) {
      const Part& p = part(place(scene_, reduced_, -1, sensor.frame).island);
      return component < 7 ? p.positions : p.states;
    }
    const auto joint = std::ranges::find(scene_.joints, sensor.joint, &Joint::name);
    return part(reduced_.joints[static_cast<std::size_t>(joint - scene_.joints.begin())].island).all;
  }

  const Scene& scene_;
  const ReducedScene& reduced_;
  const std::vector<Signal>& signals_;
  const Catalogue& catalogue_;
  std::vector<int> inputs_;  // variables
  std::vector<Part> parts_;
  Part whole_;
  bool known_ = true;  // the states make up every part, and parts stay what they are
};

}  // namespace

std::vector<std::set<int>> dependencies_of(const Simulation& simulation, const Catalogue& catalogue) {
  return Finder(simulation, catalogue).run();
}

}  // namespace gelenk

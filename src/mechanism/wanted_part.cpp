// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/wanted_part.h"

#include <algorithm>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "mechanism/graph.h"
#include "scene/formulas.h"
#include "scene/name_index.h"
#include "scene/settable.h"
#include "scene/signals.h"
#include "scene/touching_laws.h"
#include "scene/wanted_outputs.h"
#include "util/disjoint_sets.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Divides the scene into parts that are kept or omitted as a whole: the islands, and groups of immobile bodies that are
// connected without the ground.
class Pruner {
 public:
  explicit Pruner(const Scene& scene)
      : scene_(scene),
        numbers_(scene),
        part_of_body_(scene.bodies.size(), none),
        part_of_joint_(scene.joints.size(), none),
        part_of_state_(scene.states.size(), none),
        part_of_expression_(scene.expressions.size(), none),
        named_(named_of_motion(scene)) {
    std::vector<Note> notes;
    const Partition parts = partition_of(scene, {}, notes);
    islands_ = static_cast<int>(parts.islands.size());
    for (int p = 0; p < islands_; ++p) enter(parts.islands[static_cast<std::size_t>(p)], p);
    enter_immobile(parts.whole.groups.front());
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      if (part_of_joint_[j] != none) continue;  // a weld within a part has none
      part_of_joint_[j] = part_of(scene.joints[j].child.body);
      if (part_of_joint_[j] == none) part_of_joint_[j] = part_of(scene.joints[j].parent.body);
    }
    kept_.assign(static_cast<std::size_t>(parts_), false);
  }

  WantedPart run() {
    sensors_ = wanted_sensors();
    keep_neighbors();
    WantedPart out{.scene = scene_, .islands = 0, .bodies = {}, .joints = {}};
    list_omitted(out);
    filter(out.scene);
    // Element states without a mechanism: a scene has at least one body.
    if (out.scene.bodies.empty() || out.scene.joints.empty())
      return {.scene = scene_, .islands = 0, .bodies = {}, .joints = {}};
    if (!out.bodies.empty() || !out.joints.empty()) out.scene.left_out = sizes_of(rest(out.scene));
    return out;
  }

 private:
  static constexpr int none = -1;

  void enter(const Graph& island, int part) {
    for (std::size_t g = 1; g < island.groups.size(); ++g) {
      for (const int body : island.groups[g].bodies) part_of_body_[static_cast<std::size_t>(body)] = part;
    }
    for (const Edge& edge : island.edges) part_of_joint_[static_cast<std::size_t>(edge.scene_joint)] = part;
    for (const int state : island.states) part_of_state_[static_cast<std::size_t>(state)] = part;
    for (const int of : island.expressions) part_of_expression_[static_cast<std::size_t>(of)] = part;
  }

  void enter_immobile(const Group& immobile_group) {
    parts_ = islands_;
    DisjointSets sets(scene_.bodies.size());
    for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
      const int parent = numbers_.body(scene_.joints[j].parent.body);
      const int child = numbers_.body(scene_.joints[j].child.body);
      if (part_of_joint_[j] == none && parent >= 0 && child >= 0) sets.join(parent, child);
    }
    std::vector<int> part_of_set(scene_.bodies.size(), none);
    for (const int body : immobile_group.bodies) {
      int& part = part_of_set[static_cast<std::size_t>(sets.find(body))];
      if (part == none) part = parts_++;
      part_of_body_[static_cast<std::size_t>(body)] = part;
    }
  }

  int part_of(const std::string& body) const {
    const int b = numbers_.body(body);
    return b < 0 ? none : part_of_body_[static_cast<std::size_t>(b)];
  }
  int part_of_joint(const std::string& joint) const {
    const int j = numbers_.joint(joint);
    return j < 0 ? none : part_of_joint_[static_cast<std::size_t>(j)];
  }

  // The parts that an element, a joint touches; none among them: the ground.
  std::vector<int> touched(const ElementPlace& element) const {
    std::vector<int> out;
    for (const BodyFrame& frame : element.frames) out.push_back(part_of(frame.body));
    for (const std::string& joint : element.joints) out.push_back(part_of_joint(joint));
    for (const std::string& surface : element.surfaces) {
      for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
        const auto has_it = [&](const BodyShape& shape) { return shape.surface == surface; };
        if (std::ranges::any_of(scene_.bodies[b].shapes, has_it)) out.push_back(part_of_body_[b]);
      }
    }
    return out;
  }
  std::vector<int> touched(const Joint& joint) const {
    return {part_of_joint(joint.name), part_of(joint.parent.body), part_of(joint.child.body)};
  }

  bool is_kept(int part) const { return part != none && kept_[static_cast<std::size_t>(part)]; }
  void keep(int part) {
    if (part != none) kept_[static_cast<std::size_t>(part)] = true;
  }
  // An element is kept with the islands on which it acts, regardless of immobile parts, which several islands share. An
  // element without an island is kept if all its parts are kept.
  template <class Element>
  bool is_kept(const Element& element) const {
    std::vector<int> parts = touched(element);
    if (std::ranges::any_of(parts, [&](int p) { return is_island(p); })) {
      std::erase_if(parts, [&](int p) { return !is_island(p); });
      return std::ranges::any_of(parts, [&](int p) { return is_kept(p); });
    }
    return std::ranges::all_of(parts, [&](int p) { return p == none || is_kept(p); });
  }
  bool is_island(int part) const { return part != none && part < islands_; }

  // Marks the part of an output of a joint, its limit, a state or a named expression.
  void keep_part_of(const Signal& output) {
    if (output.joint >= 0) keep(part_of_joint_[static_cast<std::size_t>(output.joint)]);
    const auto element = static_cast<std::size_t>(output.element);
    if (output.section == sections::contacts) {
      if (const auto of = touching_law_of_joint(scene_, output.element))
        keep(part_of_joint_[static_cast<std::size_t>(of->joint)]);
    }
    if (output.section == sections::states) keep(part_of_state_[element]);
    if (output.section == sections::expressions) keep(part_of_expression_[element]);
  }

  // Marks the parts with requested outputs; returns the names of the sensors with a requested output.
  std::unordered_set<std::string_view> wanted_sensors() {
    const std::vector<Signal> outputs = output_signals(scene_);
    const std::vector<bool> wanted = wanted_outputs(scene_);
    std::unordered_set<std::string> owners;  // of sensors and constraints
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      if (!wanted[i]) continue;
      keep_part_of(outputs[i]);
      if (outputs[i].joint < 0) owners.insert(outputs[i].name.substr(0, outputs[i].name.find('.')));
    }
    std::unordered_set<std::string_view> sensors;
    for (const Sensor& sensor : scene_.sensors) {
      if (!owners.contains(sensor.name)) continue;
      sensors.insert(sensor.name);
      if (kind_of(*sensor.is).of_whole) kept_.assign(kept_.size(), true);
      for (const int part : touched(sensor)) keep(part);
    }
    each_section(scene_, [&](const Section& section, const auto& elements) {
      if (section.name == sensors_section.name) return;
      for (const auto& element : elements) {
        if (!owners.contains(element.name)) continue;
        for (const int part : touched(element)) keep(part);
      }
    });
    return sensors;
  }

  // Extends the kept parts until no kept element refers to an omitted part: islands are not coupled to each other, but
  // may be connected to immobile parts.
  void keep_neighbors() {
    for (bool grown = true; grown;) {
      grown = false;
      const auto spread = [&](const auto& elements) {
        for (const auto& element : elements) {
          if (!is_kept(element)) continue;
          for (const int part : touched(element)) {
            grown = grown || (part != none && !is_kept(part));
            keep(part);
          }
        }
      };
      spread(scene_.joints);
      spread(scene_.forces);
      spread(scene_.constraints);
      spread(scene_.contacts);
    }
  }

  // A sensor of a reaction is kept with its island even if it is not requested, since it makes the island spatial.
  bool is_kept(const Sensor& sensor) const {
    const auto kept = [&](int part) { return is_kept(part); };
    return sensors_.contains(sensor.name) ||
           (named_.contains(sensor.name) && std::ranges::any_of(touched(sensor), kept)) ||
           (kind_of(*sensor.is).reads_reaction && std::ranges::any_of(touched(sensor), kept));
  }

  // Expressions of inputs and constants alone are in no part: others may name them.
  void filter_named(Scene& scene) const {
    scene.states.clear();
    scene.expressions.clear();
    for (std::size_t i = 0; i < scene_.states.size(); ++i) {
      if (is_kept(part_of_state_[i])) scene.states.push_back(scene_.states[i]);
    }
    for (std::size_t i = 0; i < scene_.expressions.size(); ++i) {
      const NamedExpression& of = scene_.expressions[i];
      if (is_kept(part_of_expression_[i]) || !couples(scene_, of.value)) scene.expressions.push_back(of);
    }
  }

  void filter(Scene& scene) const {
    std::erase_if(scene.bodies, [&](const Body& body) { return !is_kept(part_of(body.name)); });
    std::erase_if(scene.joints, [&](const Joint& joint) { return !is_kept(joint); });
    std::erase_if(scene.efforts, [&](const JointEffort& effort) { return !is_kept(part_of_joint(effort.joint)); });
    filter_named(scene);
    each_section(scene, [&](const Section&, auto& elements) {
      std::erase_if(elements, [&](const auto& element) { return !is_kept(element); });
    });
    std::unordered_set<std::string> known;
    for (const Settable& number : settables(scene)) known.insert(number.path);
    std::erase_if(scene.parameters,
                  [&](const std::string& path) { return !known.contains(path.substr(0, path.find('['))); });
  }

  // The omitted part of the scene.
  Scene rest(const Scene& kept) const {
    Scene out = scene_;
    const auto drop = [](auto& elements, const auto& those) {
      std::unordered_set<std::string_view> names;
      for (const auto& element : those) names.insert(element.name);
      std::erase_if(elements, [&](const auto& element) { return names.contains(element.name); });
    };
    drop(out.bodies, kept.bodies);
    drop(out.joints, kept.joints);
    drop(out.forces, kept.forces);
    drop(out.constraints, kept.constraints);
    drop(out.contacts, kept.contacts);
    return out;
  }

  void list_omitted(WantedPart& out) const {
    for (int p = 0; p < islands_; ++p) out.islands += is_kept(p) ? 0 : 1;
    for (const Body& body : scene_.bodies) {
      if (!is_kept(part_of(body.name))) out.bodies.push_back(body.name);
    }
    for (const Joint& joint : scene_.joints) {
      if (!is_kept(joint)) out.joints.push_back(joint.name);
    }
  }

  const Scene& scene_;
  NameIndex numbers_;
  int islands_ = 0, parts_ = 0;                    // islands first, then immobile parts
  std::vector<int> part_of_body_, part_of_joint_;  // none: only a weld of the ground to itself
  std::vector<int> part_of_state_, part_of_expression_;
  std::vector<bool> kept_;                        // by part
  std::unordered_set<std::string> named_;         // by expressions
  std::unordered_set<std::string_view> sensors_;  // with a requested output
};

}  // namespace

std::string WantedPart::report() const {
  if (bodies.empty() && joints.empty()) return {};
  std::string what = islands == 1 ? "1 island" : std::to_string(islands) + " islands";
  if (islands == 0) what = "immobile parts";
  std::string names;
  if (!bodies.empty()) names = (bodies.size() == 1 ? "body " : "bodies ") + text::some(bodies);
  if (!joints.empty()) {
    names += (names.empty() ? "" : "; ") + std::string(joints.size() == 1 ? "joint " : "joints ") + text::some(joints);
  }
  return "omitted, because no requested output depends on it: " + what + " (" + names + ")";
}

WantedPart wanted_part(const Scene& scene) {
  const bool can_prune = scene.solver.reduces(Reduction::outputs) && scene.solver.reduces(Reduction::islands);
  WantedPart out = scene.outputs.empty() || scene.is_wanted_part || !can_prune
                       ? WantedPart{.scene = scene, .islands = 0, .bodies = {}, .joints = {}}
                       : Pruner(scene).run();
  out.scene.is_wanted_part = true;
  return out;
}

}  // namespace gelenk

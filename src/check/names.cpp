// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <set>

#include "check/check.h"
#include "expression/library.h"
#include "joint/kinds.h"
#include "scene/component_parts.h"
#include "scene/element_numbers.h"
#include "scene/quantity_groups.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr std::size_t max_name_length = 200;  // characters, the same as for the scene's name

// Whether it is of a component, not of the file.
template <class Named>
bool is_part(const Named& named) {
  if constexpr (requires { named.component; }) return !named.component.empty();
  return false;
}

template <class Element>
void check_section(const std::vector<Element>& elements, const std::string& section, Faults& faults) {
  std::set<std::string> seen;
  for (const Element& element : elements) {
    if (is_part(element)) continue;
    const std::string path = section + "." + text::printable(element.name);
    if (element.name == ground) {
      faults.add(path, "the name 'ground'", "another name: 'ground' is the fixed body");
    } else if (!text::is_identifier(element.name)) {
      faults.add(path, "the name " + text::quoted(element.name), "a letter or _, then letters, digits or _");
    } else if (element.name.size() > max_name_length) {
      faults.add(section + "." + element.name.substr(0, 20) + "...",
                 "a name of " + std::to_string(element.name.size()) + " characters",
                 "at most " + std::to_string(max_name_length));
    }
    if (!seen.insert(element.name).second) faults.add(path, "twice", "every name once");
  }
}

// Owners of the structured names of variables ("A.phi"), without indices.
class NameClaims {
 public:
  explicit NameClaims(Faults& faults) : faults_(faults) {}

  // Assigns names to an owner; adds at most one error for each pair of owners with a common name.
  void claim(const std::string& owner, const std::string& element, const std::vector<std::string>& suffixes) {
    std::set<std::string> reported;
    for (const std::string& suffix : suffixes) {
      const std::string name = element + "." + suffix;
      const std::string& first = owners_.try_emplace(name, owner).first->second;
      if (first == owner || !reported.insert(first).second) continue;
      faults_.add(owner, "the variable " + name + ", which " + first + " also has",
                  "names that give different variables");
    }
  }

 private:
  Faults& faults_;
  std::map<std::string, std::string> owners_;
};

void add_fields(std::vector<std::string>& out, std::span<const Field> fields) {
  for (const Field& field : fields) {
    if (field.type != Field::Type::formula) out.emplace_back(field.name);  // no variable
  }
}

std::vector<std::string> joint_suffixes(const Joint& joint) {
  std::vector<std::string> out = {"fixed", "parent", "child"};
  for (const JointForceKind& force : joint_force_kinds()) {
    if (!force.group.empty()) out.emplace_back(force.group);
    if (force.group.empty()) add_fields(out, force.fields);
  }
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr) return out;
  add_fields(out, kind->fields);
  for (const auto quantities : {kind->q, kind->v, kind->a}) {
    for (const QuantityGroup& group : groups(quantities)) {
      out.push_back(group.name);
      out.push_back(group.name + "_start");
    }
  }
  return out;
}

template <class Any>
std::vector<std::string> suffixes(const Scene& scene, const Element<Any>& element) {
  const ElementKind& kind = kind_of(*element.is);
  const Coordinate coordinate = coordinate_of(scene, element);
  std::vector<std::string> out;
  add_fields(out, kind.fields);
  for (const auto signals : {inputs_of(*element.is), kind.outputs}) {
    for (const SignalGroup& signal : signals) out.push_back(filled_in(signal.name, element, coordinate));
  }
  return out;
}

void add_variables(std::set<std::string_view>& out, std::span<const Field> fields) {
  for (const Field& field : fields) {
    if (field.type == Field::Type::group) add_variables(out, field.inner());
    for (const FormulaVariable& variable : field.variables) out.insert(variable.name);
  }
}

// The variables of all elements.
std::set<std::string_view> all_variables() {
  std::set<std::string_view> out = {time_signal};
  add_variables(out, GravityField::fields());
  for (const JointForceKind& kind : joint_force_kinds()) add_variables(out, kind.fields);
  const Scene nothing;
  each_section(nothing, [&]<class Any>(const Section&, const std::vector<Element<Any>>&) {
    for (const ElementKind& kind : element_kinds<Any>()) add_variables(out, kind.fields);
  });
  return out;
}

// Names that have a meaning of their own: in expressions, as those of variables, operators and functions; in scenes;
// and of columns in tables of results.
bool is_taken(const std::string& name) {
  constexpr std::string_view words[] = {"pi",     "if",      "or",   "and",   "not",
                                        "ground", "gravity", "time", "error", "warning"};
  static const std::set<std::string_view> variables = all_variables();
  return std::ranges::find(words, name) != std::end(words) || variables.contains(name) ||
         expression::Library::has(name);
}

// The names of constants, inputs, states and named expressions, which expressions use.
void check_own_names(const Scene& scene, Faults& faults) {
  std::map<std::string, std::string> seen;
  const auto add_elements = [&](const std::string& section, const auto& elements) {
    for (const auto& element : elements) {
      if (!is_part(element)) seen.try_emplace(element.name, section + "." + text::printable(element.name));
    }
  };
  add_elements("bodies", scene.bodies);
  add_elements("joints", scene.joints);
  each_section(
      scene, [&](const Section& section, const auto& elements) { add_elements(std::string(section.name), elements); });
  const auto check = [&](const std::string& section, const std::string& name) {
    const std::string path = section + "." + text::printable(name);
    if (is_taken(name)) {
      faults.add(path, "the name " + text::quoted(name) + ", which has a meaning of its own", "another name");
      return;
    }
    const auto [at, is_new] = seen.try_emplace(name, path);
    if (!is_new) faults.add(path, "the name of " + at->second, "a name that nothing else has");
  };
  for (const FormulaNames::Constant& constant : scene.constants) check("constants", constant.name);
  for (const SceneInput& input : scene.inputs) {
    if (!is_part(input)) check("inputs", input.name);
  }
  for (const ElementState& state : scene.states) {
    if (is_part(state)) continue;
    check("states", state.name);
    check("states", start_parameter(state.name));
  }
  for (const NamedExpression& of : scene.expressions) {
    if (!is_part(of)) check("expressions", of.name);
  }
}

}  // namespace

void check_names(const Scene& scene, Faults& faults) {
  check_section(scene.bodies, "bodies", faults);
  check_section(scene.joints, "joints", faults);
  check_section(scene.constants, "constants", faults);
  check_section(scene.tables, "tables", faults);
  check_section(scene.inputs, "inputs", faults);
  check_section(scene.states, "states", faults);
  check_section(scene.expressions, "expressions", faults);
  check_own_names(scene, faults);
  each_section(scene, [&](const Section& section, const auto& elements) {
    check_section(elements, std::string(section.name), faults);
  });

  NameClaims claims(faults);
  const std::string always = "every mechanism";
  claims.claim(always, "assembly", {"tolerance"});
  claims.claim(always, "constraints", {"position", "velocity"});
  claims.claim(always, "energy", {"kinetic", "potential", "total"});
  claims.claim(always, "solver",
               {"steps", "evaluations", "traced_evaluations", "rejected_steps", "jacobians", "singular_positions",
                "events", "tolerance", "formulation", "integrator", "equations", "step", "start"});
  for (const Body& body : scene.bodies) claims.claim("bodies." + body.name, body.name, {"m", "mass", "com", "inertia"});
  for (const Joint& joint : scene.joints) claims.claim("joints." + joint.name, joint.name, joint_suffixes(joint));
  for (const ElementState& state : scene.states)
    claims.claim(is_part(state) ? "components." + state.component : "states." + state.name, state.name, {"rate"});
  const auto claim_parts = [&](const auto& all) {
    for (const auto& named : all) {
      if (is_part(named)) claims.claim("components." + named.component, named.component, {own_name(named)});
    }
  };
  claim_parts(scene.inputs);
  claim_parts(scene.states);
  claim_parts(scene.expressions);
  each_section(scene, [&](const Section& section, const auto& elements) {
    for (const auto& element : elements) {
      const std::string_view owner = is_part(element) ? components_section.name : section.name;
      claims.claim(std::string(owner) + "." + element.name, element.name, suffixes(scene, element));
    }
  });
}

}  // namespace gelenk

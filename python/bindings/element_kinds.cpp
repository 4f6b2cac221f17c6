// SPDX-License-Identifier: BSD-3-Clause
// The kinds of elements and their numbers, for Python. The kinds are those of the registry.
#include "elements.h"

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "element/components/component.h"
#include "element/kinds.h"
#include "joint/kinds.h"
#include "scene/element_numbers.h"

namespace nb = nanobind;

namespace gelenk {
namespace {

const char* field_type(Field::Type type) {
  static constexpr const char* names[] = {"number", "vector",  "direction", "numbers", "flag",
                                          "choice", "formula", "formulas",  "group"};
  return names[static_cast<int>(type)];
}
const char* range_name(Range range) {
  static constexpr const char* names[] = {"any", "not_negative", "positive", "not_zero", "fraction", "at_most_one"};
  return names[static_cast<int>(range)];
}
const char* port_kind(Port::Kind kind) {
  static constexpr const char* names[] = {"frame", "point", "body", "joint", "surfaces"};
  return names[static_cast<int>(kind)];
}

// The unit as given, for an angle and for a length.
nb::list units(std::string_view unit) {
  nb::list out;
  for (const bool is_angle : {true, false})
    out.append(unit_of(unit, {.name = {}, .speed = {}, .acceleration = {}, .is_angle = is_angle}));
  return out;
}

nb::object value_of(const Eigen::Vector3d& x) { return nb::cast(std::vector<double>(x.begin(), x.end())); }

// The value of a field of an element.
nb::object value_in(const Field& field, const void* element) {
  switch (field.type) {
    case Field::Type::number:
      return nb::cast(field.of<double>(element));
    case Field::Type::vector:
      return value_of(field.of<Eigen::Vector3d>(element));
    case Field::Type::direction:
      return value_of(field.of<Direction>(element).along);
    case Field::Type::numbers:
      return nb::cast(field.of<std::vector<double>>(element));
    case Field::Type::flag:
      return nb::cast(field.of<bool>(element));
    case Field::Type::choice:
      return nb::cast(field.of<Choice>(element).index);
    case Field::Type::formula:
      return nb::cast(std::string(field.of<Formula>(element).text()));
    case Field::Type::formulas:
      return nb::cast(std::vector<std::string>());
    case Field::Type::group:
      break;
  }
  return nb::none();
}

template <class Strings>
nb::list list_of(const Strings& strings) {
  nb::list out;
  for (const std::string_view s : strings) out.append(std::string(s));
  return out;
}

template <class Fits>
nb::list joints_that_fit(const Fits& fits) {
  nb::list out;
  for (const JointKind& kind : joint_kinds()) {
    if (fits(kind)) out.append(std::string(kind.name));
  }
  return out;
}

nb::list value_of(std::span<const Port> ports) {
  nb::list out;
  for (const Port& port : ports) {
    nb::dict entry;
    entry["kind"] = port_kind(port.kind);
    entry["name"] = std::string(port.name);
    entry["text"] = std::string(port.text);
    entry["optional"] = port.optional;
    entry["on_ground"] = port.on_ground;
    entry["has_coordinate"] = port.has_coordinate;
    entry["fits"] = joints_that_fit([&](const JointKind& kind) {
      return port.kind == Port::Kind::joint && (port.fits == nullptr || port.fits(kind));
    });
    out.append(entry);
  }
  return out;
}

// The outputs of a kind; of a component, those that it has with all optional fields.
template <class Any>
nb::list outputs_of(const ElementKind& kind, const Stored<Any>&) {
  return shown_signals(kind.outputs);
}
nb::list outputs_of(const ElementKind& kind, Stored<AnyComponent> component) {
  for (const Field& field : kind.fields) {
    if (field.optional) field.of<double>(data_of(*component)) = 1;
  }
  const ComponentEquations equations = equations_of(*component);
  std::vector<SignalGroup> groups;
  const auto add = [&](const ComponentEquations::Quantity& of) { groups.push_back({of.name, 0, of.unit, of.text}); };
  for (const ComponentEquations::State& state : equations.states) add(state);
  for (const ComponentEquations::Value& value : equations.values) add(value);
  return shown_signals(groups);
}

template <class Any>
nb::list section() {
  nb::list out;
  for (std::size_t n = 0; n < element_kinds<Any>().size(); ++n) {
    const ElementKind& kind = element_kinds<Any>()[n];
    const Stored<Any> plain = make_element<Any>(n);
    nb::dict entry;
    entry["name"] = std::string(kind.kind);
    entry["summary"] = std::string(kind.summary);
    entry["ports"] = value_of(kind.ports);
    entry["fields"] = shown_fields(kind.fields, data_of(*plain));
    entry["outputs"] = outputs_of(kind, plain);
    entry["between_bodies"] = kind.is_between_bodies;
    out.append(entry);
  }
  return out;
}

nb::list along_joints() {
  nb::list out;
  for (const JointForceKind& kind : joint_force_kinds()) {
    nb::dict entry;
    entry["name"] = name_along(kind.group, kind.fields);
    entry["group"] = std::string(kind.group);
    entry["summary"] = std::string(kind.summary);
    entry["fits"] = joints_that_fit(kind.fits);
    entry["of_joint"] = kind.of_joint;
    entry["fields"] = shown_fields(kind.fields, kind.defaults());
    out.append(entry);
  }
  return out;
}

Eigen::Vector3d vector_of(const std::vector<double>& list, const std::string& name) {
  if (list.size() != 3) throw std::invalid_argument(name + " has three numbers");
  return {list[0], list[1], list[2]};
}

}  // namespace

nb::list shown_fields(std::span<const Field> fields, const void* defaults) {
  nb::list out;
  for (const Field& field : fields) {
    nb::dict entry;
    entry["name"] = std::string(field.name);
    entry["unit"] = std::string(field.unit);
    entry["units"] = units(field.unit);
    entry["text"] = about_any(field.text);
    entry["type"] = field_type(field.type);
    entry["range"] = range_name(field.range);
    entry["required"] = field.required;
    entry["optional"] = field.optional;
    entry["tunable"] = field.tunable;
    entry["settable"] = field.settable;
    entry["by_time"] = field.by_time;
    entry["alternative"] = field.alternative;
    entry["way"] = field.alternative != 0 ? field.alternative : field.goes_with;
    entry["size"] = field.type == Field::Type::vector || field.type == Field::Type::direction ? 3 : field.min_count;
    entry["words"] = list_of(field.words);
    nb::list variables;
    for (const FormulaVariable& variable : field.variables) variables.append(std::string(variable.name));
    entry["variables"] = variables;
    entry["default"] = value_in(field, defaults);
    const bool group = field.type == Field::Type::group;
    entry["fields"] = group ? shown_fields(field.inner(), field.defaults()) : nb::list();
    out.append(entry);
  }
  return out;
}

nb::dict shown_kinds() {
  nb::dict out;
  out["motors"] = section<AnyMotor>();
  out["forces"] = section<AnyForce>();
  out["constraints"] = section<AnyConstraint>();
  out["contacts"] = section<AnyContact>();
  out["sensors"] = section<AnySensor>();
  out["components"] = section<AnyComponent>();
  out["joints"] = along_joints();
  return out;
}

std::string name_along(std::string_view group, std::span<const Field> fields) {
  return std::string(group.empty() ? fields.front().name : group);
}

nb::list shown_signals(std::span<const SignalGroup> groups) {
  nb::list out;
  for (const SignalGroup& group : groups) {
    nb::dict entry;
    entry["name"] = std::string(group.name);
    entry["size"] = group.count();
    entry["is_array"] = group.size > 0;
    entry["unit"] = std::string(group.unit);
    entry["units"] = units(group.unit);
    entry["text"] = about_any(group.text);
    out.append(entry);
  }
  return out;
}

namespace {

// A text, or one for each component.
void put_texts(std::span<Formula> formulas, const ElementNumbers::mapped_type& value, const Field& field) {
  if (const auto* text = std::get_if<std::string>(&value)) {
    formulas.front() = Formula(*text, field.variables);
    return;
  }
  const auto& texts = std::get<std::vector<std::string>>(value);
  if (texts.size() != formulas.size()) throw std::invalid_argument(std::string(field.name) + " has three texts");
  for (std::size_t i = 0; i < texts.size(); ++i) formulas[i] = Formula(texts[i], field.variables);
}

}  // namespace

void put_number(std::span<const Field> fields, void* element, const std::string& name,
                const ElementNumbers::mapped_type& value) {
  for (const Field& field : fields) {
    if (field.type == Field::Type::group && name.starts_with(std::string(field.name) + ".")) {
      if (field.in(element) == nullptr) field.emplace(element);
      return put_number(field.inner(), field.in(element), name.substr(field.name.size() + 1), value);
    }
    if (field.name != name) continue;
    const auto* list = std::get_if<std::vector<double>>(&value);
    const auto number = [&] {
      if (list != nullptr) throw std::invalid_argument(name + " is a number");
      return std::get<double>(value);
    };
    const auto numbers = [&] {
      if (list == nullptr) throw std::invalid_argument(name + " is a list of numbers");
      return *list;
    };
    switch (field.type) {
      case Field::Type::number:
        field.of<double>(element) = number();
        return;
      case Field::Type::vector:
        field.of<Eigen::Vector3d>(element) = vector_of(numbers(), name);
        return;
      case Field::Type::direction:
        field.of<Direction>(element).along = vector_of(numbers(), name).normalized();
        return;
      case Field::Type::numbers:
        field.of<std::vector<double>>(element) = numbers();
        return;
      case Field::Type::flag:
        field.of<bool>(element) = number() != 0;
        return;
      case Field::Type::choice:
        field.of<Choice>(element).index = static_cast<int>(number());
        return;
      default:
        return put_texts(formulas_of(field, element), value, field);
    }
  }
  throw std::invalid_argument("unknown field: " + name);
}

}  // namespace gelenk

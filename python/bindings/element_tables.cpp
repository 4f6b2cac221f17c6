// SPDX-License-Identifier: BSD-3-Clause
// What the registry of elements says of them, for the tables of the documentation and for tests.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "bindings.h"
#include "scene/element_numbers.h"

namespace nb = nanobind;

namespace gelenk {
namespace {

constexpr Coordinate angle = {.name = "phi", .speed = "w", .is_angle = true};
constexpr Coordinate length = {.name = "s", .speed = "v", .is_angle = false};

nb::str text_of(std::string_view text) { return nb::str(text.data(), text.size()); }

// One unit, or those about an angle and about a length.
nb::list units(std::string_view unit) {
  const std::string of_angle = unit_of(unit, angle);
  const std::string of_length = unit_of(unit, length);
  nb::list out;
  if (!of_angle.empty()) out.append(of_angle);
  if (of_length != of_angle) out.append(of_length);
  return out;
}

nb::object numbers(const Eigen::Vector3d& x) { return nb::cast(std::vector<double>(x.begin(), x.end())); }

// None: it is not given.
nb::object value_of(const Field& field, const void* element) {
  switch (field.type) {
    case Field::Type::number: {
      const double x = field.of<double>(element);
      return std::isfinite(x) ? nb::cast(x) : nb::none();
    }
    case Field::Type::vector:
      return numbers(field.of<Eigen::Vector3d>(element));
    case Field::Type::direction:
      return numbers(field.of<Direction>(element).along);
    case Field::Type::flag:
      return nb::cast(field.of<bool>(element));
    case Field::Type::choice:
      if (const int i = field.of<Choice>(element).index; i != Choice::none) {
        return text_of(field.words[static_cast<std::size_t>(i)]);
      }
      return nb::none();
    case Field::Type::numbers:
    case Field::Type::group:
      return nb::none();
  }
  return nb::none();
}

nb::list fields_of(std::span<const Field> fields, const void* defaults) {
  nb::list out;
  for (const Field& field : fields) {
    nb::dict entry;
    entry["name"] = text_of(field.name);
    entry["text"] = text_of(field.text);
    entry["units"] = units(field.unit);
    entry["by_time"] = field.by_time;
    entry["way"] = field.way;
    entry["required"] = field.required;
    entry["tunable"] = field.tunable;
    entry["default"] = value_of(field, defaults);
    nb::list words;
    for (const std::string_view word : field.words) words.append(text_of(word));
    entry["words"] = words;
    entry["inner"] = field.inner == nullptr ? nb::list() : fields_of(field.inner(), field.defaults());
    out.append(entry);
  }
  return out;
}

nb::list ports_of(std::span<const Port> ports) {
  static constexpr std::string_view kinds[] = {"frame", "point", "body", "joint"};
  nb::list out;
  for (const Port& port : ports) {
    nb::dict entry;
    entry["name"] = text_of(port.name);
    entry["text"] = text_of(port.text);
    entry["kind"] = text_of(kinds[static_cast<std::size_t>(port.kind)]);
    entry["optional"] = port.optional;
    entry["has_coordinate"] = port.has_coordinate;
    out.append(entry);
  }
  return out;
}

nb::list signals_of(std::span<const SignalGroup> groups) {
  nb::list out;
  for (const SignalGroup& group : groups) {
    nb::dict entry;
    entry["name"] = text_of(group.name);
    entry["size"] = group.size;
    entry["text"] = text_of(group.text);
    entry["units"] = units(group.unit);
    out.append(entry);
  }
  return out;
}

template <class Any>
nb::list kinds_of(const std::vector<Element<Any>>&) {
  nb::list out;
  for (std::size_t n = 0; n < element_kinds<Any>().size(); ++n) {
    const ElementKind& kind = element_kinds<Any>()[n];
    const Any plain = make_element<Any>(n);
    nb::dict entry;
    entry["name"] = text_of(kind.kind);
    entry["summary"] = text_of(kind.summary);
    entry["ports"] = ports_of(kind.ports);
    entry["fields"] = fields_of(kind.fields, data_of(plain));
    entry["outputs"] = signals_of(kind.outputs);
    out.append(entry);
  }
  return out;
}

nb::dict kinds() {
  nb::dict out;
  const Scene none;
  each_section(none,
               [&](const Section& section, const auto& elements) { out[text_of(section.name)] = kinds_of(elements); });
  return out;
}

nb::dict of_joints() {
  nb::dict out;
  for (const JointKind& kind : joint_kinds()) {
    const AnyJoint plain = make_joint(kind.name, default_axes(kind));
    out[text_of(kind.name)] = fields_of(kind.fields, data_of(plain));
  }
  return out;
}

nb::list along() {
  nb::list out;
  for (const JointForceKind& kind : joint_force_kinds()) {
    nb::dict entry;
    entry["group"] = text_of(kind.group);
    entry["summary"] = text_of(kind.summary);
    entry["fields"] = fields_of(kind.fields, kind.defaults());
    out.append(entry);
  }
  return out;
}

}  // namespace

void bind_element_tables(nb::module_& module) {
  nb::module_ m = module.def_submodule("element_tables", "What src/element/registry.h lists.");
  m.def("kinds", &kinds, "By section, all kinds of element: name, summary, ports, fields, outputs.");
  m.def("of_joints", &of_joints, "By kind of joint, the fields of its own.");
  m.def("along", &along, "All kinds of what acts along a joint: the mapping they stand in, summary, fields.");
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "scene/unit_system.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "joint/kinds.h"
#include "scene/element_numbers.h"
#include "scene/shapes.h"

namespace gelenk {
namespace {

struct Symbol {
  std::string_view name;
  UnitExponents exponents;  // in the order of base_units; the last ones are 0
};

constexpr Symbol symbols[] = {
    {"1", {0}},
    {"kg", {1}},
    {"m", {0, 1}},
    {"s", {0, 0, 1}},
    {"rad", {0, 0, 0, 1}},
    {"N", {1, 1, -2}},
    {"J", {1, 2, -2}},
    {"W", {1, 2, -3}},
    {"Pa", {1, -1, -2}},
    {"Hz", {0, 0, -1}},
    {"A", {0, 0, 0, 0, 1}},
    {"V", {1, 2, -3, 0, -1}},
    {"Ohm", {1, 2, -3, 0, -2}},
    {"H", {1, 2, -2, 0, -2}},
    {"K", {0, 0, 0, 0, 0, 1}},
};

// Returns the exponents of a symbol with an optional exponent: "m2".
UnitExponents factor(std::string_view text) {
  int power = 1;
  if (text.size() > 1 && text.back() >= '2' && text.back() <= '9') {
    power = text.back() - '0';
    text.remove_suffix(1);
  }
  for (const Symbol& symbol : symbols) {
    if (symbol.name != text) continue;
    UnitExponents exponents = symbol.exponents;
    for (int& e : exponents) e *= power;
    return exponents;
  }
  throw std::invalid_argument("no unit is called '" + std::string(text) + "'");
}

// Lengths and masses between the reciprocals of these limits and the limits are measured in meters and kilograms.
constexpr double max_ordinary_length = 8;   // m
constexpr double max_ordinary_mass = 1024;  // kg

double power_of_two(double x, double ordinary_limit) {
  const bool ordinary = !(x > 0) || !std::isfinite(x) || (x >= 1 / ordinary_limit && x <= ordinary_limit);
  return ordinary ? 1 : std::exp2(std::round(std::log2(x)));
}

// Accumulates the largest of several lengths.
struct Longest {
  double length = 0;
  void add(double x) {
    if (std::isfinite(x)) length = std::max(length, std::abs(x));
  }
  void add(const BodyFrame& frame, bool of_ground) {
    if ((frame.body == ground) == of_ground) add(frame.X_BF.p.norm());
  }
};

// Calls visit(x) for each length among the numbers of elements between bodies.
template <class Any, class Visit>
void each_length(const std::vector<Element<Any>>& elements, Visit visit) {
  for (const Element<Any>& element : elements) {
    if (!element.joints.empty()) continue;
    each_number(kind_of(*element.is).fields, data_of(*element.is), [&](const Number& x) {
      if (x.field->unit == "m") visit(*x.value);
    });
  }
}

double size_of_bodies(const Scene& scene) {
  Longest out;
  for (const Body& body : scene.bodies) {
    out.add(body.com.norm());
    if (body.mass > 0) out.add(std::sqrt(body.inertia.trace() / body.mass));
    for (const BodyShape& shape : body.shapes) out.add(size_of(*shape.is));
  }
  for (const Joint& joint : scene.joints) {
    for (const BodyFrame* frame : {&joint.parent, &joint.child}) out.add(*frame, false);
  }
  each_length(scene.constraints, [&](double x) { out.add(x); });
  return out.length;
}

// Largest distance between parts of a scene, used if its bodies are points.
double size_of_travel(const Scene& scene) {
  Longest out;
  for (const Joint& joint : scene.joints) {
    for (const BodyFrame* frame : {&joint.parent, &joint.child}) out.add(*frame, true);
    const JointKind& kind = *find_joint_kind(joint.type);
    for (int i = 0; i < kind.nq; ++i) {
      if (kind.q[i].unit == "m" && joint.start.q_given[i]) out.add(joint.start.q[i]);
    }
  }
  each_length(scene.forces, [&](double x) { out.add(x); });
  return out.length;
}

class Converter {
 public:
  explicit Converter(const UnitSystem& units) : length_(1 / units.length), mass_(1 / units.mass), units_(units) {}

  void convert(Scene& scene) const {
    scene.gravity *= length_;
    if (scene.gravity_field) convert(GravityField::fields(), &*scene.gravity_field, {});
    for (Body& body : scene.bodies) convert(body);
    for (BodyShape& shape : scene.ground_shapes) convert(shape);
    for (Joint& joint : scene.joints) convert(joint);
    for (JointEffort& effort : scene.efforts)
      convert(JointEffort::fields().front(), effort.value, coordinate_of(kind_of_joint(scene, effort.joint)));
    each_section(scene, [&](const Section&, auto& elements) {
      for (auto& element : elements) {
        for (BodyFrame& frame : element.frames) convert(frame);
        convert(kind_of(*element.is).fields, data_of(*element.is), coordinate_of(scene, element));
      }
    });
  }

 private:
  void convert(BodyFrame& frame) const { frame.X_BF.p *= length_; }

  void convert(std::span<const Field> fields, void* element, const Coordinate& coordinate) const {
    each_number(fields, element, [&](const Number& x) { *x.value /= units_.size_of(x.unit(coordinate)); });
    for (const Field& field : fields) {
      for (Formula& formula : formulas_of(field, element)) convert(field, formula, coordinate);
    }
  }

  // Expressions stay in SI units: their variables and results are converted.
  void convert(const Field& field, Formula& formula, const Coordinate& coordinate) const {
    std::vector<double> sizes;
    for (const FormulaVariable& variable : field.variables) sizes.push_back(units_.size_of(variable.unit));
    formula.set_sizes(units_.size_of(unit_of(field, coordinate)), sizes);
  }

  void convert(BodyShape& shape) const {
    shape.X_BS.p *= length_;
    scale(shape.is, length_);
  }

  void convert(Body& body) const {
    convert(Body::fields(), &body, {});
    for (BodyShape& shape : body.shapes) convert(shape);
    body.inertia *= mass_ * length_ * length_;
    if (body.pose) body.pose->p *= length_;
  }

  void convert(Joint& joint) const {
    convert(joint.parent);
    convert(joint.child);
    const JointKind& kind = *find_joint_kind(joint.type);
    JointStart& start = joint.start;  // weights are not converted: they refer to lengths in natural units
    for (std::size_t i = 0; i < start.q.size(); ++i) {
      if (kind.q[i].unit == "m") start.q[i] *= length_;
    }
    for (std::size_t i = 0; i < start.v.size(); ++i) {
      if (kind.v[i].unit == "m/s") start.v[i] *= length_;
    }
    convert(kind.fields, data_of(*joint.is), {});
    for (std::size_t i = 0; i < joint.along.size(); ++i) {
      for (const JointForceKind& force : joint_force_kinds()) {
        void* there = force.find(*joint.along[i]);
        if (there != nullptr) convert(force.fields, there, coordinate_of(kind, static_cast<int>(i)));
      }
    }
  }

  double length_, mass_;  // a meter and a kilogram in the new units
  UnitSystem units_;
};

}  // namespace

bool is_unit(std::string_view unit) {
  try {
    unit_exponents(unit);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

UnitExponents unit_exponents(std::string_view unit) {
  UnitExponents total{};
  int sign = 1;
  std::size_t begin = 0;
  while (begin <= unit.size()) {
    const std::size_t end = std::min(unit.find_first_of("./", begin), unit.size());
    const UnitExponents part = factor(unit.substr(begin, end - begin));
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += sign * part[i];
    if (end < unit.size() && unit[end] == '/') sign = -1;
    begin = end + 1;
  }
  return total;
}

double UnitSystem::size_of(std::string_view unit) const {
  if (is_si() || unit.empty()) return 1;
  const UnitExponents e = unit_exponents(unit);
  return std::pow(mass, e[0]) * std::pow(length, e[1]);
}

OmittedSizes sizes_of(const Scene& scene) {
  OmittedSizes out = scene.left_out.value_or(OmittedSizes{});
  out.length = std::max(out.length, size_of_bodies(scene));
  out.travel = std::max(out.travel, size_of_travel(scene));
  for (const Body& body : scene.bodies) out.mass = std::max(out.mass, body.mass);
  return out;
}

UnitSystem natural_units(const Scene& scene) {
  const OmittedSizes sizes = sizes_of(scene);
  return {power_of_two(sizes.length > 0 ? sizes.length : sizes.travel, max_ordinary_length),
          power_of_two(sizes.mass, max_ordinary_mass)};
}

void convert(Scene& scene, const UnitSystem& units) {
  if (units.is_si()) return;
  Converter(units).convert(scene);
  scene.units = units;
}

}  // namespace gelenk

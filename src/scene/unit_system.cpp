// SPDX-License-Identifier: BSD-3-Clause
#include "scene/unit_system.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "joint/registry.h"
#include "scene/scene.h"
#include "scene/units.h"

namespace gelenk {
namespace {

struct Symbol {
  std::string_view name;
  UnitExponents exponents;  // kg, m, s, rad
};

constexpr Symbol symbols[] = {
    {"1", {0, 0, 0, 0}},   {"kg", {1, 0, 0, 0}}, {"m", {0, 1, 0, 0}},  {"s", {0, 0, 1, 0}},
    {"rad", {0, 0, 0, 1}}, {"N", {1, 1, -2, 0}}, {"J", {1, 2, -2, 0}}, {"Hz", {0, 0, -1, 0}},
};

// A symbol with an optional exponent: "m2".
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

// Sizes (masses) between 1 / usual and usual are measured in metres (kilograms).
constexpr double usual_length = 8;
constexpr double usual_mass = 1024;

double power_of_two(double x, double usual) {
  const bool ordinary = !(x > 0) || !std::isfinite(x) || (x >= 1 / usual && x <= usual);
  return ordinary ? 1 : std::exp2(std::round(std::log2(x)));
}

// The largest of some lengths.
struct Longest {
  double length = 0;
  void add(double x) {
    if (std::isfinite(x)) length = std::max(length, std::abs(x));
  }
  void add(const BodyFrame& frame, bool of_ground) {
    if ((frame.body == ground) == of_ground) add(frame.X_BF.p.norm());
  }
};

double size_of_bodies(const Scene& scene) {
  Longest out;
  for (const Body& body : scene.bodies) {
    out.add(body.com.norm());
    if (body.mass > 0) out.add(std::sqrt(body.inertia.trace() / body.mass));
  }
  for (const Joint& joint : scene.joints) {
    for (const BodyFrame* frame : {&joint.parent, &joint.child}) out.add(*frame, false);
  }
  for (const Constraint& c : scene.constraints) out.add(c.radius);
  return out.length;
}

// Of scenes whose bodies are points: how far apart things stand.
double size_of_travel(const Scene& scene) {
  Longest out;
  for (const Joint& joint : scene.joints) {
    for (const BodyFrame* frame : {&joint.parent, &joint.child}) out.add(*frame, true);
    const JointKind& kind = *find_joint_kind(joint.type);
    for (int i = 0; i < kind.nq; ++i) {
      if (kind.q[i].unit == "m" && joint.start.q_given[i]) out.add(joint.start.q[i]);
    }
  }
  for (const Force& force : scene.forces) out.add(force.length);
  return out.length;
}

class Converter {
 public:
  explicit Converter(const UnitSystem& units) : length_(1 / units.length), mass_(1 / units.mass) {}

  void convert(Scene& scene) const {
    scene.gravity *= length_;
    for (Body& body : scene.bodies) convert(body);
    for (Joint& joint : scene.joints) convert(joint);
    for (Motor& motor : scene.motors) {
      motor.rotor_inertia *= mass_ * area(slides(scene, motor.joint));
    }
    for (Force& force : scene.forces) convert(force);
    for (Constraint& c : scene.constraints) convert(scene, c);
    for (Sensor& sensor : scene.sensors) convert(sensor.frame);
  }

 private:
  // Of what acts on a coordinate: a torque has a length more than a force, and turns no length.
  double area(bool slide) const { return slide ? 1 : length_ * length_; }
  double travel(bool slide) const { return slide ? length_ : 1; }

  static bool slides(const Scene& scene, const std::string& name, const std::string& coordinate = {}) {
    const auto joint = std::ranges::find(scene.joints, name, &Joint::name);
    if (joint == scene.joints.end()) return false;
    const JointKind& kind = *find_joint_kind(joint->type);
    const auto q = std::ranges::find(kind.q, std::string_view(coordinate), &Quantity::name);
    return kind.nq > 0 && (q == kind.q.end() ? kind.q.front() : *q).unit == "m";
  }

  void convert(BodyFrame& frame) const { frame.X_BF.p *= length_; }

  void convert(Body& body) const {
    body.mass *= mass_;
    body.com *= length_;
    body.inertia *= mass_ * length_ * length_;
    if (body.pose) body.pose->p *= length_;
  }

  void convert(Joint& joint) const {
    convert(joint.parent);
    convert(joint.child);
    const JointKind& kind = *find_joint_kind(joint.type);
    const auto is_slide = [&](std::size_t i) { return kind.v[i].unit == "m/s"; };
    JointStart& start = joint.start;  // its weights stay: a length counts in the mechanism's own size
    for (std::size_t i = 0; i < start.q.size(); ++i) {
      if (kind.q[i].unit == "m") start.q[i] *= length_;
    }
    for (std::size_t i = 0; i < start.v.size(); ++i) {
      if (is_slide(i)) start.v[i] *= length_;
    }
    for (auto* field : {&joint.damping, &joint.stiffness}) {
      for (std::size_t i = 0; i < field->size(); ++i) (*field)[i] *= mass_ * area(is_slide(i));
    }
    for (std::size_t i = 0; i < joint.spring_reference.size(); ++i) {
      joint.spring_reference[i] *= travel(is_slide(i));
    }
    if (!joint.stop) return;
    for (double* bound : {&joint.stop->lower, &joint.stop->upper}) *bound *= travel(is_slide(0));
    for (double* force : {&joint.stop->stiffness, &joint.stop->damping}) *force *= mass_ * area(is_slide(0));
  }

  void convert(Force& force) const {
    for (BodyFrame* frame : {&force.from, &force.to, &force.at}) convert(*frame);
    force.stiffness *= mass_;
    force.damping *= mass_;
    force.length *= length_;
    force.force *= mass_ * length_;
    force.torque *= mass_ * length_ * length_;
  }

  void convert(const Scene& scene, Constraint& c) const {
    convert(c.at);
    convert(c.on);
    c.radius *= length_;
    if (c.type == ConstraintType::rack) {
      c.ratio *= length_;
      c.offset *= length_;
    }
    if (c.type != ConstraintType::motion) return;
    const double factor = travel(slides(scene, c.joint, c.coordinate));
    for (auto* list : {&c.motion.polynomial, &c.motion.values}) {
      for (double& x : *list) x *= factor;
    }
    c.motion.amplitude *= factor;
    c.motion.speed *= factor;
  }

  double length_, mass_;  // of a metre and a kilogram in the units
};

}  // namespace

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

LeftOut sizes_of(const Scene& scene) {
  LeftOut out = scene.left_out.value_or(LeftOut{});
  out.length = std::max(out.length, size_of_bodies(scene));
  out.travel = std::max(out.travel, size_of_travel(scene));
  for (const Body& body : scene.bodies) out.mass = std::max(out.mass, body.mass);
  return out;
}

UnitSystem natural_units(const Scene& scene) {
  const LeftOut sizes = sizes_of(scene);
  return {power_of_two(sizes.length > 0 ? sizes.length : sizes.travel, usual_length),
          power_of_two(sizes.mass, usual_mass)};
}

void convert(Scene& scene, const UnitSystem& units) {
  if (units.is_si()) return;
  Converter(units).convert(scene);
  scene.units = units;
}

}  // namespace gelenk

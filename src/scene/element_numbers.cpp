// SPDX-License-Identifier: BSD-3-Clause
#include "scene/element_numbers.h"

#include <algorithm>

#include "scene/scene.h"
#include "util/text.h"

namespace gelenk {
namespace {

void each_number(const Field* group, std::span<const Field> fields, void* element, const VisitNumber& visit) {
  for (const Field& field : fields) {
    switch (field.type) {
      case Field::Type::number:
        if (auto& x = field.of<double>(element); std::isfinite(x)) visit({group, &field, 0, 1, &x});
        break;
      case Field::Type::vector:
        for (int i = 0; i < 3; ++i) visit({group, &field, i, 3, &field.of<Eigen::Vector3d>(element)[i]});
        break;
      case Field::Type::numbers: {
        auto& list = field.of<std::vector<double>>(element);
        const int size = static_cast<int>(list.size());
        for (int i = 0; i < size; ++i) visit({group, &field, i, size, &list[static_cast<std::size_t>(i)]});
        break;
      }
      case Field::Type::group:
        if (void* there = field.in(element)) each_number(&field, field.inner(), there, visit);
        break;
      case Field::Type::direction:
      case Field::Type::flag:
      case Field::Type::choice:
      case Field::Type::formula:
      case Field::Type::formulas:
        break;
    }
  }
}

}  // namespace

std::string Number::path() const {
  return (group == nullptr ? "" : std::string(group->name) + ".") + std::string(field->name);
}

std::string Number::index() const {
  return field->type == Field::Type::number ? "" : "[" + std::to_string(i + 1) + "]";
}

void each_number(std::span<const Field> fields, void* element, const VisitNumber& visit) {
  each_number(nullptr, fields, element, visit);
}

void each_number(std::span<const Field> fields, const void* element, const VisitNumber& visit) {
  each_number(fields, const_cast<void*>(element), visit);  // NOLINT(*-const-cast): only read
}

const JointKind* kind_of_joint(const Scene& scene, std::string_view joint) {
  const auto found = std::ranges::find(scene.joints, joint, &Joint::name);
  return found == scene.joints.end() ? nullptr : find_joint_kind(found->type);
}

Coordinate coordinate_of(const JointKind& kind, int i) {
  const auto k = static_cast<std::size_t>(i);
  return {.name = kind.springs() ? kind.q[k].name : std::string_view(),
          .speed = kind.v[k].name,
          .acceleration = kind.a[k].name,
          .is_angle = kind.v[k].unit == "rad/s"};
}

std::string group_along(std::string_view group, const JointKind& joint, int i) {
  const bool is_of_joint = std::ranges::any_of(
      joint_force_kinds(), [&](const JointForceKind& kind) { return kind.of_joint && kind.group == group; });
  const bool is_one_of_several = joint.nv > 1 && !group.empty() && !is_of_joint;
  return std::string(group) + (is_one_of_several ? "." + std::string(coordinate_of(joint, i).name) : "");
}

std::string common_unit(const Field& field, const JointKind& kind) {
  std::string unit;
  for (int i = 0; i < kind.nv; ++i) {
    const std::string own =
        spelled(unit_of(field, {.name = {}, .speed = {}, .acceleration = {}, .is_angle = kind.v[i].unit == "rad/s"}));
    if (i > 0 && own != unit) return {};
    unit = own;
  }
  return unit;
}

int component_of(const JointKind& kind, std::string_view coordinate) {
  const auto found = std::ranges::find(kind.q, coordinate, &Quantity::name);
  return found == kind.q.end() ? 0 : static_cast<int>(found - kind.q.begin());
}

Coordinate coordinate_of(const JointKind* kind, std::string_view name) {
  return kind == nullptr || kind->nv == 0 ? Coordinate{} : coordinate_of(*kind, component_of(*kind, name));
}

Coordinate coordinate_of(const Scene& scene, const ElementPlace& element) {
  if (element.joints.empty()) return {};
  return coordinate_of(kind_of_joint(scene, element.joints.front()), element.coordinate);
}

std::string filled_in(std::string_view text, const ElementPlace& element, const Coordinate& coordinate) {
  std::string out(text);
  if (!element.joints.empty()) text::replace(out, "{joint}", element.joints.front());
  if (!element.frames.empty()) text::replace(out, "{body}", element.frames.front().body);
  text::replace(out, "{coordinate}", coordinate.name);
  text::replace(out, "{speed}", coordinate.speed);
  text::replace(out, "{acceleration}", coordinate.acceleration);
  text::replace(out, "{effort}", coordinate.effort());
  text::replace(out, "{torque}", coordinate.is_angle ? "torque" : "force");
  return out;
}

std::string about_any(std::string_view text, const Coordinate* coordinate) {
  std::string out(text);
  text::replace(out, "joint {joint}", "the joint");
  text::replace(out, "{joint}.", "");
  if (coordinate == nullptr) text::replace(out, "{torque}", "torque or force");
  const ElementPlace any = {
      .name = {}, .frames = {{.body = "the body", .X_BF = Pose3()}}, .joints = {"the joint"}, .coordinate = {}};
  const Coordinate unknown = {
      .name = "the coordinate", .speed = "the speed", .acceleration = "the acceleration", .is_angle = true};
  return filled_in(out, any, coordinate == nullptr ? unknown : *coordinate);
}

}  // namespace gelenk

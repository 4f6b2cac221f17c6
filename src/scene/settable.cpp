// SPDX-License-Identifier: BSD-3-Clause
#include "scene/settable.h"

#include <algorithm>
#include <array>
#include <utility>

#include "scene/element_numbers.h"
#include "scene/formulas.h"

namespace gelenk {
namespace {

constexpr std::array<const char*, 3> axis_names = {"x", "y", "z"};
// Row and column of the six numbers of the inertia matrix.
constexpr std::array<std::array<int, 2>, 6> inertia_places = {{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

// Calls visit(element) for element i of the given section.
template <class S, class Visit>
void at_element(S& scene, int section, std::size_t i, Visit visit) {
  int n = 0;
  each_section(scene, [&](const Section&, auto& elements) {
    if (n++ == section) visit(elements[i]);
  });
}

double& number_in(const Field* group, const Field& field, void* element, int i) {
  void* owner = group == nullptr ? element : group->in(element);
  switch (field.type) {
    case Field::Type::vector:
      return field.of<Eigen::Vector3d>(owner)[i];
    case Field::Type::numbers:
      return field.of<std::vector<double>>(owner)[static_cast<std::size_t>(i)];
    default:
      return field.of<double>(owner);
  }
}

// Appends finish(number) for each settable number among the fields of an element.
void add(std::vector<SettableNumber>& out, SettableNumber::Of of, std::size_t owner, std::span<const Field> fields,
         const void* element, const auto& finish) {
  each_number(fields, element, [&](const Number& x) {
    if (x.field->settable) out.push_back(finish(SettableNumber(of, owner, x.group, *x.field, x.i, x.size)));
  });
}

// Whether the alternative is given with which the field goes.
bool has_meaning(const Field& field, std::span<const Field> among, const void* element) {
  return field.goes_with == 0 || std::ranges::any_of(among, [&](const Field& other) {
           return other.alternative == field.goes_with && is_given(other, element);
         });
}

void add_joint(std::vector<SettableNumber>& out, const Joint& joint, std::size_t j) {
  using Of = SettableNumber::Of;
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr) return;
  add(out, Of::joint, j, kind->fields, data_of(*joint.is), std::identity());
  for (const JointForceKind& force : joint_force_kinds()) {
    if (!force.fits(*kind)) continue;
    for (const Field& field : force.fields) {
      for (int i = 0; i < kind->nv; ++i) {
        const void* there = force.in(*joint.along[static_cast<std::size_t>(i)]);
        if (there == nullptr || !has_meaning(field, force.fields, there)) continue;
        add(out, Of::along, j, std::span(&field, 1), there,
            [&](const SettableNumber& x) { return x.along(force, i, *kind); });
      }
    }
  }
  for (const Of end : {Of::parent, Of::child}) {
    for (int i = 0; i < 3; ++i) out.push_back(SettableNumber(end, j).at(i, 3));
  }
}

}  // namespace

SettableNumber SettableNumber::at(int i, int size) const {
  SettableNumber out = *this;
  out.i_ = i;
  out.size_ = size;
  return out;
}

SettableNumber SettableNumber::in_section(int section) const {
  SettableNumber out = *this;
  out.section_ = section;
  return out;
}

SettableNumber SettableNumber::along(const JointForceKind& force, int coordinate, const JointKind& joint) const {
  SettableNumber out = force.group.empty() ? at(coordinate, joint.nv) : *this;
  out.force_ = &force;
  out.joint_ = &joint;
  out.coordinate_ = coordinate;
  return out;
}

const std::string& SettableNumber::owner(const Scene& scene) const {
  if (of_ == Of::constant) return scene.constants[owner_].name;
  if (of_ == Of::body || of_ == Of::inertia) return scene.bodies[owner_].name;
  if (of_ != Of::element) return scene.joints[owner_].name;
  const std::string* name = nullptr;
  at_element(scene, section_, owner_, [&](const ElementPlace& element) { name = &element.name; });
  return *name;
}

std::string SettableNumber::key() const {
  if (of_ == Of::inertia) return "inertia";
  if (of_ == Of::parent) return "parent.position";
  if (of_ == Of::child) return "child.position";
  std::string group;
  if (force_ != nullptr) group = group_along(force_->group, *joint_, coordinate_);
  if (group_ != nullptr) group = group_->name;
  return (group.empty() ? "" : group + ".") + std::string(field_->name);
}

std::string SettableNumber::path(const Scene& scene) const {
  return of_ == Of::constant ? owner(scene) : owner(scene) + "." + key();
}

std::string SettableNumber::index() const {
  if (of_ == Of::constant) return {};
  const bool alone = field_ != nullptr && field_->type == Field::Type::number && size_ == 1;
  return alone ? "" : "[" + std::to_string(i_ + 1) + "]";
}

std::string SettableNumber::variable(const Scene& scene) const {
  if (of_ == Of::constant) return owner(scene);
  const bool renamed = field_ != nullptr && !field_->variable.empty();
  return owner(scene) + "." + (renamed ? std::string(field_->variable) : key()) + index();
}

Coordinate SettableNumber::coordinate(const Scene& scene) const {
  if (of_ == Of::along) return coordinate_of(kind_of(*scene.joints[owner_].is), coordinate_);
  Coordinate out;
  if (of_ == Of::element) {
    at_element(scene, section_, owner_, [&](const ElementPlace& element) { out = coordinate_of(scene, element); });
  }
  return out;
}

std::string SettableNumber::unit(const Scene& scene) const {
  if (of_ == Of::constant) return "1";
  if (of_ == Of::inertia) return "kg.m2";
  if (field_ == nullptr) return "m";
  return unit_of(*field_, coordinate(scene), static_cast<std::size_t>(of_ == Of::along ? 0 : i_));
}

std::string SettableNumber::description(const Scene& scene) const {
  if (of_ == Of::constant) return "constant of expressions, in SI units";
  if (of_ == Of::inertia) {
    const auto& [r, c] = inertia_places[static_cast<std::size_t>(i_)];
    return std::string("inertia about the center of mass, ") + axis_names[static_cast<std::size_t>(r)] +
           axis_names[static_cast<std::size_t>(c)];
  }
  const auto component = [&](const std::string& text) {
    return text + ", " + axis_names[static_cast<std::size_t>(i_)] + " component";
  };
  if (of_ == Of::parent || of_ == Of::child) {
    const Joint& joint = scene.joints[owner_];
    return component("position of its frame in " + (of_ == Of::parent ? joint.parent : joint.child).body);
  }
  std::string text;
  if (of_ == Of::element) {
    at_element(scene, section_, owner_, [&](const ElementPlace& element) {
      text = filled_in(field_->text, element, coordinate_of(scene, element));
    });
  } else {
    text = filled_in(field_->text, {}, coordinate(scene));
  }
  if (field_->by_time) return "coefficient of t^" + std::to_string(i_);
  return field_->type == Field::Type::vector ? component(text) : text;
}

double SettableNumber::min() const {
  constexpr double none = -std::numeric_limits<double>::infinity();
  if (of_ == Of::inertia) return i_ < 3 ? 0 : none;
  if (field_ == nullptr || field_->range == Range::any || field_->range == Range::not_zero) return none;
  return 0;
}

bool SettableNumber::keeps_positions() const {
  if (of_ == Of::body || of_ == Of::inertia) return true;
  const bool of_force = of_ == Of::along || of_ == Of::joint ||
                        (of_ == Of::element && (section_ == static_cast<int>(sections::motors) ||
                                                section_ == static_cast<int>(sections::forces)));
  return of_force && tunable();
}

double& SettableNumber::place(Scene& scene) const {
  switch (of_) {
    case Of::constant:
      return scene.constants[owner_].value;
    case Of::body:
      return number_in(group_, *field_, &scene.bodies[owner_], i_);
    case Of::inertia: {
      const auto& [r, c] = inertia_places[static_cast<std::size_t>(i_)];
      return scene.bodies[owner_].inertia(r, c);
    }
    case Of::joint:
      return number_in(group_, *field_, data_of(*scene.joints[owner_].is), i_);
    case Of::along:
      return number_in(group_, *field_,
                       force_->find(*scene.joints[owner_].along[static_cast<std::size_t>(coordinate_)]), 0);
    case Of::parent:
      return scene.joints[owner_].parent.X_BF.p[i_];
    case Of::child:
      return scene.joints[owner_].child.X_BF.p[i_];
    case Of::element:
      break;
  }
  double* out = nullptr;
  at_element(scene, section_, owner_,
             [&](auto& element) { out = &number_in(group_, *field_, data_of(*element.is), i_); });
  return *out;
}

double SettableNumber::get(const Scene& scene) const {
  return place(const_cast<Scene&>(scene));  // NOLINT(*-const-cast): only read
}

void SettableNumber::put(Scene& scene, double value) const {
  place(scene) = value;
  if (of_ == Of::constant || (of_ == Of::element && section_ == sections::components)) renew_formulas(scene);
  if (of_ != Of::inertia) return;
  const auto& [r, c] = inertia_places[static_cast<std::size_t>(i_)];
  scene.bodies[owner_].inertia(c, r) = value;
}

std::vector<SettableNumber> settable_numbers(const Scene& scene) {
  using Of = SettableNumber::Of;
  std::vector<SettableNumber> out;
  for (std::size_t i = 0; i < scene.constants.size(); ++i) out.emplace_back(Of::constant, i);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    add(out, Of::body, b, Body::fields(), &scene.bodies[b], std::identity());
    for (int i = 0; i < 6; ++i) out.push_back(SettableNumber(Of::inertia, b).at(i, 6));
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) add_joint(out, scene.joints[j], j);
  int section = 0;
  each_section(scene, [&](const Section&, const auto& elements) {
    for (std::size_t i = 0; i < elements.size(); ++i) {
      add(out, Of::element, i, kind_of(*elements[i].is).fields, data_of(*elements[i].is),
          [&](const SettableNumber& x) { return x.in_section(section); });
    }
    ++section;
  });
  return out;
}

std::vector<Settable> settables(const Scene& scene) {
  std::vector<Settable> out = {{"gravity", 3}};
  for (const SettableNumber& number : settable_numbers(scene)) {
    std::string path = number.path(scene);
    if (out.back().path == path) {
      ++out.back().size;
    } else {
      out.push_back({std::move(path), 1});
    }
  }
  return out;
}

namespace {

void take(std::span<const Field> fields, void* to, const void* from) {
  if (to == nullptr || from == nullptr) return;
  for (const Field& field : fields) {
    if (field.type == Field::Type::group) take(field.inner(), field.in(to), field.in(from));
    if (!field.tunable) continue;
    if (field.type == Field::Type::number) field.of<double>(to) = field.of<double>(from);
    if (field.type == Field::Type::vector) field.of<Eigen::Vector3d>(to) = field.of<Eigen::Vector3d>(from);
  }
}

template <class Any>
void take(std::vector<Element<Any>>& to, const std::vector<Element<Any>>& from) {
  for (std::size_t i = 0; i < to.size(); ++i) take(kind_of(*to[i].is).fields, data_of(*to[i].is), data_of(*from[i].is));
}

}  // namespace

void take_tunables(Scene& scene, const Scene& from) {
  scene.gravity = from.gravity;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const std::span<const Field> own = kind_of(*scene.joints[j].is).fields;
    take(own, data_of(*scene.joints[j].is), data_of(*from.joints[j].is));
    for (std::size_t i = 0; i < scene.joints[j].along.size(); ++i) {
      for (const JointForceKind& force : joint_force_kinds()) {
        take(force.fields, force.find(*scene.joints[j].along[i]), force.in(*from.joints[j].along[i]));
      }
    }
  }
  take(scene.motors, from.motors);
  take(scene.forces, from.forces);
  take(scene.constraints, from.constraints);
  take(scene.contacts, from.contacts);
}

}  // namespace gelenk

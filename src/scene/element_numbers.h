// SPDX-License-Identifier: BSD-3-Clause
// Enumerates the numbers of a scene's elements and joint forces, with their units, and fills in texts about elements.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "scene/element_place.h"

namespace gelenk {

// "a universal joint", in messages.
inline std::string a_kind(const JointKind& kind) { return "a " + std::string(kind.name) + " joint"; }

struct Scene;

// One number of an element: a scalar field or a component of a vector or list, possibly inside a group of fields.
struct Number {
  const Field* group = nullptr;
  const Field* field = nullptr;
  int i = 0, size = 1;  // index in its vector or list, and the size of that
  double* value = nullptr;

  // Name of the field without an index: "stiffness", "sine.phase", "polynomial".
  std::string path() const;
  // Index from 1, as "[2]"; empty for a scalar field.
  std::string index() const;
  // Unit in the spelling of FMI; `coordinate` decides between units of angle and of length.
  std::string unit(const Coordinate& coordinate) const {
    return unit_of(*field, coordinate, static_cast<std::size_t>(i));
  }
};

using VisitNumber = std::function<void(const Number&)>;

// Calls visit() for every number among the fields of an element; optional numbers that are not given are skipped.
void each_number(std::span<const Field> fields, void* element, const VisitNumber& visit);
// The same for a constant element: visit() must not change the numbers.
void each_number(std::span<const Field> fields, const void* element, const VisitNumber& visit);

// Returns the kind of the joint with this name, or nullptr if the scene has no such joint or its kind is unknown.
const JointKind* kind_of_joint(const Scene& scene, std::string_view joint);
// Returns the coordinate of a joint with this name, or its first one if there is none; a default if kind is nullptr.
Coordinate coordinate_of(const JointKind* kind, std::string_view name = {});
// Returns the coordinate that belongs to velocity i of a joint.
Coordinate coordinate_of(const JointKind& kind, int i);
// The place of a group of fields along coordinate i in its joint: "friction", of several coordinates "friction.phi_a".
// Empty if there is no group. That of an element which acts on the whole joint is its name.
std::string group_along(std::string_view group, const JointKind& joint, int i);
// Returns the joint coordinate on which an element acts; a default for elements without a joint.
Coordinate coordinate_of(const Scene& scene, const ElementPlace& element);
// Returns the unit, as spelled in messages, of a field given for each coordinate of a joint; empty if the units differ.
std::string common_unit(const Field& field, const JointKind& kind);
// Returns the index of the coordinate with this name among those of the joint; 0 if there is none.
int component_of(const JointKind& kind, std::string_view coordinate);

// Replaces the placeholders of a text (element/element.h) by the names of the element's ports and coordinate.
std::string filled_in(std::string_view text, const ElementPlace& element, const Coordinate& coordinate);
// Replaces the placeholders by general terms ("the joint"). coordinate: nullptr for a general coordinate, too.
std::string about_any(std::string_view text, const Coordinate* coordinate = nullptr);

}  // namespace gelenk

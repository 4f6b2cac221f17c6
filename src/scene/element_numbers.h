// SPDX-License-Identifier: BSD-3-Clause
// The numbers of a scene's elements and of what joints have along their coordinates, one by one, with their units.
#pragma once

#include <functional>
#include <string>

#include "scene/scene.h"

namespace gelenk {

// A number of an element: a field, or a component of one, directly or in a group.
struct Number {
  const Field* group = nullptr;
  const Field* field = nullptr;
  int i = 0, size = 1;  // its place in a vector or list
  double* value = nullptr;

  // "stiffness", "sine.phase", "polynomial": without an index.
  std::string path() const;
  // Elements of lists count from 1: "[2]"; nothing where there is one number.
  std::string index() const;
  std::string unit(const Coordinate& coordinate) const {
    return unit_of(*field, coordinate, static_cast<std::size_t>(i));
  }
};

using VisitNumber = std::function<void(const Number&)>;

// Those of an element's fields that are given.
void each_number(std::span<const Field> fields, void* element, const VisitNumber& visit);
// The visitor changes none.
void each_number(std::span<const Field> fields, const void* element, const VisitNumber& visit);

// Joint `joint` of the scene, if there is one and its kind is known.
const JointKind* kind_of_joint(const Scene& scene, std::string_view joint);
// The coordinate of that name of a joint, or its first.
Coordinate coordinate_of(const JointKind* kind, std::string_view name = {});
Coordinate coordinate_of(const JointKind& kind, int i);
// What an element is about.
Coordinate coordinate_of(const Scene& scene, const ElementPlace& element);
// Of a field that each of a joint's coordinates has, as messages spell it; empty where the coordinates differ in it.
std::string common_unit(const Field& field, const JointKind& kind);
// Its place among the joint's coordinates.
int component_of(const JointKind& kind, std::string_view coordinate);

// A text in which the names of an element's ports stand for placeholders (element/element.h).
std::string filled_in(std::string_view text, const ElementPlace& element, const Coordinate& coordinate);
// The same of any element: "the joint". coordinate: null where that is any, too.
std::string about_any(std::string_view text, const Coordinate* coordinate = nullptr);

}  // namespace gelenk

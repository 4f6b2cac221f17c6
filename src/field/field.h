// SPDX-License-Identifier: BSD-3-Clause
// Fields: the values that an element of a scene can be given, declared once. Reading, checking, writing, the JSON
// Schema, units, FMU parameters and tunable values are derived from the declaration.
//
//   struct SpringDamper {
//     double stiffness = 0;
//     static std::span<const Field> fields() {
//       static constexpr Field all[] = {field<&SpringDamper::stiffness>(
//           {.name = "stiffness", .unit = "N/m", .text = "stiffness", .range = Range::not_negative, .tunable = true})};
//       return all;
//     }
//   };
//
// The initial value of a member is the field's default.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "field/formula.h"

namespace gelenk {

// Permitted range of a number.
enum class Range { any, not_negative, positive, not_zero, fraction, at_most_one };

// Index of one of a field's words, or none.
struct Choice {
  static constexpr int none = -1;
  int index = none;
};

struct Field;

// Properties of a field, as declared by its element.
struct FieldInfo {
  std::string_view name;           // key in scene files
  std::string_view unit = {};      // in FMI's spelling; {q}, {v}, {a}, {f}, {J}: see unit_of()
  std::string_view text = {};      // description; completes "C: ..."
  std::string_view variable = {};  // name in FMUs, if it differs
  Range range = Range::any;
  bool required = false;
  bool optional = false;      // of a number: not finite if it is not given
  bool tunable = false;       // may change during a simulation
  bool settable = true;       // may be a parameter
  bool by_time = false;       // of a list: entry i, from 0, has this unit divided by s^i
  int alternative = 0;        // if not 0: exactly one alternative must be given, by one or more of its fields
  int goes_with = 0;          // if not 0: of no meaning with another alternative
  std::size_t min_count = 0;  // of a list that is given: minimum number of entries
  std::span<const std::string_view> words = {};     // of a choice: its permitted values
  std::span<const FormulaVariable> variables = {};  // of a formula
  FormulaReads reads = FormulaReads::nothing;       // of a formula: what it may name
};

struct Field : FieldInfo {
  enum class Type {
    number,     // double
    vector,     // Eigen::Vector3d
    direction,  // Direction
    numbers,    // std::vector<double>; empty if not given
    flag,       // bool
    choice,     // Choice
    formula,    // Formula
    formulas,   // std::array<Formula, 3>: components of a vector
    group,      // std::optional of a struct with fields(): a nested mapping in scene files
  };
  Type type = Type::number;
  void* (*locate)(void*) = nullptr;  // address of the value in an element; null for a group that is not given
  void (*emplace)(void*) = nullptr;  // creates the group in an element, with default values
  std::span<const Field> (*inner)() = nullptr;  // fields of the group
  const void* (*defaults)() = nullptr;          // a group with default values

  // Address of the value in the element; null for a group that is not given.
  void* in(void* element) const { return locate(element); }
  const void* in(const void* element) const {
    return locate(const_cast<void*>(element));  // NOLINT(*-const-cast): only an address is computed
  }
  // The value in the element, of the type of the field.
  template <class T>
  T& of(void* element) const {
    return *static_cast<T*>(in(element));
  }
  template <class T>
  const T& of(const void* element) const {
    return *static_cast<const T*>(in(element));
  }
};

// An error in an element that the ranges of its fields do not cover: the field, or empty for the whole element; what
// was found and what was expected.
struct ElementFault {
  std::string field, found, expected;
};

// A unit vector.
struct Direction {
  Eigen::Vector3d along = Eigen::Vector3d::UnitZ();
};

namespace detail {

template <class T>
struct FieldType;
template <>
struct FieldType<double> {
  static constexpr auto value = Field::Type::number;
};
template <>
struct FieldType<Eigen::Vector3d> {
  static constexpr auto value = Field::Type::vector;
};
template <>
struct FieldType<Direction> {
  static constexpr auto value = Field::Type::direction;
};
template <>
struct FieldType<std::vector<double>> {
  static constexpr auto value = Field::Type::numbers;
};
template <>
struct FieldType<bool> {
  static constexpr auto value = Field::Type::flag;
};
template <>
struct FieldType<Choice> {
  static constexpr auto value = Field::Type::choice;
};
template <>
struct FieldType<Formula> {
  static constexpr auto value = Field::Type::formula;
};
template <>
struct FieldType<std::array<Formula, 3>> {
  static constexpr auto value = Field::Type::formulas;
};
template <class Group>
struct FieldType<std::optional<Group>> {
  static constexpr auto value = Field::Type::group;
};

template <class Element, class Member>
Element owner_of(Member Element::*);
template <class Element, class Member>
Member member_of(Member Element::*);

}  // namespace detail

// Returns the Field for a member of an element.
template <auto member>
constexpr Field field(const FieldInfo& info) {
  using Element = decltype(detail::owner_of(member));
  using Member = decltype(detail::member_of(member));
  Field out{info};
  out.type = detail::FieldType<Member>::value;
  if constexpr (detail::FieldType<Member>::value == Field::Type::group) {
    out.locate = [](void* element) -> void* {
      Member& group = static_cast<Element*>(element)->*member;
      return group ? &*group : nullptr;
    };
    out.emplace = [](void* element) { (static_cast<Element*>(element)->*member).emplace(); };
    out.inner = &Member::value_type::fields;
    out.defaults = []() -> const void* {
      static const typename Member::value_type group;
      return &group;
    };
  } else {
    out.locate = [](void* element) -> void* { return &(static_cast<Element*>(element)->*member); };
  }
  return out;
}

// The joint coordinate on which an element acts or to which it refers.
struct Coordinate {
  std::string_view name{}, speed{}, acceleration{};  // names of the coordinate and of its derivatives: "phi", "w", "a"
  bool is_angle = true;                              // unit rad, otherwise m

  std::string_view effort() const { return is_angle ? "tau" : "f"; }
};

// Returns the unit with the placeholders {q}, {v}, {a}, {f} and {J} replaced by the units of the coordinate, its speed,
// its acceleration, its generalized force and its inertia.
std::string unit_of(std::string_view unit, const Coordinate& coordinate);
// Returns the unit of a field; of a list, the unit of entry i.
std::string unit_of(const Field& field, const Coordinate& coordinate, std::size_t i = 0);
// Whether x is in the permitted range.
bool permits(Range allowed, double x);
// Describes the permitted range of a number with this unit: "0 kg or more".
std::string bound(Range allowed, std::string_view unit);

// The formulas of a field of either type.
std::span<Formula> formulas_of(const Field& field, void* element);
std::span<const Formula> formulas_of(const Field& field, const void* element);
// The variables of a formula; those that do not exist at this coordinate have no name.
std::vector<FormulaVariable> variables_of(const Field& field, const Coordinate& coordinate);

// Whether the field has a value in this element; always true for types that cannot be absent.
bool is_given(const Field& field, const void* element);
// Returns the names of the fields of each alternative; entry i is alternative i + 1.
std::vector<std::vector<std::string>> alternatives_of(std::span<const Field> fields);

// Returns a unit as it is spelled in messages: "N m s/rad" for "N.m.s/rad", empty for "1".
std::string spelled(std::string unit);

}  // namespace gelenk

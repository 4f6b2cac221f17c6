// SPDX-License-Identifier: BSD-3-Clause
// What an element of a scene can be given, stated once: reading, checking, writing, the JSON Schema, units, parameters
// of FMUs and the numbers that may change during a run follow from it.
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
// What a member holds at first is its default.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

// What a number may be.
enum class Range { any, not_negative, positive, not_zero };

// One of a field's words; else none of them.
struct Choice {
  static constexpr int none = -1;
  int index = none;
};

struct Field;

// Said of a field by its element.
struct FieldFacts {
  std::string_view name;           // in scene files
  std::string_view unit = {};      // as FMI spells it; {q}, {v}, {f}, {J}: see unit_of()
  std::string_view text = {};      // completes "C: ..."
  std::string_view variable = {};  // what FMUs call it, where that is another name
  Range range = Range::any;
  bool required = false;
  bool optional = false;  // a number: not finite where it is not given
  bool tunable = false;   // may change while a simulation runs
  bool settable = true;   // may be a parameter
  bool by_time = false;   // of a list: its unit is divided by s once more at each place
  int way = 0;            // of the fields with ways, those of one way must be given, and of no other
  std::size_t least = 0;  // numbers that a list has, if it is there
  std::span<const std::string_view> words = {};  // of a choice
};

struct Field : FieldFacts {
  enum class Type {
    number,     // double
    vector,     // Eigen::Vector3d
    direction,  // Direction
    numbers,    // std::vector<double>; empty: it is not given
    flag,       // bool
    choice,     // Choice
    group,      // std::optional of a struct with fields(), which are in a mapping of their own
  };
  Type type = Type::number;
  void* (*locate)(void*) = nullptr;             // of an element; of a group that is not given: null
  void (*give)(void*) = nullptr;                // puts a group there, with its defaults
  std::span<const Field> (*inner)() = nullptr;  // of a group
  const void* (*defaults)() = nullptr;          // one of a group, as it is put there

  void* in(void* element) const { return locate(element); }
  const void* in(const void* element) const {
    return locate(const_cast<void*>(element));  // NOLINT(*-const-cast): it takes an address only
  }
  template <class T>
  T& of(void* element) const {
    return *static_cast<T*>(in(element));
  }
  template <class T>
  const T& of(const void* element) const {
    return *static_cast<const T*>(in(element));
  }
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
template <class Group>
struct FieldType<std::optional<Group>> {
  static constexpr auto value = Field::Type::group;
};

template <class Element, class Member>
Element owner_of(Member Element::*);
template <class Element, class Member>
Member member_of(Member Element::*);

}  // namespace detail

// The field that a member of an element is.
template <auto member>
constexpr Field field(const FieldFacts& facts) {
  using Element = decltype(detail::owner_of(member));
  using Member = decltype(detail::member_of(member));
  Field out{facts};
  out.type = detail::FieldType<Member>::value;
  if constexpr (detail::FieldType<Member>::value == Field::Type::group) {
    out.locate = [](void* element) -> void* {
      Member& group = static_cast<Element*>(element)->*member;
      return group ? &*group : nullptr;
    };
    out.give = [](void* element) { (static_cast<Element*>(element)->*member).emplace(); };
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

// A coordinate of a joint that an element acts on or is about.
struct Coordinate {
  std::string_view name, speed;  // "phi", "w"
  bool is_angle = true;          // rad, else m

  std::string_view effort() const { return is_angle ? "tau" : "f"; }
};

// A unit with {q}, {v}, {f} and {J} replaced by those of a coordinate, its speed, the effort on it, its inertia.
std::string unit_of(std::string_view unit, const Coordinate& coordinate);
// Of the i-th of a list's numbers.
std::string unit_of(const Field& field, const Coordinate& coordinate, std::size_t i = 0);
// Whether a number may be what x is.
bool permits(Range allowed, double x);
// What a number in that unit has to be: "0 kg or more".
std::string bound(Range allowed, std::string_view unit);

// Whether an optional field is given.
bool is_given(const Field& field, const void* element);
// The names of the fields of each way, by way from 1 on.
std::vector<std::vector<std::string>> ways_of(std::span<const Field> fields);

// A unit as messages spell it: "N.m.s/rad" as "N m s/rad", none as nothing.
std::string spelled(std::string unit);

}  // namespace gelenk

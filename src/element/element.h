// SPDX-License-Identifier: BSD-3-Clause
// What elements of all kinds say of themselves. An element is a struct of the numbers that a scene gives it, with
//
//   kind, summary     its type in scene files, and what it is, in a few words
//   ports             the bodies' frames and the joints that it is at, frames first
//   fields()          what it can be given (field/field.h)
//   inputs()          signals from outside; may be left out
//   outputs           signals that it tells; may be left out
//   fault(coordinate) what is wrong with its numbers beyond each field's own range; may be left out
//
// and what its kind of element does: force.h, coordinate_force.h, constraint.h, sensor.h. registry.h lists them all.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "field/field.h"
#include "joint/kind.h"
#include "math/spatial.h"

namespace gelenk {

inline constexpr const char* ground = "ground";  // the body that stands still; its frame is the world W

// A frame fixed in a body.
struct BodyFrame {
  std::string body = ground;
  Pose3 X_BF;  // pose in the body's frame
};

// Where an element takes hold.
struct Port {
  enum class Kind {
    frame,  // of a body
    point,  // of a body: a frame whose orientation does not count
    body,   // a frame of which only the body counts
    joint,
  };
  Kind kind = Kind::frame;
  std::string_view name;  // in scene files; empty, of a frame: body, position and rotation are among the element's own
  std::string_view text;
  bool optional = false;
  bool on_ground = true;                     // a frame: the ground will do
  bool has_coordinate = false;               // a joint: the element is about one of its coordinates
  bool (*fits)(const JointKind&) = nullptr;  // joints that will do; all
};

// When a signal is known.
enum class Stage { position, velocity, acceleration };

// A number, or the x, y, z components of a vector and a quaternion's scalar part. In texts, names and units {joint},
// {coordinate}, {speed}, {effort}, {torque} stand for those of the element's first joint ("torque" or "force"), {body}
// for its first frame's body, {q}, {v}, {f} for units (field/field.h).
struct SignalGroup {
  std::string_view name;
  int size = 0;  // 0: a number
  std::string_view unit, text;
  Stage stage = Stage::acceleration;
  enum class Start { zero, coordinate, speed } start = Start::zero;  // an input's: that of the joint's

  constexpr int count() const { return size == 0 ? 1 : size; }
};

inline int count_of(std::span<const SignalGroup> groups) {
  int n = 0;
  for (const SignalGroup& group : groups) n += group.count();
  return n;
}
template <class E>
std::span<const SignalGroup> own_inputs(const E& element) {
  if constexpr (requires { element.inputs(); }) return element.inputs();
  return {};
}

// Something is wrong with an element: its field, or none where it is all of it.
struct ElementFault {
  std::string field, found, expected;
};

}  // namespace gelenk

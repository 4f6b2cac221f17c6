// SPDX-License-Identifier: BSD-3-Clause
// The interface that elements of all sections share. An element is a struct of the values that a scene gives it, with
//
//   kind, summary      its type in scene files, and a short description
//   ports              frames on bodies and joints to which it refers, frames first
//   fields()           its fields (field/field.h)
//   inputs()           its input signals; optional
//   outputs            its output signals; optional
//   fault(coordinate)  error in its values that the ranges of the fields do not cover; optional
//   doubt()            what is probably not intended, as a warning; optional, not of forces along joints
//
// and the functions of its section: forces/force.h, joint_forces/coordinate_force.h, constraints/constraint.h,
// sensors/sensor.h. The registry.h of each section lists its elements.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "field/field.h"
#include "joint/kind.h"
#include "math/spatial.h"

namespace gelenk {

inline constexpr const char* ground = "ground";  // the fixed body; its frame is the world frame W

// A frame fixed in a body.
struct BodyFrame {
  std::string body = ground;
  Pose3 X_BF;  // pose of the frame in the body's frame
};

// A frame, a joint or a pair of surfaces to which an element refers.
struct Port {
  enum class Kind {
    frame,     // a frame on a body
    point,     // a point on a body: a frame without orientation
    body,      // a body: a frame without position and orientation
    joint,     // a joint
    surfaces,  // two surfaces of shapes
  };
  Kind kind = Kind::frame;
  std::string_view name;  // key in scene files; if empty, body, position and rotation are keys of the element
  std::string_view text;  // description
  bool optional = false;
  bool on_ground = true;                     // of a frame: whether the body may be the ground
  bool has_coordinate = false;               // of a joint: the element refers to one of its coordinates
  bool is_prescribed = false;                // of a coordinate: no other element may prescribe it
  bool is_alike = false;                     // of a joint: its coordinate has the unit of that of the first joint
  bool (*fits)(const JointKind&) = nullptr;  // permitted joint types; null for all

  bool is_frame() const { return kind != Kind::joint && kind != Kind::surfaces; }
};

// The evaluation stage that a signal requires.
enum class Stage { position, velocity, acceleration };

// A signal: a number, or an array such as the components x, y, z of a vector or x, y, z and scalar part of a
// quaternion. Placeholders in texts, names and units: {joint}, {coordinate}, {speed}, {effort} (names) and {torque}
// ("torque" or "force") of the element's first joint, {body} of its first frame, and the units {q}, {v}, {f}
// (field/field.h).
struct SignalGroup {
  std::string_view name;
  int size = 0;  // of an array; 0 for a number
  std::string_view unit, text;
  Stage stage = Stage::acceleration;
  enum class Start { zero, one, coordinate, speed } start = Start::zero;  // start value of an input

  constexpr int count() const { return size == 0 ? 1 : size; }
};

// Total number of scalar signals.
inline int count_of(std::span<const SignalGroup> groups) {
  int n = 0;
  for (const SignalGroup& group : groups) n += group.count();
  return n;
}
// The input signals of an element; empty if it has none.
template <class E>
std::span<const SignalGroup> own_inputs(const E& element) {
  if constexpr (requires { element.inputs(); }) return element.inputs();
  return {};
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// A one-way clutch (freewheel, backstop), a set-valued law: the coordinate moves freely in one direction, and cannot
// move in the other. It is a hard limit of the speed instead of the position: at rest the torque takes the value, in
// the free direction only, that keeps the coordinate from moving back; a speed in the other direction ends at once, by
// an inelastic impact.
struct JointOneWay {
  static constexpr std::string_view group = "one_way";
  static constexpr std::string_view summary = "one-way clutch, which permits motion in one direction only";
  static constexpr std::string_view misfit =
      "has no angles or lengths that it could act on";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.springs(); }

  static constexpr std::string_view directions[] = {"positive", "negative"};
  Choice free = {0};  // index in directions

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&JointOneWay::free>(
        {.name = "free", .text = "direction in which {coordinate} can move", .required = true, .words = directions})};
    return all;
  }

  static constexpr SignalGroup outputs[] = {
      {"{effort}", 0, "{f}", "{torque} of the one-way clutch on {joint}.{coordinate}, in its direction"},
      {"mode", 0, "1",
       "1, -1: the one-way clutch keeps {joint}.{coordinate} from moving in its positive, negative direction; 0: it "
       "overruns"}};

  // 1 if motion in the positive direction is prevented, -1 if in the negative one.
  int blocked() const { return free.index == 1 ? 1 : -1; }

  // In the interface of limits (coordinate_force.h), with a bound that is always touched on the blocked side.
  static constexpr bool bounds_speed = true;
  static constexpr double restitution = 0;
  static constexpr bool is_poisson() { return false; }
  double depth(int side, double) const { return side == blocked() ? 0 : -std::numeric_limits<double>::infinity(); }
  static double touch_tolerance(int) { return 1e-12; }

  // Modes: blocked() where it holds the coordinate, with a torque that the equations of motion determine; otherwise 0.
  template <class T>
  T held(int, const T&, const T&, const T*) const {
    return T(0);
  }
  template <class T>
  int side(const T&, const T& v) const {
    return T(blocked()) * v > T(0) ? blocked() : 0;
  }
  template <class T>
  T effort(const T&, const T&, const T*) const {
    return T(0);
  }
  // The event indicators in a mode: of holding it against motion in the positive and in the negative direction. x: the
  // torque that keeps the coordinate at rest. adhesion: how far x may be in the other direction, by friction.
  void indicators(int side, double v, double a, double x, double adhesion, double* g, double* gdot) const {
    for (const int bound : {1, -1}) {
      const bool is_held = side == bound;
      *g++ = bound != blocked() ? -1 : is_held ? adhesion - side * x : bound * v;
      *gdot++ = bound != blocked() || is_held ? NAN : bound * a;
    }
  }
  // For each indicator, the texts of the events at which it begins to overrun, and to hold.
  static constexpr std::string_view events[2][2] = {
      {"the one-way clutch of {joint}.{coordinate} overruns", "the one-way clutch of {joint}.{coordinate} holds"},
      {"the one-way clutch of {joint}.{coordinate} overruns", "the one-way clutch of {joint}.{coordinate} holds"}};
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// A lock of a whole joint, which an input engages and releases, such as a docking port, a latch or the hook of a load.
// Released, it is without effect. While it is engaged, forces of any size along all velocities of the joint keep them
// zero. Engaged in motion, it ends this motion at once by a perfectly plastic impact: all bodies keep their momentum
// but for the impulses of joints and contacts, and the kinetic energy decreases by 1/2 dv^T M dv (Moreau 1988).
struct JointLock {
  static constexpr std::string_view group = "lock";
  static constexpr std::string_view summary = "lock, which an input engages: the joint is then rigid";
  static constexpr std::string_view misfit = "cannot move";
  static bool fits(const JointKind& kind) { return kind.nv > 0; }
  static constexpr bool holds_joint = true;  // it belongs to the joint, not to one of its coordinates

  bool engaged = false;  // without an input always, otherwise at the start
  static constexpr std::string_view inputs_of_it[] = {"engagement"};
  Choice input;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&JointLock::input>(
            {.name = "input", .text = "the input that engages it where it is above 0.5", .words = inputs_of_it}),
        field<&JointLock::engaged>(
            {.name = "engaged", .text = "whether it is engaged: at the start if it has an input, otherwise always"})};
    return all;
  }
  std::span<const SignalGroup> inputs() const {
    static constexpr std::string_view text = "above 0.5: the lock of {joint} is engaged; otherwise it is released";
    static constexpr SignalGroup released[] = {{"engagement", 0, "1", text}};
    static constexpr SignalGroup at_once[] = {
        {"engagement", 0, "1", text, Stage::acceleration, SignalGroup::Start::one}};
    if (!has_input()) return {};
    return engaged ? std::span<const SignalGroup>(at_once) : released;
  }
  static constexpr SignalGroup outputs[] = {
      {"{effort}", 0, "{f}", "{torque} of the lock on {joint} along {speed}; impacts count in time steps alone"},
      {"mode", 0, "1", "1: the lock of {joint} is engaged; 0: it is released"}};

  std::optional<ElementFault> fault(const Coordinate&) const {
    if (has_input() || engaged) return {};
    return {{"", "a lock that is never engaged", "engaged: true, or input: engagement"}};
  }

  // Above 0: engaged. u: its input, if it has one.
  template <class T>
  T engagement(const T* u) const {
    return has_input() ? T(u[0] - T(threshold)) : T(threshold);
  }

  // Modes: 1 engaged, where the equations of motion determine the force (dynamics/locked_coordinates.h); otherwise 0.
  template <class T>
  T held(int, const T&, const T&, const T*) const {
    return T(0);
  }
  template <class T>
  int side(const T&, const T&) const {
    return 0;
  }
  template <class T>
  T effort(const T&, const T&, const T*) const {
    return T(0);
  }
  // For each indicator, the texts of the events at which it is released and engaged; the second is always negative.
  static constexpr std::string_view events[2][2] = {{"{joint} is released", "{joint} is locked"},
                                                    {"{joint} is released", "{joint} is locked"}};

 private:
  static constexpr double threshold = 0.5;

  bool has_input() const { return input.index != Choice::none; }
};

}  // namespace gelenk

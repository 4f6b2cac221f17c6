// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "element/constraint.h"
#include "element/motion_law.h"

namespace gelenk {

// A coordinate of a joint, or its speed alone, is given: as a function of time or by an input. In the user's sense.
struct Motion {
  static constexpr std::string_view kind = "motion";
  static constexpr std::string_view summary = "a coordinate follows a given motion";
  static constexpr Port ports[] = {{.kind = Port::Kind::joint,
                                    .name = "joint",
                                    .text = "Joint whose speeds are the rates of its coordinates",
                                    .has_coordinate = true,
                                    .fits = [](const JointKind& kind) { return kind.springs(); }}};
  static constexpr std::string_view sources[] = {"position", "speed"};

  std::vector<double> polynomial;  // c0 + c1 t + c2 t^2 + ...
  std::optional<Sine> sine;        // added to it
  std::optional<Table> table;
  double speed = std::numeric_limits<double>::quiet_NaN();  // no more than the speed, which is constant
  Choice input;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Motion::polynomial>({.name = "polynomial",
                                    .unit = "{q}",
                                    .text = "coefficients of 1, t, t^2, ...",
                                    .by_time = true,
                                    .way = 1,
                                    .least = 1}),
        field<&Motion::sine>({.name = "sine",
                              .text = "amplitude sin(2 pi frequency t + phase), added to the polynomial "
                                      "if there is one",
                              .way = 1}),
        field<&Motion::table>({.name = "table", .text = "a cubic spline through these points", .way = 2}),
        field<&Motion::speed>({.name = "speed",
                               .unit = "{v}",
                               .text = "constant speed, from wherever the coordinate starts",
                               .optional = true,
                               .way = 3}),
        field<&Motion::input>(
            {.name = "input", .text = "what an input of the model gives", .way = 4, .words = sources})};
    return all;
  }

  bool follows_input() const { return input.index != Choice::none; }
  bool gives_speed() const { return std::isfinite(speed); }
  // Only the speed is given: where it starts is open.
  bool holds_position() const { return input.index != 1 && !gives_speed(); }

  std::optional<ElementFault> fault(const Coordinate&) const { return table ? fault(*table) : std::nullopt; }

  std::span<const SignalGroup> inputs() const {
    static constexpr SignalGroup position[] = {{"{coordinate}_ref", 0, "{q}", "what {joint}.{coordinate} is to be",
                                                Stage::position, SignalGroup::Start::coordinate}};
    static constexpr SignalGroup rate[] = {
        {"{speed}_ref", 0, "{v}", "what {joint}.{speed} is to be", Stage::velocity, SignalGroup::Start::speed}};
    if (!follows_input()) return {};
    return holds_position() ? position : rate;
  }
  static constexpr SignalGroup outputs[] = {
      {"{effort}", 0, "{f}", "{torque} that keeps {joint}.{coordinate} to its motion"}};

  template <class OnBase>
  double factor(int, const OnBase&) const {
    return 1;
  }
  std::optional<MotionLaw> law() const {
    if (follows_input()) return {};
    if (gives_speed()) return MotionLaw({0, speed}, {}, {});
    return MotionLaw(polynomial, sine, table);
  }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }

 private:
  static std::optional<ElementFault> fault(const Table& table);
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "element/constraints/constraint.h"
#include "element/constraints/motion_law.h"

namespace gelenk {

// A joint coordinate, or only its speed, is prescribed as a function of time or by an input, with the user's signs.
struct Motion {
  static constexpr std::string_view kind = "motion";
  static constexpr std::string_view summary = "a coordinate follows a prescribed motion";
  static constexpr Port ports[] = {{.kind = Port::Kind::joint,
                                    .name = "joint",
                                    .text = "Joint whose velocities are the time derivatives of its coordinates",
                                    .has_coordinate = true,
                                    .is_prescribed = true,
                                    .fits = [](const JointKind& kind) { return kind.springs(); }}};
  static constexpr std::string_view sources[] = {"position", "speed"};
  static constexpr std::string_view derivatives[] = {"speed", "acceleration"};
  static constexpr FormulaVariable time[] = {{"t", "s"}};

  std::vector<double> polynomial;  // c0 + c1 t + c2 t^2 + ...
  std::optional<Sine> sine;        // added to the polynomial
  std::optional<TimeTable> table;
  double speed = std::numeric_limits<double>::quiet_NaN();  // constant speed; NaN if not given
  Choice input, up_to;
  Formula law_of_time, speed_law;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Motion::polynomial>({.name = "polynomial",
                                    .unit = "{q}",
                                    .text = "coefficients of 1, t, t^2, ...",
                                    .by_time = true,
                                    .alternative = 1,
                                    .min_count = 1}),
        field<&Motion::sine>({.name = "sine",
                              .text = "amplitude sin(2 pi frequency t + phase), added to the polynomial "
                                      "if there is one",
                              .alternative = 1}),
        field<&Motion::table>({.name = "table", .text = "a curve through points", .alternative = 2}),
        field<&Motion::speed>({.name = "speed",
                               .unit = "{v}",
                               .text = "constant speed, with any start value of the coordinate",
                               .optional = true,
                               .alternative = 3}),
        field<&Motion::input>({.name = "input",
                               .text = "quantity that an input of the model prescribes",
                               .alternative = 4,
                               .words = sources}),
        field<&Motion::up_to>({.name = "up_to",
                               .text = "highest time derivative that is an input, too",
                               .goes_with = 4,
                               .words = derivatives}),
        field<&Motion::law_of_time>({.name = "law",
                                     .unit = "{q}",
                                     .text = "smooth expression of the time t, and of states",
                                     .settable = false,
                                     .alternative = 5,
                                     .variables = time,
                                     .reads = FormulaReads::signals}),
        field<&Motion::speed_law>({.name = "speed_law",
                                   .unit = "{v}",
                                   .text = "the same for the speed, with any start value of the coordinate",
                                   .settable = false,
                                   .alternative = 6,
                                   .variables = time,
                                   .reads = FormulaReads::signals})};
    return all;
  }

  bool follows_input() const { return input.index != Choice::none; }
  // How many inputs follow that of the prescribed quantity: its time derivatives.
  int derivative_inputs() const {
    return follows_input() && up_to.index > Choice::none ? first_derivative() + up_to.index : 0;
  }
  // The coordinate or the speed is an expression of signals, of which the rates of states are known (scene/motions.h).
  bool follows_signals() const { return gives_speed_by_law() || !law_of_time.signal_names().empty(); }
  const Formula& law_of_signals() const { return gives_speed_by_law() ? speed_law : law_of_time; }
  bool gives_speed_by_law() const { return speed_law.is_given(); }
  bool gives_speed() const { return std::isfinite(speed); }
  // Otherwise only the speed is prescribed, and the start value is free.
  bool holds_position() const { return input.index != 1 && !gives_speed() && !gives_speed_by_law(); }

  std::optional<ElementFault> fault(const Coordinate&) const;
  std::optional<ElementFault> doubt() const;

  std::span<const SignalGroup> inputs() const {
    static constexpr SignalGroup all[] = {
        {"{coordinate}_ref", 0, "{q}", "prescribed value of {joint}.{coordinate}", Stage::position,
         SignalGroup::Start::coordinate},
        {"{speed}_ref", 0, "{v}", "prescribed value of {joint}.{speed}", Stage::velocity, SignalGroup::Start::speed},
        {"{acceleration}_ref", 0, "{a}", "prescribed value of {joint}.{acceleration}", Stage::acceleration}};
    if (!follows_input()) return {};
    return std::span(all).subspan(holds_position() ? 0 : 1, static_cast<std::size_t>(1 + derivative_inputs()));
  }
  static constexpr SignalGroup outputs[] = {
      {"{effort}", 0, "{f}", "{torque} that enforces the motion of {joint}.{coordinate}"}};

  template <class OnBase>
  double factor(int, const OnBase&) const {
    return 1;
  }
  std::optional<MotionLaw> law() const {
    if (follows_input() || follows_signals()) return {};
    if (gives_speed()) return MotionLaw({0, speed}, {}, {});
    return MotionLaw(polynomial, sine, table, law_of_time);
  }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }

 private:
  int first_derivative() const { return holds_position() ? 1 : 0; }
  static std::optional<ElementFault> fault(const TimeTable& table);
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Motion law: a function of time and its derivatives.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "expression/tape.h"
#include "field/field.h"

namespace gelenk {

// amplitude sin(2 pi frequency t + phase)
struct Sine {
  double amplitude = 0;  // rad or m
  double frequency = 0;  // Hz
  double phase = 0;      // rad

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Sine::amplitude>({.name = "amplitude", .unit = "{q}", .text = "amplitude", .required = true}),
        field<&Sine::frequency>(
            {.name = "frequency", .unit = "Hz", .text = "frequency", .range = Range::not_negative, .required = true}),
        field<&Sine::phase>({.name = "phase", .unit = "rad", .text = "phase at t = 0"})};
    return all;
  }
};

// An interpolation; before its first and after its last point it continues with the speed at that point.
struct TimeTable {
  static constexpr std::string_view interpolations[] = {"pchip", "akima", "spline"};

  std::vector<double> time, value;  // s, rad or m; times in ascending order
  bool periodic = false;            // the first and the last value must be equal
  Choice interpolation;             // none: a spline, as before there was a choice

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&TimeTable::time>({.name = "time",
                                 .unit = "s",
                                 .text = "times, in ascending order",
                                 .required = true,
                                 .settable = false,
                                 .min_count = 2}),
        field<&TimeTable::value>({.name = "value",
                                  .unit = "{q}",
                                  .text = "values of the coordinate at these times",
                                  .required = true,
                                  .settable = false,
                                  .min_count = 2}),
        field<&TimeTable::periodic>({.name = "periodic", .text = "whether the table repeats"}),
        field<&TimeTable::interpolation>({.name = "interpolation",
                                          .text = "pchip: without overshoot, akima, or spline: "
                                                  "with continuous accelerations",
                                          .optional = true,
                                          .words = interpolations})};
    return all;
  }

  expression::Table::Data data() const;
};

// Sum of a polynomial sum c_i t^i, a sine, a table and a formula of t, as far as they are given. If only the speed is
// prescribed, the function is used only through its derivatives.
class MotionLaw {
 public:
  static constexpr int orders = 5;  // the value and its first four derivatives
  using Derivatives = std::array<double, orders>;

  // polynomial: coefficients c0, c1, ... [rad or m, divided by s^i]; may be empty.
  MotionLaw(std::vector<double> polynomial, std::optional<Sine> sine, const std::optional<TimeTable>& table,
            const Formula& formula = {});

  // Returns s, s', s'', ... at t [s].
  Derivatives at(double t) const;
  // Whether its tables have continuous derivatives, and are of a t + b.
  bool is_steady() const;
  // The next time after t [s] at which s'' jumps; infinite: none.
  double next_break(double t) const;
  bool has_breaks() const { return has_broken_table() || (formula_ && formula_->has_breaks()); }

 private:
  bool has_broken_table() const;
  void add_polynomial(double t, Derivatives& out) const;
  void add_sine(double t, Derivatives& out) const;
  void add_table(double t, Derivatives& out) const;
  void differentiate(const Formula& formula);
  void add_formula(double t, Derivatives& out) const;

  std::vector<double> polynomial_;
  std::optional<Sine> sine_;
  std::optional<expression::Table> table_;
  std::optional<expression::Tape> formula_;  // and its derivatives, in SI units
  double formula_size_ = 1, time_size_ = 1;  // SI values of one unit
};

}  // namespace gelenk

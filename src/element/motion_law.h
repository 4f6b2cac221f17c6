// SPDX-License-Identifier: BSD-3-Clause
// A function of time, with its derivatives.
#pragma once

#include <array>
#include <optional>
#include <vector>

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

// A cubic spline; before its first and after its last point it goes on with the speed there.
struct Table {
  std::vector<double> time, value;  // s, rad or m; times ascend
  bool periodic = false;            // the last and the first value are the same

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Table::time>(
            {.name = "time", .unit = "s", .text = "times, ascending", .required = true, .settable = false, .least = 2}),
        field<&Table::value>({.name = "value",
                              .unit = "{q}",
                              .text = "the coordinate at these times",
                              .required = true,
                              .settable = false,
                              .least = 2}),
        field<&Table::periodic>({.name = "periodic", .text = "whether it repeats"})};
    return all;
  }
};

// The parts there are, one on the other: sum c_i t^i, a sine, a table; of a law that gives no more than the speed,
// that.
class MotionLaw {
 public:
  static constexpr int orders = 5;  // the value and its first four derivatives
  using Derivatives = std::array<double, orders>;

  MotionLaw(std::vector<double> polynomial, std::optional<Sine> sine, std::optional<Table> table);

  // s, s', s'', ... at t [s].
  Derivatives at(double t) const;

 private:
  void make_spline();
  void add_polynomial(double t, Derivatives& out) const;
  void add_sine(double t, Derivatives& out) const;
  void add_spline(double t, Derivatives& out) const;

  std::vector<double> polynomial_;
  std::optional<Sine> sine_;
  std::optional<Table> table_;
  std::vector<double> curvature_;  // s'' at the table's times
};

}  // namespace gelenk

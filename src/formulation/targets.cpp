// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/targets.h"

#include <algorithm>
#include <limits>

namespace gelenk {
namespace {

// derivative(order): of the input, for orders 0 to 2; higher ones are unknown.
template <class Derivative>
MotionLaw::Derivatives of_row(const CoordinateRow& row, double t, Derivative derivative) {
  if (row.law) return row.law->at(t);
  MotionLaw::Derivatives out{};
  out[0] = row.constant;
  if (row.input < 0) return out;
  const int first = row.holds_position ? 0 : 1;
  for (int order = 0; order < 3; ++order) out[first + order] = derivative(order);
  return out;
}

}  // namespace

template <class Of>
const double* Targets::fill(Of derivatives_of) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const MotionLaw::Derivatives s = derivatives_of(static_cast<int>(i));
    std::copy_n(s.begin(), 3, now_.begin() + 3 * static_cast<std::ptrdiff_t>(i));
  }
  return now_.data();
}

bool Targets::has_breaks() const {
  return std::ranges::any_of(rows_, [](const CoordinateRow& row) { return row.law && row.law->has_breaks(); });
}

double Targets::next_break(double t) const {
  double out = INFINITY;
  for (const CoordinateRow& row : rows_) {
    if (row.law && row.law->has_breaks()) out = std::min(out, row.law->next_break(t));
  }
  return out;
}

// At an end of the present stretch, laws are those within it: moved there by rounding.
double Targets::inside_stretch(double t) const {
  constexpr double rounding = 2e-14;  // relative; twice that of times at which steps end
  const double near = rounding * std::abs(t);
  if (std::abs(t - stretch_[0]) < near) return stretch_[0] + near;
  if (std::abs(t - stretch_[1]) < near) return stretch_[1] - near;
  return t;
}

MotionLaw::Derivatives Targets::of_signals(int row, const double* u) const {
  MotionLaw::Derivatives out{};
  for (std::size_t order = 0; order < 3; ++order) out[order] = loads_.motion(static_cast<std::size_t>(row), order, u);
  return out;
}

const double* Targets::at(double t, const Inputs& inputs, const double* u) {
  const double inside = inside_stretch(t);
  return fill([&](int i) {
    if (rows_[i].follows_signals) return of_signals(i, u);
    return of_row(rows_[i], inside, [&](int order) { return inputs.derivative_at(rows_[i].input, order, t); });
  });
}

const double* Targets::as_read(double t, const Inputs& inputs, const double* u) {
  return fill([&](int i) { return derivatives(i, t, inputs, u); });
}

MotionLaw::Derivatives Targets::derivatives(int row, double t, const Inputs& inputs, const double* u) const {
  if (rows_[row].follows_signals) return of_signals(row, u);
  return of_row(rows_[row], t, [&](int order) {
    return order == 0 ? inputs.value(rows_[row].input) : inputs.rate(rows_[row].input, order);
  });
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/motion_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace gelenk {

expression::Table::Data TimeTable::data() const {
  using enum expression::Interpolation;
  constexpr expression::Interpolation kinds[] = {pchip, akima, spline};
  using expression::Extrapolation;
  const Extrapolation beyond = periodic ? Extrapolation::periodic : Extrapolation::linear;
  return {.name = {},
          .x = time,
          .y = {},
          .values = value,
          .interpolation = interpolation.index == Choice::none ? spline : kinds[interpolation.index],
          .extrapolation = {beyond, beyond}};
}

MotionLaw::MotionLaw(std::vector<double> polynomial, std::optional<Sine> sine, const std::optional<TimeTable>& table,
                     const Formula& formula)
    : polynomial_(std::move(polynomial)), sine_(sine) {
  if (table) table_.emplace(table->data());
  if (formula.is_given()) differentiate(formula);
}

void MotionLaw::differentiate(const Formula& formula) {
  expression::Graph graph = formula.graph();
  std::vector<expression::Term> terms = {formula.term()};
  for (int k = 1; k < orders; ++k) terms.push_back(derivative(graph, terms.back(), 0));
  formula_.emplace(graph, terms, 0);
  formula_size_ = formula.size();
  time_size_ = formula.size_of(0);
}

void MotionLaw::add_formula(double t, Derivatives& out) const {
  Derivatives in_si{};
  const double seconds = t * time_size_;
  formula_->evaluate(&seconds, in_si.data());
  double factor = 1 / formula_size_;
  for (int k = 0; k < orders; ++k, factor *= time_size_) out[k] += factor * in_si[k];
}

void MotionLaw::add_table(double t, Derivatives& out) const {
  const expression::TableAxis& axis = table_->axis(0);
  const double inside = t + axis.shift(t, std::nullopt);
  const int segment = axis.segment_from(inside);
  for (int k = 0; k <= expression::Table::max_derivative; ++k) out[k] += table_->at({inside, 0}, {segment, 0}, {k, 0});
}

bool MotionLaw::is_steady() const { return !formula_ || (formula_->choices() == 0 && formula_->is_steady()); }

bool MotionLaw::has_broken_table() const {
  return table_ && table_->data().interpolation != expression::Interpolation::spline;
}

double MotionLaw::next_break(double t) const {
  double out = INFINITY;
  if (has_broken_table()) out = table_->axis(0).next_knot(t, true);
  if (formula_) out = std::min(out, formula_->next_break(t * time_size_) / time_size_);
  return out;
}

void MotionLaw::add_polynomial(double t, Derivatives& out) const {
  for (int k = 0; k < orders; ++k) {
    double sum = 0;
    // k-th derivative by Horner's scheme.
    for (int i = static_cast<int>(polynomial_.size()) - 1; i >= k; --i) {
      double factor = 1;
      for (int j = 0; j < k; ++j) factor *= i - j;
      sum = sum * t + factor * polynomial_[i];
    }
    out[k] += sum;
  }
}

void MotionLaw::add_sine(double t, Derivatives& out) const {
  const double omega = 2 * std::numbers::pi * sine_->frequency;
  const double sine = std::sin(omega * t + sine_->phase);
  const double cosine = std::cos(omega * t + sine_->phase);
  const double derivatives[] = {sine, cosine, -sine, -cosine, sine};
  double amplitude = sine_->amplitude;
  for (int k = 0; k < orders; ++k, amplitude *= omega) out[k] += amplitude * derivatives[k];
}

MotionLaw::Derivatives MotionLaw::at(double t) const {
  Derivatives out{};
  add_polynomial(t, out);
  if (sine_) add_sine(t, out);
  if (table_) add_table(t, out);
  if (formula_) add_formula(t, out);
  return out;
}

}  // namespace gelenk

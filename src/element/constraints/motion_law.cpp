// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/motion_law.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace gelenk {

MotionLaw::MotionLaw(std::vector<double> polynomial, std::optional<Sine> sine, std::optional<Table> table,
                     const Formula& formula)
    : polynomial_(std::move(polynomial)), sine_(sine), table_(std::move(table)) {
  if (table_) make_spline();
  if (formula.is_given()) differentiate(formula);
}

void MotionLaw::differentiate(const Formula& formula) {
  expression::Graph graph = formula.graph();
  std::vector<expression::Term> terms = {formula.term()};
  for (int k = 1; k < orders; ++k) terms.push_back(derivative(graph, terms.back(), 0));
  formula_.emplace(graph, terms);
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

// s'' is continuous and linear between the points; at each inner point (de Boor 1978, ch. IV)
//   h0 s0''/6 + (h0 + h1) s1''/3 + h1 s2''/6 = (s2 - s1)/h1 - (s1 - s0)/h0.
// At the ends s'' is 0; if the table is periodic, it is the same at both ends, and the first point is an inner one.
void MotionLaw::make_spline() {
  const std::vector<double>& t = table_->time;
  const std::vector<double>& s = table_->value;
  const int last = static_cast<int>(t.size()) - 1;
  curvature_.assign(t.size(), 0);
  const bool cyclic = table_->periodic && last > 1;
  const int first = cyclic ? 0 : 1;
  const int unknowns = last - first;
  if (unknowns == 0) return;
  std::vector<Eigen::Triplet<double>> entries;  // of the lower triangle of the symmetric matrix
  Eigen::VectorXd right(unknowns);
  for (int row = 0; row < unknowns; ++row) {
    const int i = first + row;
    const int before = i > 0 ? i - 1 : last - 1;
    const double h0 = i > 0 ? t[i] - t[before] : t[last] - t[before];
    const double h1 = t[i + 1] - t[i];
    entries.emplace_back(row, row, (h0 + h1) / 3);
    if (row > 0) entries.emplace_back(row, row - 1, h0 / 6);
    if (cyclic && i == 0) entries.emplace_back(unknowns - 1, 0, h0 / 6);
    right[row] = (s[i + 1] - s[i]) / h1 - (s[i] - s[before]) / h0;
  }
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  const Eigen::VectorXd curvature = factor.solve(right);
  std::ranges::copy(curvature, curvature_.begin() + first);
  if (cyclic) curvature_[last] = curvature_[0];
}

void MotionLaw::add_spline(double t, Derivatives& out) const {
  const std::vector<double>& times = table_->time;
  const std::vector<double>& s = table_->value;
  const double period = times.back() - times.front();
  if (table_->periodic) t -= period * std::floor((t - times.front()) / period);
  const double inside = std::clamp(t, times.front(), times.back());
  const auto above = std::upper_bound(times.begin() + 1, times.end() - 1, inside);
  const auto i = static_cast<std::size_t>(above - times.begin()) - 1;
  const double h = times[i + 1] - times[i];
  const double x = inside - times[i];
  const double jerk = (curvature_[i + 1] - curvature_[i]) / h;
  const double start_speed = (s[i + 1] - s[i]) / h - h * (2 * curvature_[i] + curvature_[i + 1]) / 6;
  const double speed = start_speed + x * (curvature_[i] + x * jerk / 2);
  out[0] += s[i] + x * (start_speed + x * (curvature_[i] / 2 + x * jerk / 6)) + (t - inside) * speed;
  out[1] += speed;
  if (t != inside) return;
  out[2] += curvature_[i] + x * jerk;
  out[3] += jerk;
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
  if (table_) add_spline(t, out);
  if (formula_) add_formula(t, out);
  return out;
}

}  // namespace gelenk

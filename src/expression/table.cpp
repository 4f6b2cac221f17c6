// SPDX-License-Identifier: BSD-3-Clause
#include "expression/table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "util/text.h"

namespace gelenk::expression {
namespace {

using Numbers = std::vector<double>;

// Differences between neighbors, and the derivatives of the straight lines between points.
struct Lines {
  Numbers h, d;
  Lines(const Numbers& x, const Numbers& f) {
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      h.push_back(x[i + 1] - x[i]);
      d.push_back((f[i + 1] - f[i]) / h.back());
    }
  }
  // Of the i-th interval, counted through the periods.
  std::size_t wrapped(std::ptrdiff_t i) const {
    const auto n = static_cast<std::ptrdiff_t>(h.size());
    return static_cast<std::size_t>(((i % n) + n) % n);
  }
};

double monotone_derivative(double h0, double h1, double d0, double d1) {
  if (!(d0 * d1 > 0)) return 0;
  const double w0 = 2 * h1 + h0;
  const double w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

// At an end, by three points (Moler 2004, section 3.6).
double monotone_end(double h0, double h1, double d0, double d1) {
  const double derivative = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
  if (!(derivative * d0 > 0)) return 0;
  return d0 * d1 < 0 && std::abs(derivative) > 3 * std::abs(d0) ? 3 * d0 : derivative;
}

Numbers monotone(const Lines& lines, bool periodic) {
  const auto& [h, d] = lines;
  const std::size_t last = h.size();
  Numbers out(last + 1);
  for (std::size_t i = 1; i < last; ++i) out[i] = monotone_derivative(h[i - 1], h[i], d[i - 1], d[i]);
  if (periodic) {
    out[0] = out[last] = monotone_derivative(h[last - 1], h[0], d[last - 1], d[0]);
  } else {
    out[0] = monotone_end(h[0], h[1], d[0], d[1]);
    out[last] = monotone_end(h[last - 1], h[last - 2], d[last - 1], d[last - 2]);
  }
  return out;
}

Numbers by_akima(const Lines& lines, bool periodic) {
  const Numbers& d = lines.d;
  const auto last = static_cast<std::ptrdiff_t>(d.size());
  // The derivative of an interval; beyond the ends of what is not periodic they continue as a parabola does.
  const auto line = [&](std::ptrdiff_t i) {
    if (periodic) return d[lines.wrapped(i)];
    const std::ptrdiff_t beyond = i < 0 ? -i : i >= last ? i - last + 1 : 0;
    const std::size_t end = i < 0 ? 0 : d.size() - 1;
    const std::size_t inner = i < 0 ? 1 : d.size() - 2;
    if (beyond > 0) return d[end] + static_cast<double>(beyond) * (d[end] - d[inner]);
    return d[static_cast<std::size_t>(i)];
  };
  constexpr double rounding = 1e-9;  // of differences of derivatives, relative to the largest one
  double largest = 0;
  for (std::ptrdiff_t i = -1; i <= last; ++i) largest = std::max(largest, std::abs(line(i) - line(i - 1)));
  Numbers out;
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    const double after = std::abs(line(i + 1) - line(i));
    const double before = std::abs(line(i - 1) - line(i - 2));
    const double sum = after + before;
    const bool undecided = sum <= rounding * largest;
    out.push_back(undecided ? (line(i - 1) + line(i)) / 2 : (after * line(i - 1) + before * line(i)) / sum);
  }
  return out;
}

// Equations a_i x_(i-1) + b_i x_i + c_i x_(i+1) = r_i whose diagonals are larger than the rest of their rows.
struct Tridiagonal {
  Numbers a, b, c;

  Numbers solved(Numbers r) const {
    Numbers pivots = b;
    for (std::size_t i = 1; i < r.size(); ++i) {
      const double factor = a[i] / pivots[i - 1];
      pivots[i] -= factor * c[i - 1];
      r[i] -= factor * r[i - 1];
    }
    for (std::size_t i = r.size(); i-- > 0;) r[i] = (r[i] - (i + 1 < r.size() ? c[i] * r[i + 1] : 0)) / pivots[i];
    return r;
  }
};

// f'' is continuous at each inner point (de Boor 1978, ch. IV):
//   h1 f'0 + 2 (h0 + h1) f'1 + h0 f'2 = 3 (h1 d0 + h0 d1).
Numbers by_spline(const Lines& lines, bool periodic) {
  const auto& [h, d] = lines;
  const std::size_t last = h.size();
  Tridiagonal equations;
  Numbers right;
  const auto add = [&](std::size_t before, std::size_t after) {
    equations.a.push_back(h[after]);
    equations.b.push_back(2 * (h[before] + h[after]));
    equations.c.push_back(h[before]);
    right.push_back(3 * (h[after] * d[before] + h[before] * d[after]));
  };
  if (!periodic) {
    equations = {{0}, {2}, {1}};  // f'' = 0 at the first point
    right = {3 * d[0]};
    for (std::size_t i = 1; i < last; ++i) add(i - 1, i);
    equations.a.push_back(1);
    equations.b.push_back(2);
    equations.c.push_back(0);
    right.push_back(3 * d[last - 1]);
    return equations.solved(right);
  }
  // The inner derivatives as functions p + q s of the derivative s at both ends, for which the equation there remains.
  for (std::size_t i = 1; i < last; ++i) add(i - 1, i);
  Numbers by_end(right.size(), 0);
  by_end.front() -= equations.a.front();
  by_end.back() -= equations.c.back();
  const Numbers p = equations.solved(right);
  const Numbers q = equations.solved(by_end);
  const double h0 = h[last - 1];
  const double h1 = h[0];
  const double rest = 3 * (h1 * d[last - 1] + h0 * d[0]) - h1 * p.back() - h0 * p.front();
  const double s = rest / (2 * (h0 + h1) + h1 * q.back() + h0 * q.front());
  Numbers out = {s};
  for (std::size_t i = 0; i < p.size(); ++i) out.push_back(p[i] + q[i] * s);
  out.push_back(s);
  return out;
}

// Factors of the cubic with given values and derivatives at u = 0 and u = 1, and of its derivatives by u.
std::array<double, 4> hermite(double u, int derivative) {
  switch (derivative) {
    case 0:
      return {(1 + 2 * u) * (1 - u) * (1 - u), u * (1 - u) * (1 - u), u * u * (3 - 2 * u), u * u * (u - 1)};
    case 1:
      return {6 * u * (u - 1), (1 - u) * (1 - 3 * u), 6 * u * (1 - u), u * (3 * u - 2)};
    case 2:
      return {12 * u - 6, 6 * u - 4, 6 - 12 * u, 6 * u - 2};
    case 3:
      return {12, 6, -12, 6};
    default:
      return {};
  }
}

}  // namespace

Numbers derivatives_of(const Numbers& points, const Numbers& values, Interpolation by, bool periodic) {
  const Lines lines(points, values);
  if (points.size() == 2) return {lines.d[0], lines.d[0]};
  switch (by) {
    case Interpolation::linear:
      return Numbers(points.size(), 0);  // not used
    case Interpolation::pchip:
      return monotone(lines, periodic);
    case Interpolation::akima:
      return by_akima(lines, periodic);
    default:
      return by_spline(lines, periodic);
  }
}

TableAxis::TableAxis(Numbers points, Interpolation interpolation, Extrapolation extrapolation)
    : points_(std::move(points)), knots_(points_), interpolation_(interpolation), extrapolation_(extrapolation) {
  if (!is_periodic()) return;
  knots_.insert(knots_.begin(), points_[points_.size() - 2] - period());
  knots_.push_back(points_[1] + period());
}

int TableAxis::segment_of(double x) const {
  return static_cast<int>(std::ranges::lower_bound(knots_, x) - knots_.begin());
}

int TableAxis::segment_from(double x) const {
  return static_cast<int>(std::ranges::upper_bound(knots_, x) - knots_.begin());
}

int TableAxis::segment_held(const bool* beyond) const {
  return static_cast<int>(std::partition_point(beyond, beyond + knots_.size(), std::identity()) - beyond);
}

double TableAxis::shift(double x, std::optional<int> segment) const {
  if (!is_periodic()) return 0;
  if (!segment) return -period() * std::floor((x - points_.front()) / period());
  const auto k = static_cast<std::size_t>(std::clamp(*segment, 1, static_cast<int>(knots_.size()) - 1));
  return -period() * std::round((x - (knots_[k - 1] + knots_[k]) / 2) / period());
}

double TableAxis::next_knot(double x, bool above) const {
  const double moved = shift(x, std::nullopt);
  constexpr double none = std::numeric_limits<double>::infinity();
  if (above) {
    const auto next = std::ranges::upper_bound(knots_, x + moved);
    return next == knots_.end() ? none : *next - moved;
  }
  const auto next = std::ranges::lower_bound(knots_, x + moved);
  return next == knots_.begin() ? -none : *(next - 1) - moved;
}

TableAxis::Place TableAxis::place_of(double x, int segment) const {
  const int intervals = static_cast<int>(points_.size()) - 1;
  int interval = segment - 1;  // between points
  if (is_periodic()) {
    const int periods = interval < 1 ? -1 : interval > intervals ? 1 : 0;
    interval += -1 - periods * intervals;
    x -= periods * period();
  }
  Place out{.first = static_cast<std::size_t>(std::clamp(interval, 0, intervals - 1)), .x = x};
  if (interval < 0) out.end = Place::End::first;
  if (interval >= intervals) out.end = Place::End::last;
  return out;
}

// Beyond an end, unless the polynomial there continues.
std::optional<std::array<double, 4>> TableAxis::beyond(const Place& at, int derivative) const {
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  const bool is_first = at.end == Place::End::first;
  const double from_end = at.x - (is_first ? points_.front() : points_.back());
  const std::size_t value = is_first ? 0 : 2;
  std::array<double, 4> out{};
  switch (extrapolation_) {
    case Extrapolation::refuse:
      if (is_first ? from_end < 0 : from_end > 0) return std::array{missing, missing, missing, missing};
      return {};
    case Extrapolation::hold:
      if (derivative == 0) out[value] = 1;
      return out;
    case Extrapolation::linear:
      if (interpolation_ == Interpolation::linear) return {};
      if (derivative == 0) out[value] = 1;
      if (derivative < 2) out[value + 1] = derivative == 0 ? from_end : 1;
      return out;
    default:
      return {};
  }
}

TableAxis::Weights TableAxis::weights(double x, int segment, int derivative) const {
  if (std::isnan(x)) return {.of = {x, x, x, x}};
  const Place at = place_of(x, segment);
  Weights out{.first = at.first};
  if (at.end != Place::End::none) {
    if (const auto found = beyond(at, derivative)) {
      out.of = *found;
      return out;
    }
  }
  const double h = points_[at.first + 1] - points_[at.first];
  const double u = (at.x - points_[at.first]) / h;
  if (interpolation_ == Interpolation::linear) {
    if (derivative == 0) out.of = {1 - u, 0, u, 0};
    if (derivative == 1) out.of = {-1 / h, 0, 1 / h, 0};
    return out;
  }
  out.of = hermite(u, derivative);
  for (int k = 0; k < derivative; ++k) {
    for (double& factor : out.of) factor /= h;
  }
  out.of[1] *= h;
  out.of[3] *= h;
  return out;
}

Table::Table(Data data) : data_(std::move(data)) { differentiate(); }

void Table::differentiate() {
  const Data& data = data_;
  const Numbers& f = data.values;
  axes_.emplace_back(data.x, data.interpolation, data.extrapolation[0]);
  if (data.arguments() == 1) {
    fx_ = derivatives_of(data.x, f, data.interpolation, data.is_periodic(0));
    return;
  }
  axes_.emplace_back(data.y, data.interpolation, data.extrapolation[1]);
  const std::size_t rows = data.x.size();
  const std::size_t columns = data.y.size();
  const auto along_x = [&](const Numbers& of, Numbers& out) {
    out.resize(of.size());
    Numbers line(rows);
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < rows; ++i) line[i] = of[i * columns + j];
      const Numbers found = derivatives_of(data.x, line, data.interpolation, data.is_periodic(0));
      for (std::size_t i = 0; i < rows; ++i) out[i * columns + j] = found[i];
    }
  };
  for (std::size_t i = 0; i < rows; ++i) {
    const auto first = f.begin() + static_cast<std::ptrdiff_t>(i * columns);
    const Numbers line(first, first + static_cast<std::ptrdiff_t>(columns));
    const Numbers found = derivatives_of(data.y, line, data.interpolation, data.is_periodic(1));
    fy_.insert(fy_.end(), found.begin(), found.end());
  }
  along_x(f, fx_);
  along_x(fy_, fxy_);
}

bool Table::refuses(std::size_t argument, double x) const {
  const Numbers& points = axes_[argument].points();
  return data_.extrapolation[argument] == Extrapolation::refuse && (x < points.front() || x > points.back());
}

double Table::at(const std::array<double, 2>& place, const Segments& segments, const Orders& derivatives) const {
  const Numbers& values = data_.values;
  const TableAxis::Weights a = axes_[0].weights(place[0], segments[0], derivatives[0]);
  // Times f and f' of both points.
  const auto along = [](const std::array<double, 4>& of, double f0, double d0, double f1, double d1) {
    return of[0] * f0 + of[1] * d0 + of[2] * f1 + of[3] * d1;
  };
  if (axes_.size() == 1) return along(a.of, values[a.first], fx_[a.first], values[a.first + 1], fx_[a.first + 1]);
  const TableAxis::Weights b = axes_[1].weights(place[1], segments[1], derivatives[1]);
  const std::size_t columns = axes_[1].points().size();
  const auto in_row = [&](std::size_t row, const Numbers& f, const Numbers& df) {
    const std::size_t k = row * columns + b.first;
    return along(b.of, f[k], df[k], f[k + 1], df[k + 1]);
  };
  return along(a.of, in_row(a.first, values, fy_), in_row(a.first, fx_, fxy_), in_row(a.first + 1, values, fy_),
               in_row(a.first + 1, fx_, fxy_));
}

namespace {

// Beyond the values at both ends of an interval of length h with derivatives d0 and d1.
double excess(double h, double f0, double f1, double d0, double d1) {
  // f'(u) = d0 + b u + c u^2 with u from 0 to 1, times h
  const double rise = f1 - f0;
  const double c = 3 * h * (d0 + d1) - 6 * rise;
  const double b = 6 * rise - 2 * h * (2 * d0 + d1);
  const double radicand = b * b - 4 * c * h * d0;
  if (!(radicand >= 0)) return 0;
  double out = 0;
  const double q = -(b + std::copysign(std::sqrt(radicand), b)) / 2;
  for (const double u : {q / c, h * d0 / q}) {
    if (!(u > 0 && u < 1)) continue;
    const std::array<double, 4> w = hermite(u, 0);
    const double f = w[0] * f0 + w[1] * h * d0 + w[2] * f1 + w[3] * h * d1;
    out = std::max({out, f - std::max(f0, f1), std::min(f0, f1) - f});
  }
  return out;
}

}  // namespace

// Along each line of points.
double Table::overshoot() const {
  const std::vector<double>& f = data_.values;
  const auto [least, largest] = std::ranges::minmax(f);
  if (data_.interpolation == Interpolation::linear || !(largest > least)) return 0;
  const std::size_t columns = std::max<std::size_t>(1, data_.y.size());
  double out = 0;
  for (std::size_t k = 0; k < f.size(); ++k) {
    const std::size_t i = k / columns;
    const std::size_t j = k % columns;
    if (const std::size_t next = k + columns; next < f.size())
      out = std::max(out, excess(data_.x[i + 1] - data_.x[i], f[k], f[next], fx_[k], fx_[next]));
    if (j + 1 < columns) out = std::max(out, excess(data_.y[j + 1] - data_.y[j], f[k], f[k + 1], fy_[k], fy_[k + 1]));
  }
  return out / (largest - least);
}

std::string Table::doubt() const {
  constexpr double permitted = 0.1;
  const double found = overshoot();
  if (!(found > permitted)) return {};
  return std::string("interpolation ") + interpolations[static_cast<std::size_t>(data_.interpolation)] +
         ", which leaves the range of the points around it by up to " + std::to_string(std::lround(100 * found)) +
         " % of the range of all values";
}

}  // namespace gelenk::expression

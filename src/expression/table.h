// SPDX-License-Identifier: BSD-3-Clause
// Tables of values over one or two arguments. Between its points a table is a polynomial of at most third degree in
// each argument; at the points derivatives jump.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace gelenk::expression {

// pchip: monotone where the values are (Fritsch and Butland 1984); akima: Akima 1970; spline: with continuous second
// derivatives, which are 0 at the ends or, if periodic, the same at both.
enum class Interpolation : unsigned char { linear, pchip, akima, spline };
// Beyond the points: the last value, a straight line, nothing (NaN), or the same again.
enum class Extrapolation : unsigned char { hold, linear, refuse, periodic };

// The derivatives at points of a function through values there. points: ascending, at least two.
std::vector<double> derivatives_of(const std::vector<double>& points, const std::vector<double>& values,
                                   Interpolation by, bool periodic);

// An argument of a table. Its knots divide it into segments: the k-th one lies between the knots k - 1 and k, the first
// and the last one are unbounded. The knots are the points; if the table is periodic, also one on either side.
class TableAxis {
 public:
  TableAxis(std::vector<double> points, Interpolation interpolation, Extrapolation extrapolation);

  const std::vector<double>& points() const { return points_; }
  const std::vector<double>& knots() const { return knots_; }
  // In which segment x is; at a knot: the one below, or the one after it.
  int segment_of(double x) const;
  int segment_from(double x) const;
  // The segment of which the first branches are held: of each knot, whether the argument is beyond it.
  int segment_held(const bool* beyond) const;
  // How far x is beyond the first knot at 0. If the table is periodic, x is moved by periods to the segment, or to the
  // first period.
  double shift(double x, std::optional<int> segment) const;
  // The next knot above x, or below; infinite: none.
  double next_knot(double x, bool above) const;

  // Factors of f and f' at the points `first` and first + 1, whose sum is f(x) or a derivative, with the polynomial of
  // a segment.
  struct Weights {
    std::size_t first = 0;
    std::array<double, 4> of{};  // of f and f' at the first, then at the second point
  };
  Weights weights(double x, int segment, int derivative) const;

 private:
  // Between the points `first` and first + 1, or beyond the end that is next to them.
  struct Place {
    enum class End : char { none, first, last };
    std::size_t first = 0;
    double x = 0;  // moved by periods
    End end = End::none;
  };
  Place place_of(double x, int segment) const;
  std::optional<std::array<double, 4>> beyond(const Place& at, int derivative) const;
  bool is_periodic() const { return extrapolation_ == Extrapolation::periodic; }
  double period() const { return points_.back() - points_.front(); }

  std::vector<double> points_, knots_;
  Interpolation interpolation_;
  Extrapolation extrapolation_;
};

class Table {
 public:
  struct Data {
    std::string name;
    std::vector<double> x, y;    // ascending, at least two; y empty: a table over x alone
    std::vector<double> values;  // of the first x for all y, and so on
    Interpolation interpolation = Interpolation::pchip;
    std::array<Extrapolation, 2> extrapolation{};  // by argument

    std::size_t arguments() const { return y.empty() ? 1 : 2; }
    bool is_periodic(std::size_t argument) const { return extrapolation[argument] == Extrapolation::periodic; }
  };
  static constexpr int max_derivative = 3;  // higher ones are 0
  using Orders = std::array<int, 2>;
  using Segments = std::array<int, 2>;

  explicit Table(Data data);

  const Data& data() const { return data_; }
  std::size_t arguments() const { return axes_.size(); }
  const TableAxis& axis(std::size_t k) const { return axes_[k]; }
  // Whether x is beyond the ends of an argument, where there are no values.
  bool refuses(std::size_t argument, double x) const;
  // What is said of a curve that leaves the range of the two values around it by more than 10 % of the range of all
  // values, with two arguments along a line of points; otherwise empty.
  std::string doubt() const;
  // A derivative at a place, with the polynomials of these segments.
  double at(const std::array<double, 2>& place, const Segments& segments, const Orders& derivatives) const;

 private:
  void differentiate();
  double overshoot() const;

  Data data_;
  std::vector<TableAxis> axes_;
  std::vector<double> fx_, fy_, fxy_;  // derivatives by point, as the values; with one argument fx_ alone
};

// Names of interpolations and extrapolations, in their order.
inline constexpr const char* interpolations[] = {"linear", "pchip", "akima", "spline"};
inline constexpr const char* extrapolations[] = {"hold", "linear", "refuse", "periodic"};

}  // namespace gelenk::expression

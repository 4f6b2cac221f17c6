// SPDX-License-Identifier: BSD-3-Clause
// Values of tables for double, dual numbers and power series.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "expression/table.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk::expression {

// By argument of a table, the first of the choices that are its knots; -1: it has none.
using FirstChoices = std::array<int, 2>;
inline constexpr FirstChoices no_choices{-1, -1};

// See Tape::evaluate.
template <class T>
struct LookupBranches {
  FirstChoices first = no_choices;
  const bool* held = nullptr;
  const bool* periods = nullptr;
  T* arguments = nullptr;
};

// The derivative of a table of which `derivatives` have been taken, in the directions or the powers of its arguments.
// of(orders): further derivatives.
template <class Of>
double composed(const Of& of, std::size_t, const double*) {
  return of({0, 0});
}
template <class Of>
Dual composed(const Of& of, std::size_t count, const Dual* x) {
  Dual::Directions along = of({1, 0}) * x[0].derivatives();
  if (count > 1) along += of({0, 1}) * x[1].derivatives();
  return {of({0, 0}), along};
}
template <class Of>
Series composed(const Of& of, std::size_t count, const Series* x) {
  const double fx = of({1, 0});
  Series::Coefficients out{of({0, 0}), fx * x[0][1], fx * x[0][2] + of({2, 0}) / 2 * x[0][1] * x[0][1]};
  if (count > 1) {
    const double fy = of({0, 1});
    out[1] += fy * x[1][1];
    out[2] += fy * x[1][2] + of({0, 2}) / 2 * x[1][1] * x[1][1] + of({1, 1}) * x[0][1] * x[1][1];
  }
  return Series(out);
}

template <class T>
T looked_up(const Table& table, const Table::Orders& derivatives, const T* arguments,
            const LookupBranches<T>& branches = {}) {
  std::array<double, 2> place{};
  Table::Segments segments{};
  for (std::size_t k = 0; k < table.arguments(); ++k) {
    const TableAxis& axis = table.axis(k);
    const double x = value_of(arguments[k]);
    const int first = branches.first[k];
    const auto held = [&](const bool* of) {
      return first < 0 || of == nullptr ? std::optional<int>() : axis.segment_held(of + first);
    };
    const std::optional<int> period = held(branches.periods);
    const std::optional<int> segment = held(branches.held);
    const double shift = axis.shift(x, period);
    place[k] = x + shift;
    segments[k] = segment ? *segment : first < 0 ? axis.segment_from(place[k]) : axis.segment_of(place[k]);
    if (first < 0 || branches.arguments == nullptr) continue;
    for (std::size_t i = 0; i < axis.knots().size(); ++i)
      branches.arguments[static_cast<std::size_t>(first) + i] = arguments[k] + T(shift - axis.knots()[i]);
  }
  const auto of = [&](const Table::Orders& further) {
    const Table::Orders all{derivatives[0] + further[0], derivatives[1] + further[1]};
    return all[0] > Table::max_derivative || all[1] > Table::max_derivative ? 0 : table.at(place, segments, all);
  };
  return composed(of, table.arguments(), arguments);
}

}  // namespace gelenk::expression

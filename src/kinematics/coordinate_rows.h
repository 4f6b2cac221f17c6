// SPDX-License-Identifier: BSD-3-Clause
// Coordinate constraints, sum factor q = s in coordinates of tree joints, and their rates; and relations between them.
// The caller passes s and its first two time derivatives, three numbers per equation ("targets").
#pragma once

#include <vector>

#include "kinematics/kernels.h"

namespace gelenk::kernels {

// The coordinates in a relation and their rates, in the user's signs. v: null for rates of 0.
template <class T>
struct RelationState {
  T x[RelationLaw::most_terms], rates[RelationLaw::most_terms];

  RelationState(const CoordinateRow& row, const T* q, const T* v) {
    for (std::size_t i = 0; i < row.terms.size(); ++i) {
      const CoordinateRow::Term& term = row.terms[i];
      x[i] = T(term.factor) * q[term.q];
      rates[i] = v == nullptr ? T(0) : T(term.factor) * v[term.v];
    }
  }
};

// The value of a relation, and its factors of the rates by term. A relation of rates has the value of no rates.
template <class T>
T relation_value(const CoordinateRow& row, const T* q, T* factors) {
  const RelationState<T> at(row, q, nullptr);
  const T value = row.relation->value(at.x, at.rates, factors);
  for (std::size_t k = 0; k < row.terms.size(); ++k) factors[k] *= T(row.terms[k].factor);
  return value;
}

// Calls visit(row, i, first) for each equation, with its number and that of its first term.
template <class A, class Visit>
void each_coordinate_row(const Model<A>& model, Visit visit) {
  std::size_t first = 0;
  for (std::size_t i = 0; i < model.coordinate_rows.size(); ++i) {
    visit(model.coordinate_rows[i], i, first);
    first += model.coordinate_rows[i].terms.size();
  }
}

// The factor of the rate of a term, at the position of ws. k: number of the term.
template <class A>
typename A::Scalar factor_of(const CoordinateRow& row, const CoordinateRow::Term& term, std::size_t k,
                             const Workspace<A>& ws) {
  return row.relation ? ws.factors[k] : typename A::Scalar(term.factor);
}

// Position errors Phi. After loop_positions. targets: s, s', s'' of each equation.
template <class A>
void coordinate_row_positions(const Model<A>& model, const typename A::Scalar* q,
                              const std::vector<typename A::Scalar>& targets, Workspace<A>& ws) {
  using T = typename A::Scalar;
  each_coordinate_row(model, [&](const CoordinateRow& row, std::size_t i, std::size_t first) {
    T& Phi = ws.Phi[model.first_coordinate_row + i];
    Phi = T(0);
    if (row.relation) {
      const T value = relation_value(row, q, ws.factors.data() + first);
      if (row.holds_position) Phi = value;
      return;
    }
    if (!row.holds_position) return;
    for (const CoordinateRow::Term& term : row.terms) Phi += T(term.factor) * q[term.q];
    Phi -= targets[3 * i];
  });
}

// Rows of J. After loop_jacobian and coordinate_row_positions.
template <class A>
void coordinate_row_jacobian(const Model<A>& model, Workspace<A>& ws) {
  each_coordinate_row(model, [&](const CoordinateRow& row, std::size_t i, std::size_t k) {
    double* value = ws.J.values(model.first_coordinate_row + static_cast<int>(i));
    for (const CoordinateRow::Term& term : row.terms) *value++ = factor_of(row, term, k++, ws);
  });
}

// Rates J v - b and gamma. After loop_velocities.
template <class A>
void coordinate_row_velocities(const Model<A>& model, const typename A::Scalar* q, const typename A::Scalar* v,
                               const std::vector<typename A::Scalar>& targets, Workspace<A>& ws) {
  using T = typename A::Scalar;
  each_coordinate_row(model, [&](const CoordinateRow& row, std::size_t i, std::size_t k) {
    T& rate = ws.rate[model.first_coordinate_row + i];
    T& gamma = ws.gamma[model.first_coordinate_row + i];
    rate = -targets[3 * i + 1];
    gamma = targets[3 * i + 2];
    if (row.relation) {
      const RelationState<T> at(row, q, v);
      gamma = -row.relation->bias(at.x, at.rates);
      T factors[RelationLaw::most_terms];
      if (!row.holds_position) rate = row.relation->value(at.x, at.rates, factors);
      if (!row.holds_position) return;
      rate = T(0);
    }
    for (const CoordinateRow::Term& term : row.terms) rate += factor_of(row, term, k++, ws) * v[term.v];
  });
}

// Acceleration residuals J vdot - gamma. After loop_accelerations and coordinate_row_velocities.
template <class A>
void coordinate_row_accelerations(const Model<A>& model, const typename A::Scalar* vdot,
                                  const std::vector<typename A::Scalar>& targets, const Workspace<A>& ws,
                                  typename A::Scalar* rows) {
  each_coordinate_row(model, [&](const CoordinateRow& row, std::size_t i, std::size_t k) {
    typename A::Scalar& residual = rows[model.first_coordinate_row + i];
    residual = row.relation ? -ws.gamma[model.first_coordinate_row + i] : -targets[3 * i + 2];
    for (const CoordinateRow::Term& term : row.terms) residual += factor_of(row, term, k++, ws) * vdot[term.v];
  });
}

// Whether a constraint equation, of a loop or of coordinates, is an angle; after loop_positions().
template <class A>
bool row_is_angle(const Model<A>& model, int row, const Workspace<A>& ws) {
  if (row >= model.first_coordinate_row) return model.coordinate_rows[row - model.first_coordinate_row].is_angle;
  const auto& w = ws.row[row].w;
  if constexpr (A::planar) {
    return w.x == 0 && w.y == 0;
  } else {
    return w.f.isZero(0);
  }
}

}  // namespace gelenk::kernels

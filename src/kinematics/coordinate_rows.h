// SPDX-License-Identifier: BSD-3-Clause
// Coordinate constraints, sum factor q = s in coordinates of tree joints, and their rates. The caller passes s and its
// first two time derivatives, three numbers per equation ("targets").
#pragma once

#include <vector>

#include "kinematics/kernels.h"

namespace gelenk::kernels {

// Position errors Phi. After loop_positions. targets: s, s', s'' of each equation.
template <class A>
void coordinate_row_positions(const Model<A>& model, const typename A::Scalar* q,
                              const std::vector<typename A::Scalar>& targets, Workspace<A>& ws) {
  using T = typename A::Scalar;
  for (std::size_t i = 0; i < model.coordinate_rows.size(); ++i) {
    const CoordinateRow& row = model.coordinate_rows[i];
    T& Phi = ws.Phi[model.first_coordinate_row + i];
    Phi = T(0);
    if (!row.holds_position) continue;
    for (const CoordinateRow::Term& term : row.terms) Phi += T(term.factor) * q[term.q];
    Phi -= targets[3 * i];
  }
}

// Rows of J. After loop_jacobian.
template <class A>
void coordinate_row_jacobian(const Model<A>& model, Workspace<A>& ws) {
  for (std::size_t i = 0; i < model.coordinate_rows.size(); ++i) {
    double* value = ws.J.values(model.first_coordinate_row + static_cast<int>(i));
    for (const CoordinateRow::Term& term : model.coordinate_rows[i].terms) *value++ = term.factor;
  }
}

// Rates J v - b and gamma. After loop_velocities.
template <class A>
void coordinate_row_velocities(const Model<A>& model, const typename A::Scalar* v,
                               const std::vector<typename A::Scalar>& targets, Workspace<A>& ws) {
  using T = typename A::Scalar;
  for (std::size_t i = 0; i < model.coordinate_rows.size(); ++i) {
    T& rate = ws.rate[model.first_coordinate_row + i];
    rate = -targets[3 * i + 1];
    for (const CoordinateRow::Term& term : model.coordinate_rows[i].terms) rate += T(term.factor) * v[term.v];
    ws.gamma[model.first_coordinate_row + i] = targets[3 * i + 2];
  }
}

// Acceleration residuals J vdot - gamma. After loop_accelerations.
template <class A>
void coordinate_row_accelerations(const Model<A>& model, const typename A::Scalar* vdot,
                                  const std::vector<typename A::Scalar>& targets, typename A::Scalar* rows) {
  using T = typename A::Scalar;
  for (std::size_t i = 0; i < model.coordinate_rows.size(); ++i) {
    T& row = rows[model.first_coordinate_row + i];
    row = -targets[3 * i + 2];
    for (const CoordinateRow::Term& term : model.coordinate_rows[i].terms) row += T(term.factor) * vdot[term.v];
  }
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

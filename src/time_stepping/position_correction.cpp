// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/position_correction.h"

#include "math/bounds.h"
#include "time_stepping/step_limits.h"

namespace gelenk {

void PositionCorrection::reserve(std::size_t rows) {
  rows_.reserve(rows);
  cones_.reserve(rows);
  excess_.reserve(rows);
  x_.reserve(rows);
  operator_.reserve(rows);
}

void PositionCorrection::clear() {
  rows_.clear();
  cones_.clear();
  excess_.clear();
}

void PositionCorrection::add(int row, double excess, double lower, double upper) {
  cones_.push_back(Cone::within(static_cast<int>(rows_.size()), lower, upper));
  rows_.push_back(row);
  excess_.push_back(excess);
}

void PositionCorrection::hold(const JointRows::Row& joint, const Cone& cone) {
  const bool turns = joint.is_of_speed;
  add(cone.first, joint.passed, turns ? cone.lower : -unlimited, turns ? cone.upper : unlimited);
}

ConeResult PositionCorrection::solve(const ConeOperator& all, ConeSolver& solver, double tolerance,
                                     std::vector<double>& out) {
  operator_.select(all, rows_);
  x_.assign(rows_.size(), 0.0);
  ConeOptions options;
  options.tolerance = tolerance;
  options.max_iterations = most_cone_iterations;
  const ConeResult result = solver.solve({operator_, excess_, cones_, false}, options, x_.data());
  for (std::size_t i = 0; i < rows_.size(); ++i) out[static_cast<std::size_t>(rows_[i])] = x_[i];
  return result;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The smallest displacement, in the mass metric, with which some rows of a step change by given amounts or up to
// bounds.
#pragma once

#include <cstddef>
#include <vector>

#include "complementarity/cone.h"
#include "time_stepping/joint_rows.h"
#include "time_stepping/selected_rows.h"

namespace gelenk {

class PositionCorrection {
 public:
  void reserve(std::size_t rows);
  void clear();
  // Rows are added in ascending order. The displacement ends the excess of its row by impulses between these bounds.
  void add(int row, double excess, double lower, double upper);
  // A joint that a latch or friction has held at rest keeps its position, and one that a one-way clutch has held does
  // not turn back: corrections would add up to a creep. A latch that has passed a limit returns to it. cone: of the
  // row.
  void hold(const JointRows::Row& joint, const Cone& cone);
  // out: by row of all, the impulses of the displacement; for other rows it is unchanged. tolerance: of displacements.
  ConeResult solve(const ConeOperator& all, ConeSolver& solver, double tolerance, std::vector<double>& out);

 private:
  std::vector<int> rows_;
  std::vector<Cone> cones_;
  std::vector<double> excess_, x_;
  SelectedRows operator_;
};

}  // namespace gelenk

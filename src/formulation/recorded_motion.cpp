// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/recorded_motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <random>
#include <utility>

namespace gelenk {

void RecordedMotion::make(const std::vector<double>& cut_reference, const Pivots& pivots) {
  program_ = EquationProgram::make(mechanism_, loads_, cut_reference, pivots);
  is_current_ = true;
}

void RecordedMotion::record(const std::vector<double>& cut_reference, const double* y, const Drives& drives) {
  is_used_ = false;
  try {
    choose(cut_reference, y, drives);
    dynamics_.set_position(y);
    if (mechanism_.rows > 0) dynamics_.factorize();
  } catch (const SingularMass&) {  // reported by the first step that needs its inertia
    loads_changed();
  }
}

void RecordedMotion::choose(const std::vector<double>& cut_reference, const double* y, const Drives& drives) {
  if (dynamics_.switching_forces().count() > 0 || dynamics_.kinks().count() > 0 ||
      !EquationProgram::is_possible(mechanism_, loads_))
    return;
  const Eigen::Index nv = mechanism_.nv;
  // Not that of the run, which remembers the pivots that it has seen.
  ConstraintProjector projector(mechanism_, dynamics_);
  dynamics_.set_singular_threshold(0);
  std::vector<std::vector<double>> positions;
  std::vector<RowMatrix> J;
  RowMatrix M(nv, nv);
  std::vector<double> f(static_cast<std::size_t>(nv));
  std::vector<double> at_rest(y, y + drives.motion_size());
  std::fill(at_rest.begin() + mechanism_.nq, at_rest.end(), 0.0);
  std::mt19937 random(1);  // its numbers are the same everywhere, those of distributions are not
  for (const double around : pivot_neighborhoods) {
    std::vector<double> q(y, y + mechanism_.nq);
    for (double& x : q)
      x += around * (2 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1);
    if (!projector.close_position(q.data())) continue;
    dynamics_.set_velocity(at_rest.data() + mechanism_.nq);
    dynamics_.assemble(drives.u().data(), M.data(), f.data());
    J.push_back(equilibrated(M, dynamics_.J()));
    positions.push_back(std::move(q));
    if (mechanism_.rows == 0) break;
  }
  if (positions.empty()) return;
  std::size_t usual = 0;
  const Pivots pivots = choose_pivots(J, usual);
  if (!is_current_ || pivots != pivots_) make(cut_reference, pivots);
  pivots_ = pivots;
  if (!program_) return;
  std::ranges::copy(positions[usual], at_rest.begin());
  at_rest.insert(at_rest.end(), y + drives.motion_size(), y + drives.motion_size() + drives.states());
  std::vector<double> ydot(at_rest.size());
  program_->evaluate(at_rest.data(), drives.u().data(), dynamics_.targets().data(), ydot.data());
  is_used_ = program_->take_usual_pivots();
  usual_pivot_ratio_ = 0;
  if (mechanism_.rows == 0) return;
  dynamics_.set_position(positions[usual].data());
  dynamics_.factorize();
  usual_pivot_ratio_ = dynamics_.pivot_ratio();
}

// The program follows from the loads and the pivots.
void RecordedMotion::serialize(Archive& archive, const std::vector<double>& cut_reference) {
  archive.serialize(is_used_, usual_pivot_ratio_);
  if (!is_used_) return;
  Pivots pivots = pivots_;
  auto count = static_cast<int>(pivots.rows.size());
  archive.serialize_in_range(count, 0, std::min(mechanism_.rows, mechanism_.nv));
  pivots.rows.resize(static_cast<std::size_t>(count));
  pivots.columns.resize(static_cast<std::size_t>(count));
  for (int& row : pivots.rows) archive.serialize_in_range(row, 0, mechanism_.rows - 1);
  for (int& column : pivots.columns) archive.serialize_in_range(column, 0, mechanism_.nv - 1);
  if (archive.reading() && (!is_current_ || pivots != pivots_)) {
    make(cut_reference, pivots);
    pivots_ = pivots;
  }
  if (program_) archive.serialize(program_->limits());
  is_used_ = program_ != nullptr;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/recorded_motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

namespace gelenk {
namespace {

// Accelerations of a program relative to the largest of the kernels, where pivots have their usual size: rounding is a
// millionth of this, another choice of equations much larger.
constexpr double most_different = 1e-6;

double largest(const double* x, Eigen::Index count) {
  return Eigen::Map<const Eigen::VectorXd>(x, count).lpNorm<Eigen::Infinity>();
}

// All friction slides in the positive direction, all stops are in contact, limits are not, and locks are open.
std::vector<int> all_in_motion(SwitchingForces& forces) {
  std::vector<int> out(static_cast<std::size_t>(forces.count()), 1);
  for (int i = 0; i < forces.locks(); ++i) {
    const SwitchingForces::Lock& lock = forces.lock(i);
    for (const int holds : {lock.limit, lock.latch}) {
      if (holds >= 0) out[static_cast<std::size_t>(holds)] = 0;
    }
  }
  return out;
}

}  // namespace

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
  if (!dynamics_.switching_forces().loads().empty() || dynamics_.kinks().count() > 0 ||
      !EquationProgram::is_possible(mechanism_, loads_))
    return;
  const Eigen::Index nv = mechanism_.nv;
  // Not that of the run, which remembers the pivots that it has seen.
  ConstraintProjector projector(mechanism_, dynamics_);
  dynamics_.set_singular_threshold(0);
  std::vector<std::vector<double>> positions;
  std::vector<RowMatrix> J;
  int rank = 0;
  RowMatrix M(nv, nv);
  std::vector<double> f(static_cast<std::size_t>(nv));
  std::vector<double> at_rest(y, y + drives.motion_size());
  std::fill(at_rest.begin() + mechanism_.nq, at_rest.end(), 0.0);
  for (std::vector<double>& q : positions_around({y, y + mechanism_.nq})) {
    if (!projector.close_position(q.data())) continue;
    if (mechanism_.rows > 0) dynamics_.factorize();
    rank = std::max(rank, dynamics_.rank());
    dynamics_.set_velocity(at_rest.data() + mechanism_.nq);
    dynamics_.assemble(drives.u().data(), M.data(), f.data());
    J.push_back(equilibrated(M, dynamics_.J()));
    positions.push_back(std::move(q));
    if (mechanism_.rows == 0) break;
  }
  if (positions.empty()) return;
  std::size_t usual = 0;
  const Pivots pivots = choose_pivots(J, rank, usual);
  if (!is_current_ || pivots != pivots_) make(cut_reference, pivots);
  pivots_ = pivots;
  if (!program_) return;
  std::vector<double> at_usual = std::move(positions[usual]);
  at_usual.resize(static_cast<std::size_t>(drives.motion_size()));
  at_usual.insert(at_usual.end(), y + drives.motion_size(), y + drives.motion_size() + drives.states());
  is_used_ = agrees(projector, at_usual, drives);
  usual_pivot_ratio_ = mechanism_.rows > 0 ? dynamics_.pivot_ratio() : 0;
}

// At a position, with velocities under which everything moves. Leaves `dynamics` there.
bool RecordedMotion::agrees(ConstraintProjector& projector, std::vector<double>& at, const Drives& drives) {
  double* v = at.data() + mechanism_.nq;
  for (int k = 0; k < mechanism_.nv; ++k) v[k] = std::sin(1.0 + k);
  dynamics_.set_position(at.data());
  dynamics_.factorize();
  projector.factors_changed();
  projector.close_velocity(v);
  std::vector<double> expected(static_cast<std::size_t>(mechanism_.nv));
  std::vector<double> found(at.size());
  SwitchingForces& forces = dynamics_.switching_forces();
  const std::vector<int> sides = all_in_motion(forces);
  const int* const before = forces.held_modes();
  forces.hold(sides.data());
  dynamics_.set_velocity(v);
  dynamics_.solve(drives.u().data(), expected.data());
  dynamics_.count_evaluations(-1);  // not of the run
  forces.hold(before);
  const EquationProgram::Arguments arguments{at.data(), drives.u().data(), dynamics_.targets().data(), sides.data()};
  program_->evaluate(arguments, found.data());
  if (!program_->take_usual_pivots()) return false;
  program_->evaluate(arguments, found.data());
  const double size = largest(expected.data(), mechanism_.nv);
  const double* vdot = found.data() + mechanism_.nq;
  for (const double x : expected) {
    if (!(std::abs(*vdot++ - x) <= most_different * (1 + size))) return false;
  }
  return true;
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

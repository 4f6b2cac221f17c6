// SPDX-License-Identifier: BSD-3-Clause
// Steps of a block of lanes: the Runge-Kutta method of order 4, then projection onto the constraints with the factors
// of its last stage, as integrator/rk4.cpp and formulation/constraint_projector.cpp do it for one. Lanes differ in how
// many corrections they need: those that need none are not changed by what the others do.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "batch/step_programs.h"
#include "lanes/kernels.h"

namespace gelenk {

// Why a lane has stopped, before the step that failed.
enum class StopReason : unsigned char { none, not_finite, singular, massless, open };

class BlockSteps {
 public:
  static constexpr int lanes = lanes::lanes_per_block;
  using Numbers = std::array<double, lanes>;
  using Stops = std::array<StopReason, lanes>;

  BlockSteps(const StepPrograms& programs, double length, double step);

  double* slot(int number) { return memory_ + static_cast<std::ptrdiff_t>(number) * lanes; }
  // Computes the constants from the numbers that vary, which are in their slots.
  void prepare() { run(programs_.prepare); }
  // Call when the state in its slots has been written.
  void begin() { has_gaps_ = has_pivots_ = false; }
  // Rates at the state in its slots.
  void evaluate(double time);
  // Reciprocals of pivots, of which those of a lane in a regular position are at most `limits`; see limits_of().
  // limits: by guard, by lane, from the last evaluation.
  void limits_of(double* limits);
  // Of the last evaluation. A pivot that has changed its sign since the one before has vanished between them.
  void check_pivots(const double* limits, Stops& stops);
  // Makes a step. Lanes with a reason in `stops` remain where they are, and so do those that get one.
  void step(double time, const double* limits, Stops& stops);
  // By lane: the guard that has stopped it.
  const std::array<int, lanes>& broken() const { return broken_; }
  // Evaluations of a block for projections.
  long renewals() const { return renewals_; }

 private:
  struct Closing;

  void run(const lanes::Program& program) { lanes::run(program.instructions(), memory_); }
  bool is_finite(std::size_t lane);
  void close_positions(Stops& stops);
  void close_velocities(Stops& stops);
  template <class Correct>
  void close(int residual, const Numbers& floor, Stops& stops, Correct correct);
  void correct_positions(const std::array<bool, lanes>& waits);
  void correct_velocities(const std::array<bool, lanes>& waits);
  void renew_factors(const std::array<bool, lanes>& renews);
  void normalize();
  Numbers largest(int first, int count, double least);

  const StepPrograms& programs_;
  double length_, step_;
  std::vector<double> storage_, kept_;
  double* memory_;
  std::vector<lanes::Instruction> begin_, first_, middle_, third_, last_;  // of the stages
  std::vector<double> last_pivots_;                                        // reciprocals when they were checked
  std::array<int, lanes> broken_{};
  double time_ = 0;
  bool has_gaps_ = false;    // whether `gaps` has run at the present state
  bool has_pivots_ = false;  // whether pivots have been checked since the state was written
  long renewals_ = 0;
};

}  // namespace gelenk

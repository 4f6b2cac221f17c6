// SPDX-License-Identifier: BSD-3-Clause
// The equations of motion of one island as a program: recorded from the kernels once, with the numbers of the scene as
// constants. What is alike in every evaluation, such as products with zero, is left out, and so is everything that
// searches: pivots are chosen when the program is made. Where one of them becomes small, or the motion is beyond what
// was recorded, evaluate() returns false, and the kernels take over. The answer depends on its arguments alone.
#pragma once

#include <memory>
#include <vector>

#include "kinematics/loads.h"
#include "lanes/program.h"
#include "machine_code/compiled_program.h"
#include "mechanism/mechanism.h"
#include "recorded/pivots.h"

namespace gelenk {

struct ProgramTerms;

class EquationProgram {
 public:
  // The present mechanism and loads, with pivots at a position where they have their usual size. Null: these equations
  // cannot be recorded, or are faster by the kernels. cut_reference: coordinates of the cut joints.
  static std::unique_ptr<EquationProgram> make(const Mechanism& mechanism, const Loads& loads,
                                               const std::vector<double>& cut_reference, const Pivots& pivots);
  // Whether make() may be worth trying.
  static bool is_possible(const Mechanism& mechanism, const Loads& loads);

  struct Arguments {
    const double *y, *u, *targets;  // y = (q, v, element states); see Kinematics::set_targets()
    const int* sides;               // of all forces with modes, of which none holds anything at rest
  };
  // ydot. u: signals that are not named (kinematics/loads.h). Returns false where the kernels have to do it.
  bool evaluate(const Arguments& given, double* ydot);
  // Takes the pivots of the last evaluate(), also if that returned false, as those of usual size. Returns false if they
  // are not finite.
  bool take_usual_pivots();
  // The smallest pivot of a constraint equation in the last evaluate(), relative to its usual size.
  double pivot_fraction() const { return pivot_fraction_; }
  // The least pivots with which it returns true; for saved states.
  std::vector<double>& limits() { return limits_; }
  const Pivots& pivots() const { return pivots_; }
  // With the factors of the last evaluate() that returned true: the smallest displacement dv (nv) in the mass metric
  // that removes the residual (by constraint equation) to first order.
  void displace(const double* residual, double* dv);

 private:
  EquationProgram(const Mechanism& mechanism, const Loads& loads, const std::vector<double>& cut_reference,
                  const Pivots& pivots);
  void compile(const ProgramTerms& of, const expression::Graph& graph, const lanes::Slots& known, lanes::Frame& frame);
  double* at(int slot) { return memory_.data() + slot; }

  Pivots pivots_;
  std::vector<double> memory_;
  int size_ = 0, signals_ = 0, targets_ = 0, sides_ = 0, nv_ = 0;
  int y_ = 0, u_ = 0, target_ = 0, side_ = 0, rate_ = 0, residual_ = 0, displacement_ = 0;  // first slots
  // What has to remain regular, by its reciprocal.
  struct Guard {
    int slot = 0;
    enum class Of : char { constraint, mass, distance } of = Of::constraint;
  };
  static double largest_reciprocal(Guard::Of of, double usual);
  std::vector<Guard> guards_;
  std::vector<double> limits_;  // largest reciprocals
  double pivot_fraction_ = 1;
  machine_code::CompiledProgram evaluate_, displace_;
};

}  // namespace gelenk

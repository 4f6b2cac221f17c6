// SPDX-License-Identifier: BSD-3-Clause
// What all cone solvers share: the problem in scaled variables, the present iterate, and the best one so far.
//
// Scaled variables x' = x / d, u' = d u, with one d for each group of components of a cone (see ConeResult): G' = D G D
// has a mean diagonal of 1 in each group, and the sets remain cones, with coefficients mu' = mu d_n / d_g. So a step of
// length 1 suits all cones, and no method needs a preconditioner. Everything below is in scaled variables.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "complementarity/cone.h"

namespace gelenk {

using ConeVector = Eigen::Map<Eigen::VectorXd>;
using ConeMatrix = Eigen::Map<Eigen::MatrixXd>;

// Memory that grows to the largest use and is handed out in pieces.
class ConeMemory {
 public:
  // Before pieces are taken: how many numbers they have together. Invalidates earlier pieces.
  void start(Eigen::Index numbers);
  double* take(Eigen::Index numbers);
  ConeVector vector(Eigen::Index size) { return {take(size), size}; }
  ConeMatrix matrix(Eigen::Index rows, Eigen::Index columns) { return {take(rows * columns), rows, columns}; }

 private:
  std::vector<double> numbers_;
  Eigen::Index used_ = 0;
};

// De Saxce's shift of the normal velocity of a contact; and out <- out + s(u), that of all.
double lift_of(const Cone& cone, const double* u);
void add_lift(std::span<const Cone> cones, const double* u, double* out);

enum class Iterate { start, best };

class ConeIteration {
 public:
  // Starts at x, projected onto K. problem, options and x stay in use until finish().
  void start(const ConeProblem& problem, const ConeOptions& options, double* x);
  // Writes the best iterate, projected onto K, to the x given to start().
  ConeResult finish();

  Eigen::Index size() const { return size_; }
  std::span<const Cone> cones() const { return cones_; }  // with scaled coefficients and bounds
  bool exact() const { return problem_->exact_coulomb; }
  double scale(Eigen::Index i) const { return d_[i]; }
  ConeVector b() { return {b_, size_}; }
  // The present iterate, and u = G x + b there. Methods change both together.
  ConeVector x() { return {x_, size_}; }
  ConeVector u() { return {u_, size_}; }

  void multiply(const double* in, double* out);           // out <- G in; counted
  void project_all(const double* in, double* out) const;  // out <- P_K(in); they may be the same
  void update_velocity();                                 // u <- G x + b
  const ConeOperator& G() const { return problem_->G; }   // not scaled
  Eigen::Map<const Eigen::MatrixXd> matrix();             // G, not scaled
  void count_product() { ++result_.products; }

  // Call after each iteration: keeps the iterate if its residual is the least so far. Returns whether to continue.
  // look: at the residual, which in large problems costs as much as a step of a gradient method.
  bool advance(bool look = true);
  double tolerance() const { return options_->tolerance; }
  bool done() const { return result_.converged || result_.iterations >= options_->max_iterations; }
  double residual() const { return residual_; }  // of the present iterate, at the last advance()
  double best_residual() const { return result_.residual; }
  void return_to(Iterate which);

 private:
  void check() const;
  void take_memory();
  void set_up_scales();
  double present_residual();
  double rounding() const;
  bool project_iterate();
  bool keep();

  const ConeProblem* problem_ = nullptr;
  const ConeOptions* options_ = nullptr;
  double* out_ = nullptr;
  Eigen::Index size_ = 0;
  double residual_ = 0;
  double start_residual_ = 0;
  bool matrix_formed_ = false;
  ConeResult result_;
  ConeMemory memory_;
  ConeMemory formed_;  // the matrix of an operator that has none
  double* formed_matrix_ = nullptr;
  std::vector<Cone> cones_;
  double *d_ = nullptr, *b_ = nullptr, *x_ = nullptr, *u_ = nullptr;
  double *start_x_ = nullptr, *best_x_ = nullptr, *best_u_ = nullptr;
  double *work_ = nullptr, *unscaled_ = nullptr;
};

// A solver: one or several methods applied to an iteration.
class IterativeConeSolver : public ConeSolver {
 public:
  ConeResult solve(const ConeProblem& problem, const ConeOptions& options, double* x) final;

 protected:
  // Allocates what problems of this size need, also for methods that only some of them need.
  virtual void reserve(ConeIteration& at) = 0;
  virtual void run(ConeIteration& at) = 0;

 private:
  ConeIteration iteration_;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The equations of assembly: those that must hold (loops, fixed values of cut joints) and the weighted distance from
// the guesses that is minimized.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "assembly/assembly.h"
#include "assembly/closing_steps.h"
#include "assembly/row_space.h"

namespace gelenk {

class AssemblyProblem {
 public:
  // rows: the constraint equations that must hold; null: all.
  AssemblyProblem(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts,
                  const std::vector<bool>* rows = nullptr);

  // Columns of the Jacobians below: the velocities that are not fixed or, at position level, whose coordinates are not.
  enum class Level { position, velocity };
  const std::vector<int>& free(Level level) const { return level == Level::position ? free_q_ : free_v_; }

  // Closure errors and errors of fixed values at q, and their Jacobian by displacements along the free velocities.
  Eigen::VectorXd gap(const std::vector<double>& q);
  SparseMatrix gap_jacobian(const std::vector<double>& q);
  // The same in full and transposed, a column for each equation: cheaper for a small problem.
  bool is_small() const { return static_cast<Eigen::Index>(free_q_.size()) <= max_full_unknowns; }
  const Eigen::MatrixXd& gap_columns(const std::vector<double>& q);
  // Distances from the guesses times the square roots of their weights, and their Jacobian. q as in the last gap().
  Eigen::VectorXd distance(const std::vector<double>& q);
  SparseMatrix distance_jacobian(const std::vector<double>& q);
  // The same in two parts: of the free tree coordinates, whose Jacobian is diagonal, with the roots of tree_weights();
  // and of the cut joints, with the transpose of their Jacobian in full.
  Eigen::VectorXd tree_distance(const std::vector<double>& q) const;
  const Eigen::VectorXd& tree_weights() const { return tree_weights_; }
  Eigen::VectorXd cut_distance(const std::vector<double>& q);
  const Eigen::MatrixXd& cut_distance_columns(const std::vector<double>& q);

  // The linear equations of the velocities at q: gap = G v_free + g0, distance = T v_free + d0.
  struct VelocityEquations {
    SparseMatrix G, T;
    Eigen::VectorXd g0, d0;
    std::vector<bool> given;  // by row of T: the velocity was given
    std::vector<double> v;    // fixed velocities; the others are zero
  };
  VelocityEquations velocity_equations(const std::vector<double>& q);

  // q displaced by `step` along the free velocities.
  std::vector<double> displaced(const std::vector<double>& q, const Eigen::VectorXd& step) const;
  // Changes free angles by full turns so that they are within half a turn of their guesses. Returns whether any
  // changed.
  bool unwind(std::vector<double>& q) const;

  // Largest change of a coordinate that is not fixed, in the tree or at cut joints [rad, m]: of those that were given,
  // and of all that have a weight.
  struct Largest {
    double given = 0, any = 0;
  };
  Largest moved(const std::vector<double>& q);
  // The squared distance from the guesses: the part of the values that were given, and that of the others.
  struct Squared {
    double given = 0, other = 0;
  };
  Squared squared_distance(const std::vector<double>& q);
  // The same of the tree's coordinates alone.
  Squared squared_tree_distance(const std::vector<double>& q) const;
  // The changes of all coordinates with a weight or a fixed value, in the order of their ranks and with the user's
  // signs; angles within half a turn.
  std::vector<double> changes_by_rank(const std::vector<double>& q);

  // Largest difference of two positions: of a coordinate, angles modulo a turn, or of a rotation vector [rad, m].
  double separation(const std::vector<double>& a, const std::vector<double>& b) const;

  // Scale of lengths [m], for limits on steps and closure errors.
  double length() const { return length_; }
  // How far a length may change in a search [m]: strokes may exceed the size of the links.
  double span() const { return span_; }
  const Mechanism& mechanism() const { return mechanism_; }
  const InitialGuess& guesses() const { return tree_; }

 private:
  SparseMatrix rows_at(const std::vector<double>& q);
  Eigen::VectorXd tree_offset(const std::vector<double>& q) const;
  Eigen::VectorXd cut_offset(const std::vector<double>& q);
  // Calls visit(velocity of a cut joint, tree velocity, speed of the former per speed of the latter).
  template <class Visit>
  void each_cut_speed(Visit visit);
  // Calls visit(guesses, velocity, change of its coordinate) for all joints.
  template <class Visit>
  void each_change(const std::vector<double>& q, Visit visit);
  SparseMatrix cut_columns(const std::vector<double>& q);

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  const InitialGuess& tree_;
  const InitialGuess& cuts_;
  std::vector<int> free_q_, free_v_;
  std::vector<bool> turns_;         // InitialGuess::turns of the tree, except angles held by coordinate rows
  std::vector<int> position_rows_;  // constraint equations that hold positions
  bool cuts_fixed_ = false, cut_guesses_ = false;
  Eigen::VectorXd tree_weights_;  // by free coordinate
  std::vector<int> place_;        // by tree velocity: its place among the free ones, -1: fixed
  Eigen::MatrixXd columns_, cut_columns_;
  double length_ = 1;
  double span_ = 0;  // m
  std::vector<double> cut_speeds_;
};

}  // namespace gelenk

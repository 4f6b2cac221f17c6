// SPDX-License-Identifier: BSD-3-Clause
// The equations of assembly: what must hold (the loops, fixed values of cut joints) and what is wished.
#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "assembly/assembly.h"
#include "assembly/row_space.h"

namespace gelenk {

class AssemblyProblem {
 public:
  AssemblyProblem(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts);

  // Columns of the Jacobians below: the speeds whose coordinates (speeds) are not fixed.
  enum class Level { position, velocity };
  const std::vector<int>& free(Level level) const { return level == Level::position ? free_q_ : free_v_; }

  // At q: what must vanish, and its derivative by the free speeds' displacements.
  Eigen::VectorXd gap(const std::vector<double>& q);
  SparseMatrix gap_jacobian(const std::vector<double>& q);
  // Distances from the wishes times the roots of their weights, and their derivative. q as in the last gap().
  Eigen::VectorXd distance(const std::vector<double>& q);
  SparseMatrix distance_jacobian(const std::vector<double>& q);

  // The same for speeds, linear: gap = G v_free + g0, distance = T v_free + d0, v_free from zero. At q.
  struct Speeds {
    SparseMatrix G, T;
    Eigen::VectorXd g0, d0;
    std::vector<double> v;  // fixed speeds in place, the rest zero
  };
  Speeds speeds(const std::vector<double>& q);

  // q moved along the free speeds.
  std::vector<double> displaced(const std::vector<double>& q, const Eigen::VectorXd& step) const;
  // Free angles put within half a turn of their wishes, which moves nothing.
  void unwind(std::vector<double>& q) const;

  // Largest change of a coordinate that was given but not fixed, in the tree or at cut joints.
  double moved(const std::vector<double>& q);

  // q with the free coordinates anywhere: angles and quaternions all round, lengths within what links span.
  std::vector<double> scattered(std::mt19937& random) const;
  // Largest difference of two positions: of a coordinate, angles modulo a turn, or of a quaternion's turns.
  double apart(const std::vector<double>& a, const std::vector<double>& b) const;

  // Scale of lengths [m], for limits on steps and gaps.
  double length() const { return length_; }

 private:
  SparseMatrix rows_at(const std::vector<double>& q);
  Eigen::VectorXd tree_offset(const std::vector<double>& q) const;
  Eigen::VectorXd cut_offset(const std::vector<double>& q);
  SparseMatrix cut_columns(const std::vector<double>& q);
  void find_cut_pattern();

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  const InitialGuess& tree_;
  const InitialGuess& cuts_;
  std::vector<int> free_q_, free_v_;
  std::vector<bool> turns_;         // InitialGuess::turns of the tree, but for angles that coordinate rows hold
  std::vector<int> position_rows_;  // rows that have a position level
  bool cuts_fixed_ = false, cut_guesses_ = false;
  double length_ = 1;
  double span_ = 0;  // [m] of the largest link
  // By cut, the tree speeds that move it; and speeds by groups, no two of which move the same cut.
  std::vector<std::vector<int>> moving_;
  std::vector<std::vector<int>> groups_;
};

}  // namespace gelenk

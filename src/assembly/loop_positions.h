// SPDX-License-Identifier: BSD-3-Clause
// Positions at which loops close as well as can be, whose equations contradict each other a little.
#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "assembly/loop_geometry.h"

namespace gelenk {

class LoopPositions {
 public:
  // rank: singular values of J beyond so many are taken for zero. misfit: gaps up to this are closed.
  LoopPositions(const LoopGeometry& loops, Eigen::Index rank, double misfit)
      : loops_(loops), rank_(rank), misfit_(misfit) {}

  struct Position {
    std::vector<double> q;
    double gap = 0;         // the largest that is left
    Eigen::VectorXd sigma;  // singular values of J
  };

  // The nearest position from q with the least gaps, by Levenberg-Marquardt steps of truncated rank.
  Position closed(std::vector<double> q) const;

  // Positions reached from `start` along what the rank leaves free, `count` of them with `start`, if there are so many;
  // only those at which the rank is certain.
  std::vector<std::vector<double>> walk(const Position& start, std::size_t count, unsigned seed) const;

  // Whether the rank is that of J, and by far.
  bool is_regular(const Position& position) const;

 private:
  Eigen::VectorXd free_direction(const std::vector<double>& q, std::mt19937& random) const;

  const LoopGeometry& loops_;
  Eigen::Index rank_;
  double misfit_;
};

// J's singular value decomposition, U complete.
struct Decomposition {
  explicit Decomposition(const Eigen::MatrixXd& J);
  Eigen::MatrixXd U, V;
  Eigen::VectorXd sigma;
  // The shortest x with J x nearest to b, of this rank; damped: sigma / (sigma^2 + damping) stands for 1 / sigma.
  Eigen::VectorXd solve(const Eigen::VectorXd& b, Eigen::Index rank, double damping = 0) const;
};

}  // namespace gelenk

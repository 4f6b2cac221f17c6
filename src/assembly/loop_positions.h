// SPDX-License-Identifier: BSD-3-Clause
// Positions at which loops whose equations contradict each other slightly close as well as possible.
#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "assembly/loop_geometry.h"

namespace gelenk {

class LoopPositions {
 public:
  // rank: number of singular values of J that are treated as nonzero. misfit: closure errors up to this count as closed
  // [m, rad].
  LoopPositions(const LoopGeometry& loops, Eigen::Index rank, double misfit)
      : loops_(loops), rank_(rank), misfit_(misfit) {}

  struct Position {
    std::vector<double> q;
    double gap = 0;         // largest closure error [m, rad]
    Eigen::VectorXd sigma;  // singular values of J
  };

  // The position with the least closure error near q, by Levenberg-Marquardt steps of truncated rank.
  Position closed(std::vector<double> q) const;

  // Up to `count` positions, including `start`, reached from it along the motions that the rank leaves free; only those
  // at which the rank is certain.
  std::vector<std::vector<double>> walk(const Position& start, std::size_t count, unsigned seed) const;

  // Whether `rank` is the rank of J at the position, with a clear gap between its singular values.
  bool is_regular(const Position& position) const;

 private:
  Eigen::VectorXd free_direction(const std::vector<double>& q, std::mt19937& random) const;

  const LoopGeometry& loops_;
  Eigen::Index rank_;
  double misfit_;
};

}  // namespace gelenk

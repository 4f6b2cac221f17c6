// SPDX-License-Identifier: BSD-3-Clause
// H = 1 + W Q diag(weight) Q^T W^T, Q the modes of the projection onto the cones: the sparse matrix of Newton's methods
// in the space of whitened velocities. Each contact couples the velocities of its two bodies only.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "complementarity/iteration.h"
#include "complementarity/projection.h"
#include "linear/gmres.h"

namespace gelenk {

using ModeWeights = std::array<double, Cone::max_size>;

class VelocityHessian {
 public:
  // Takes the root of G, in scaled variables, and orders the rows if its pattern has changed.
  void start(ConeIteration& at);
  Eigen::Index rows() const { return rows_; }
  // Rows of W with entries.
  int moved_rows() const { return moved_rows_; }
  // Estimates of the multiplications of a factorization, and of a product with G.
  double factor_cost() const { return factor_cost_; }
  double product_cost() const { return 2 * static_cast<double>(value_.size()); }

  // out <- W x;  out <- W^T w
  void multiply(const double* x, Eigen::VectorXd& w) const;
  void multiply_transposed(const Eigen::VectorXd& w, double* out) const;

  // Factorizes H. weights: by cone and mode. Returns false if that fails.
  bool factorize(std::span<const Cone> cones, std::span<const ProjectionModes> modes,
                 std::span<const ModeWeights> weights);
  // out <- H^-1 g
  void solve(const Eigen::VectorXd& g, Eigen::VectorXd& out) const;
  // out <- (H + W L W^T)^-1 g, with L = lifted sigma^T for each cone: the unsymmetric part of Coulomb's law, by GMRES.
  void solve_lifted(std::span<const Cone> cones, const double* sigma, const double* lifted, double tolerance,
                    const Eigen::VectorXd& g, Eigen::VectorXd& out);

 private:
  // The velocities that a cone moves, and the places of their products in the values of H.
  struct Block {
    std::vector<int> rows;
    std::vector<int> places;  // lower triangle, column by column
  };

  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>;

  bool take_root(ConeIteration& at);
  void find_blocks(std::span<const Cone> cones);
  void order();
  int group_rows(std::vector<int>& group);
  void analyze();
  void add(const Cone& cone, const Block& block, const ProjectionModes& modes, const ModeWeights& weights);
  void scatter(const Block& block);

  int rows_ = 0, moved_rows_ = 0;
  // Of W, by column. row_: in the order of elimination; local_: index of the row within the cone's block
  std::vector<int> first_, row_, local_;
  std::vector<int> given_row_;  // as the operator numbers them
  std::vector<double> value_;
  std::vector<int> block_of_;  // by cone
  std::vector<Block> blocks_;
  std::vector<double> sum_, y_;  // of the block at hand
  double factor_cost_ = 0;
  bool analyzed_ = false;
  Eigen::SparseMatrix<double> H_;
  Factor factor_;
  Gmres gmres_;
  Eigen::VectorXd right_, moved_;
  std::vector<double> change_;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Cone complementarity problems of frictional contact, and the interface of their solvers.
//
// Unknowns x: impulses [N s; N m s], in blocks of one contact or one limited force each. G: the Delassus operator (the
// change of the relative velocities by an impulse), b: the relative velocities without the impulses [m/s; rad/s],
// u = G x + b those with them. K is the product of the blocks' sets.
//   convex:  K contains x,  u in the dual cone K*,  x . u = 0:   the minimum of 1/2 x^T G x + b^T x over K
//   exact:   the same with u + s(u) in place of u, s(u) = friction |u_t| + spinning |u_s| + rolling |u_r| in the normal
//            component of each contact: Coulomb's law (De Saxce & Feng 1998). In the convex problem a sliding contact
//            separates with the velocity friction |u_t|.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace gelenk {

inline std::size_t at_index(int i) { return static_cast<std::size_t>(i); }

// A group of components of a contact, limited in proportion to the normal impulse n: |x[offset .. offset + size)| <=
// coefficient n.
struct ConeGroup {
  int offset = 0;
  int size = 0;
  double coefficient = 0;
};

// One block of unknowns.
//   contact    [n, t (tangential), s (about the normal), r (about tangential axes)] with n >= 0, |t| <= friction n,
//              |s| <= spinning n, |r| <= rolling n. Groups may be absent; the coefficient of a group that is present
//              may be 0, which makes the group 0.
//   interval   one number, lower <= x <= upper; either bound may be infinite
//   ball       `tangential` numbers, up to 3, with |x| <= radius: isotropic friction whose limit is given
struct Cone {
  static constexpr int groups = 3;            // t, s, r
  static constexpr std::size_t max_size = 6;  // n; t1, t2; s; r1, r2
  static constexpr std::size_t max_block = max_size * max_size;

  bool interval = false, is_ball = false;
  int first = 0;  // unknown of the problem
  int tangential = 0, spin = 0, roll = 0;
  double friction = 0, spinning = 0, rolling = 0;  // -, m, m
  double lower = 0, upper = 0;                     // of an interval
  double radius = 0;                               // of a ball

  // A contact in space, with the components that have a positive coefficient.
  static Cone contact(int first, double friction, double spinning = 0, double rolling = 0) {
    Cone cone;
    cone.first = first;
    cone.friction = friction;
    cone.spinning = spinning;
    cone.rolling = rolling;
    cone.tangential = friction > 0 ? 2 : 0;
    cone.spin = spinning > 0 ? 1 : 0;
    cone.roll = rolling > 0 ? 2 : 0;
    return cone;
  }
  // A contact in a plane: one tangential component, and one of rolling.
  static Cone planar_contact(int first, double friction, double rolling = 0) {
    Cone cone = contact(first, friction, 0, rolling);
    cone.tangential /= 2;
    cone.roll /= 2;
    return cone;
  }
  static Cone within(int first, double lower, double upper) {
    Cone cone;
    cone.interval = true;
    cone.first = first;
    cone.lower = lower;
    cone.upper = upper;
    return cone;
  }

  static Cone ball(int first, int size, double radius) {
    Cone cone;
    cone.is_ball = true;
    cone.first = first;
    cone.tangential = size;
    cone.radius = radius;
    return cone;
  }

  int size() const { return forces() + spin + roll; }
  // Those that are scaled together: the normal and tangential ones, or all of a ball.
  int forces() const { return is_ball ? tangential : 1 + tangential; }
  // By the normal component, which a ball has not.
  std::array<ConeGroup, groups> limited() const {
    if (is_ball) return {};
    return {{{.offset = 1, .size = tangential, .coefficient = friction},
             {.offset = 1 + tangential, .size = spin, .coefficient = spinning},
             {.offset = 1 + tangential + spin, .size = roll, .coefficient = rolling}}};
  }
};

// A sparse W with G = W^T W. Column j, of unknown j, has the entries first[j] to first[j + 1], in ascending rows.
struct ConeRoot {
  int rows = 0;
  std::span<const int> first;
  std::span<const int> row;
  std::span<const double> value;

  struct Column {
    std::span<const int> row;
    std::span<const double> value;
  };
  Column column(int j) const {
    const auto begin = static_cast<std::size_t>(first[static_cast<std::size_t>(j)]);
    const std::size_t size = static_cast<std::size_t>(first[static_cast<std::size_t>(j) + 1]) - begin;
    return {row.subspan(begin, size), value.subspan(begin, size)};
  }
};

// Unknowns up to which an operator with a root has a matrix, too. Beyond, it would cost more than it saves; sparse
// methods are as fast with a hundred unknowns, but their factors ask for memory in every step.
inline constexpr int most_with_matrix_and_root = 200;

// G: symmetric and positive semidefinite.
class ConeOperator {
 public:
  virtual ~ConeOperator() = default;
  virtual int size() const = 0;
  // y = G x
  virtual void apply(const double* x, double* y) const = 0;
  // The rows and columns of a cone: cone.size() squared numbers, row by row.
  virtual void diagonal_block(const Cone& cone, double* out) const = 0;
  // The whole matrix, size() x size(), or null if it is never formed. Methods that need it then form it, by size()
  // products.
  virtual const double* dense() const { return nullptr; }
  // A sparse root of G, which methods for large problems factorize; without columns: there is none.
  virtual ConeRoot root() const { return {}; }
};

// A matrix as operator; it must outlive this.
class DenseConeOperator final : public ConeOperator {
 public:
  // G: without gaps between its columns; must outlive it.
  explicit DenseConeOperator(const Eigen::Ref<const Eigen::MatrixXd>& G) : G_(G.data(), G.rows(), G.cols()) {}
  int size() const override { return static_cast<int>(G_.rows()); }
  void apply(const double* x, double* y) const override;
  void diagonal_block(const Cone& cone, double* out) const override;
  const double* dense() const override { return G_.data(); }

 private:
  Eigen::Map<const Eigen::MatrixXd> G_;
};

// The cones follow each other without gaps: cones[0].first = 0, cones[i + 1].first = cones[i].first + cones[i].size().
struct ConeProblem {
  const ConeOperator& G;
  std::span<const double> b;
  std::span<const Cone> cones;
  bool exact_coulomb = true;
};

// The residual: the natural map of each cone, in units of b, the largest of all cones. Each group of components g of
// each cone (normal and tangential ones together are one group) has a length-preserving scale d_g = 1 / sqrt(mean of
// G's diagonal over the group); with P_K the projection in the scaled variables x_g / d_g,
//   residual = | x/d - P_K(x/d - d (u + s)) | / d_n,
// which for a contact without spinning and rolling is |x - P_K(x - tau (u + s))| / tau, tau = d_n^2. Rotation rates
// count with the length d_r / d_n, about a radius of gyration. It is 0 at solutions only, but never below the rounding
// of x/d.
struct ConeResult {
  double residual = 0;  // m/s
  int iterations = 0;   // of all phases of a method
  int products = 0;     // with G
  bool converged = false;
};

// Called at the initial guess and after each iteration, for charts. The residual is the best so far.
class ConeObserver {
 public:
  virtual ~ConeObserver() = default;
  virtual void reached(const ConeResult& so_far) = 0;
};

// How many iterations are more than the usual ones for the forces or impulses of an instant.
inline long excess_iterations(long iterations) {
  constexpr long usual = 50;
  return iterations > usual ? iterations - usual : 0;
}

struct ConeOptions {
  double tolerance = 1e-10;   // of the residual [m/s]; where it is below the rounding of G x + b, the latter counts
  int max_iterations = 1000;  // of all phases of a method together
  ConeObserver* observer = nullptr;
};

// A solver keeps its memory: a call for a problem no larger than those before allocates nothing (but the matrix of an
// operator that has none, when it is first formed). It carries nothing
// else from call to call; the same calls give the same bits.
class ConeSolver {
 public:
  virtual ~ConeSolver() = default;
  // x: initial guess on entry, the solution on return, in K. The result is the iterate with the least residual, the
  // guess (projected onto K) included. Throws std::invalid_argument if the cones do not fit the problem. Numbers that
  // are not finite leave x as it is, with an infinite residual.
  virtual ConeResult solve(const ConeProblem& problem, const ConeOptions& options, double* x) = 0;
};

struct ConeSolverKind {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<ConeSolver> (*make)();
};

// All solvers (registry.cpp); the first is the default.
std::span<const ConeSolverKind> cone_solver_kinds();

// Throws std::out_of_range for an unknown name.
std::unique_ptr<ConeSolver> make_cone_solver(std::string_view name);

// One function per solver.
std::unique_ptr<ConeSolver> make_hybrid_cone_solver();
std::unique_ptr<ConeSolver> make_spectral_cone_solver();
std::unique_ptr<ConeSolver> make_accelerated_cone_solver();
std::unique_ptr<ConeSolver> make_newton_cone_solver();
std::unique_ptr<ConeSolver> make_admm_cone_solver();
std::unique_ptr<ConeSolver> make_gauss_seidel_cone_solver();

}  // namespace gelenk

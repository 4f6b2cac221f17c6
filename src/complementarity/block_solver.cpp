// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/block_solver.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "complementarity/projection.h"
#include "linear/dense_factor.h"

namespace gelenk {
namespace {

using Block = std::array<double, Cone::max_size>;

constexpr int max_steps = 30;
constexpr double regularization = 1e-12;
constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();

// An iterate: x, u = W x + q, z = x - u - s(u) and F = x - P_K(z).
struct BlockIterate {
  Block x{}, u{}, z{}, F{};
  double merit = 0;  // squared norm of F
};

class BlockProblem {
 public:
  BlockProblem(const Cone& cone, const double* W, const double* q, bool exact)
      : cone_(cone),
        W_(W),
        q_(q),
        n_(static_cast<std::size_t>(cone.size())),
        exact_(exact && !cone.interval && !cone.is_ball) {}

  void evaluate(BlockIterate& at) const {
    for (std::size_t i = 0; i < n_; ++i) {
      at.u[i] = q_[i];
      for (std::size_t j = 0; j < n_; ++j) at.u[i] += W_[i * n_ + j] * at.x[j];
      at.z[i] = at.x[i] - at.u[i];
    }
    if (exact_) at.z[0] -= lift(at.u, nullptr);
    project(cone_, at.z.data(), at.F.data());
    at.merit = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      at.F[i] = at.x[i] - at.F[i];
      at.merit += at.F[i] * at.F[i];
    }
  }

  // What rounding leaves of the norm of F.
  double floor(const BlockIterate& at) const {
    double largest = 0;
    for (std::size_t i = 0; i < n_; ++i) largest = std::max(largest, std::abs(at.x[i]) + std::abs(q_[i]));
    return rounding * largest;
  }

  // x <- x + the Newton step
  BlockIterate newton(const BlockIterate& at) const {
    Block sigma{};
    if (exact_) lift(at.u, sigma.data());
    ProjectionModes modes;
    projection_modes(cone_, at.z.data(), modes);
    const auto count = static_cast<std::size_t>(modes.count);
    Block step{}, y{};
    for (std::size_t i = 0; i < n_; ++i) step[i] = -at.F[i];
    for (std::size_t k = 0; k < count; ++k) {
      double along = 0;
      for (std::size_t i = 0; i < n_; ++i) along += modes.q[k][i] * at.F[i];
      y[k] = -along / modes.lambda[k];
      for (std::size_t i = 0; i < n_; ++i) step[i] += modes.q[k][i] * along;
    }
    std::array<double, Cone::max_block> A{};
    const Block change = lifted_product(step, sigma);
    for (std::size_t r = 0; r < count; ++r) {
      for (std::size_t i = 0; i < n_; ++i) y[r] -= modes.q[r][i] * change[i];
    }
    for (std::size_t k = 0; k < count; ++k) {
      const Block column = lifted_product(modes.q[k], sigma);
      for (std::size_t r = 0; r < count; ++r) {
        for (std::size_t i = 0; i < n_; ++i) A[k * count + r] += modes.q[r][i] * column[i];
      }
      A[k * count + k] += 1 / modes.lambda[k] - 1 + regularization;
    }
    std::array<int, Cone::max_size> pivots{};
    const DenseMatrix matrix(A.data(), modes.count, modes.count);
    factorize_general(matrix, pivots.data(), regularization);
    solve_general(matrix, pivots.data(), DenseVector(y.data(), modes.count));
    BlockIterate out = at;
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t k = 0; k < count; ++k) step[i] += modes.q[k][i] * y[k];
      out.x[i] += step[i];
    }
    return out;
  }

  // x <- P_K(x - (u + s) / trace W)
  BlockIterate projected_gradient(const BlockIterate& at) const {
    double trace = 0;
    for (std::size_t i = 0; i < n_; ++i) trace += W_[i * n_ + i];
    const double length = trace > 0 ? 1 / trace : 1;
    BlockIterate out = at;
    for (std::size_t i = 0; i < n_; ++i) out.z[i] = at.x[i] + length * (at.z[i] - at.x[i]);
    project(cone_, out.z.data(), out.x.data());
    return out;
  }

 private:
  // s(u), and its derivative if that is not null.
  double lift(const Block& u, double* sigma) const {
    double sum = 0;
    for (const ConeGroup& group : cone_.limited()) {
      double square = 0;
      for (int i = group.offset; i < group.offset + group.size; ++i) square += u[at(i)] * u[at(i)];
      const double length = std::sqrt(square);
      sum += group.coefficient * length;
      if (!sigma || length == 0) continue;
      for (int i = group.offset; i < group.offset + group.size; ++i) sigma[i] = group.coefficient * u[at(i)] / length;
    }
    return sum;
  }
  // (1 + S) W v
  Block lifted_product(const Block& v, const Block& sigma) const {
    Block out{};
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t j = 0; j < n_; ++j) out[i] += W_[i * n_ + j] * v[j];
    }
    for (std::size_t i = 1; i < n_; ++i) out[0] += sigma[i] * out[i];
    return out;
  }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  const Cone& cone_;
  const double* W_;
  const double* q_;
  std::size_t n_;
  bool exact_;
};

// Coulomb's law at a point, with two tangential components: it opens, sticks or slides. The direction of slip d is the
// root of d x u_t, where u_n = 0; where the bodies' inertia does not couple the components, d is that of q_t.
class PointProblem {
 public:
  PointProblem(double friction, const double* W, const double* q)
      : friction_(friction), W_n_(W[0]), W_t_(W[3], W[6]), W_tt_(), q_n_(q[0]), q_t_(q[1], q[2]) {
    W_tt_ << W[4], W[5], W[7], W[8];
  }

  // Returns false if no solution was found: x is then as it was.
  bool solve(double* x) const {
    if (q_n_ >= 0) return set(x, 0, Eigen::Vector2d::Zero());
    return sticks(x) || slides(x);
  }

 private:
  static bool set(double* x, double normal, const Eigen::Vector2d& tangential) {
    x[0] = normal;
    x[1] = tangential[0];
    x[2] = tangential[1];
    return true;
  }

  // u = 0, by elimination of the normal component.
  bool sticks(double* x) const {
    const Eigen::Matrix2d reduced = W_tt_ - W_t_ * W_t_.transpose() / W_n_;
    const double determinant = reduced.determinant();
    if (!(determinant > 1e-8 * reduced(0, 0) * reduced(1, 1))) return false;
    const Eigen::Vector2d right = W_t_ * (q_n_ / W_n_) - q_t_;
    const Eigen::Vector2d tangential = Eigen::Vector2d(reduced(1, 1) * right[0] - reduced(0, 1) * right[1],
                                                       reduced(0, 0) * right[1] - reduced(1, 0) * right[0]) /
                                       determinant;
    const double normal = -(q_n_ + W_t_.dot(tangential)) / W_n_;
    if (!(tangential.squaredNorm() <= friction_ * friction_ * normal * normal) || !(normal >= 0)) return false;
    return set(x, normal, tangential);
  }

  // Newton's method for the angle of d.
  bool slides(double* x) const {
    Eigen::Vector2d d = q_t_ - W_t_ * (q_n_ / W_n_);  // the slip without friction
    for (int k = 0; k < max_turns; ++k) {
      const double length = d.norm();
      if (!(length > 0)) return false;
      d /= length;
      const Eigen::Vector2d e(-d[1], d[0]);
      const double opposing = W_n_ - friction_ * W_t_.dot(d);
      if (!(opposing > min_opposing * W_n_)) return false;
      const double normal = -q_n_ / opposing;
      const Eigen::Vector2d per_normal = W_t_ - friction_ * (W_tt_ * d);
      const Eigen::Vector2d u = q_t_ + normal * per_normal;
      const double across = e.dot(u), along = d.dot(u);
      if (std::abs(across) <= rounding * (q_t_.norm() + std::abs(q_n_))) {
        return along >= 0 && set(x, normal, -friction_ * normal * d);
      }
      // As d turns by dt: dd = e dt, de = -d dt.
      const double normal_turn = normal * friction_ * W_t_.dot(e) / opposing;
      const double rate = e.dot(per_normal) * normal_turn - friction_ * normal * e.dot(W_tt_ * e) - along;
      const double turn = -across / rate;
      if (!(std::abs(turn) < max_turn)) return false;
      d += std::tan(turn) * e;
    }
    return false;
  }

  static constexpr int max_turns = 12;
  static constexpr double max_turn = 1;  // rad
  static constexpr double min_opposing = 0.05;

  double friction_;
  double W_n_;
  Eigen::Vector2d W_t_;
  Eigen::Matrix2d W_tt_;
  double q_n_;
  Eigen::Vector2d q_t_;
};

bool is_point(const Cone& cone) {
  return !cone.interval && !cone.is_ball && cone.tangential == 2 && cone.spin == 0 && cone.roll == 0;
}

}  // namespace

void solve_block(const Cone& cone, const double* W, const double* q, bool exact, double* x) {
  if (exact && is_point(cone) && PointProblem(cone.friction, W, q).solve(x)) return;
  const BlockProblem problem(cone, W, q, exact);
  BlockIterate at;
  std::copy_n(x, cone.size(), at.x.begin());
  problem.evaluate(at);
  for (int k = 0; k < max_steps; ++k) {
    const double floor = problem.floor(at);
    if (!(at.merit > floor * floor)) break;
    BlockIterate next = problem.newton(at);
    problem.evaluate(next);
    if (!(next.merit < 0.8 * at.merit)) {
      next = problem.projected_gradient(at);
      problem.evaluate(next);
    }
    at = next;
  }
  project(cone, at.x.data(), x);
}

}  // namespace gelenk

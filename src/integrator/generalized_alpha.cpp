// SPDX-License-Identifier: BSD-3-Clause
// `generalized-alpha` (Chung & Hulbert 1993), fixed steps, with the auxiliary accelerations a,
//   q+ = q displaced by h v + h^2 ((1/2 - beta) a + beta a+),   v+ = v + h ((1 - gamma) a + gamma a+),
//   (1 - alpha_m) a+ + alpha_m a = (1 - alpha_f) vdot+ + alpha_f vdot,
// and vdot+ (for index3 with lambda+) such that the equations hold at the end of the step (Arnold & Bruls 2007);
// quaternions are displaced by displace() (Bruls, Cardona & Arnold 2012). Members of the family are `hht` (Hilber,
// Hughes & Taylor 1977; alpha_m = 0) and `newmark` (Newmark 1959; the trapezoidal rule, alpha_m = alpha_f = 0). Of
// order 2.
//
// a approximates vdot at t + theta h, theta = alpha_m - alpha_f. After a start or a jump of the inputs the first step
// is the trapezoidal rule, and a+ is extrapolated from vdot at its ends. Starting with a = vdot would cause an error of
// order h at each jump, and excite stiff springs.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "integrator/fixed_step.h"
#include "linear/pivots.h"
#include "util/text.h"

namespace gelenk {
namespace {

struct Coefficients {
  double alpha_m, alpha_f;
  double gamma() const { return 0.5 - alpha_m + alpha_f; }                  // for order 2
  double beta() const { return 0.25 * (gamma() + 0.5) * (gamma() + 0.5); }  // for maximum damping
};

// Convergence of Newton's method: change of the velocities in a step relative to 1 + |v|.
constexpr double convergence_tolerance = 1e-13;
constexpr double stagnation_tolerance = 1e-9;  // if rounding ends the progress; it grows for short steps of index3
// Contraction above which the matrix of an earlier step is recomputed; twice or half this value costs the same.
constexpr double refactorization_contraction = 0.1;
constexpr double max_contraction = 0.9;  // above it the iteration is given up
constexpr int newton_iterations = 25;
constexpr double step_change_tolerance = 0.05;  // relative change of the step up to which a matrix is reused

class GeneralizedAlpha final : public FixedStep {
 public:
  GeneralizedAlpha(Equations& system, const IntegratorOptions& options, Coefficients coefficients)
      : FixedStep(system, options),
        c_(coefficients),
        nq_(system.coordinates()),
        nv_(n_ - nq_),
        m_(system.multipliers()),
        x_(system.unknowns()),
        xdot_(system.unknowns()),
        r_(system.unknowns()),
        dq_(nv_),
        vdot_(nv_),
        a_(nv_),
        q_fixed_(nv_),
        v_fixed_(nv_),
        a_fixed_(nv_),
        F_x_(system.unknowns(), system.unknowns()),
        F_xdot_(system.unknowns(), system.unknowns()),
        A_(nv_ + m_, nv_ + m_),
        N_(nq_, nv_),
        rhs_(nv_ + m_),
        correction_(nv_ + m_),
        lu_(nv_ + m_) {}

  void restart(double t, const double* y) override {
    FixedStep::restart(t, y);
    fresh_ = true;
    matrix_step_ = 0;
  }
  void inputs_changed() override { fresh_ = true; }
  // Includes the Newton matrix, so that saving changes nothing; its factors are recomputed from it.
  void serialize(Archive& archive) override {
    FixedStep::serialize(archive);
    archive.serialize(fresh_, last_step_, vdot_, a_, x_, matrix_step_);
    if (matrix_step_ == 0) return;
    std::span<double> entries(A_.data(), static_cast<std::size_t>(A_.size()));
    archive.serialize(entries);
    if (archive.reading()) lu_.compute(A_);
  }

 private:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  bool is_explicit() const override { return false; }

  // Weights of vdot+ in q (times h^2), in v (times h) and in a+.
  struct Weights {
    double position, speed, acceleration;
  };

  void make_step(double t, double h) override {
    if (fresh_) begin(t);
    const Weights weights = prepare(h);
    Eigen::Map<Vector> vdot(xdot_.data() + nq_, nv_);
    vdot = vdot_;
    if (!solve(t + h, h, weights)) {
      refuse(
          system_, t, y_.data(),
          "Newton's method does not converge in a step of " + text::rounded(h) + " s; a shorter solver.step may help");
    }
    update_state(h, weights);  // includes the last correction
    vdot_ = vdot;
    a_ = a_fixed_ + weights.acceleration * vdot_;
    last_step_ = h;
    fresh_ = false;
    std::copy_n(x_.begin(), n_, y_.begin());
  }

  // Initializes vdot_ and, for a DAE, the multipliers.
  void begin(double t) {
    std::ranges::copy(y_, x_.begin());
    if (!system_.consistent(t, x_.data(), xdot_.data())) {
      refuse(system_, t, y_.data(), "the accelerations are not finite");
    }
    vdot_ = Eigen::Map<const Vector>(xdot_.data() + nq_, nv_);
    std::fill_n(xdot_.begin(), nq_, 0.0);  // not needed: the rows of qdot are not used
  }

  // Computes the fixed parts of q (times h^2), of v (times h) and of a+; returns the weights of vdot+ in them.
  Weights prepare(double h) {
    const double theta = c_.alpha_m - c_.alpha_f;
    if (fresh_) {
      q_fixed_ = vdot_ / 4;
      v_fixed_ = vdot_ / 2;
      a_fixed_ = -theta * vdot_;
      return {0.25, 0.5, 1 + theta};
    }
    if (h != last_step_) a_ = vdot_ + h / last_step_ * (a_ - vdot_);
    a_fixed_ = (c_.alpha_f * vdot_ - c_.alpha_m * a_) / (1 - c_.alpha_m);
    const double weight = (1 - c_.alpha_f) / (1 - c_.alpha_m);
    q_fixed_ = (0.5 - c_.beta()) * a_ + c_.beta() * a_fixed_;
    v_fixed_ = (1 - c_.gamma()) * a_ + c_.gamma() * a_fixed_;
    return {c_.beta() * weight, c_.gamma() * weight, weight};
  }

  // x_ <- the state at the end of the step for vdot+ as in xdot_.
  void update_state(double h, const Weights& s) {
    const Eigen::Map<const Vector> vdot(xdot_.data() + nq_, nv_);
    const Eigen::Map<const Vector> v(y_.data() + nq_, nv_);
    dq_ = h * v + h * h * (q_fixed_ + s.position * vdot);
    std::copy_n(y_.begin(), nq_, x_.begin());
    system_.displace(x_.data(), dq_.data());
    Eigen::Map<Vector>(x_.data() + nq_, nv_) = v + h * (v_fixed_ + s.speed * vdot);
  }

  enum class Newton { solved, continues, stalls, fails };

  // Assesses the iteration after a correction of this size; size_before: of the one before with the same matrix, 0 if
  // there is none.
  Newton assess(double size, double size_before, bool renewed) const {
    if (!std::isfinite(size)) return Newton::fails;
    if (size <= convergence_tolerance) return Newton::solved;
    if (size_before == 0) return Newton::continues;
    const double contraction = size / size_before;
    if (contraction <= refactorization_contraction)
      return contraction / (1 - contraction) * size <= convergence_tolerance ? Newton::solved : Newton::continues;
    if (size <= stagnation_tolerance) return Newton::solved;
    if (!renewed) return Newton::stalls;
    // Only rounding may be left in q, magnified by a short step.
    if (m_ > 0 && position_change_ <= convergence_tolerance) return Newton::solved;
    return contraction > max_contraction ? Newton::fails : Newton::continues;
  }

  // Newton's method for vdot+ and the multipliers. Its matrix is reused over many steps as long as the iteration
  // contracts well.
  bool solve(double t, double h, const Weights& s) {
    bool renewed = false;
    double size_before = 0;  // with the same matrix; 0: it is new
    for (int i = 0; i < newton_iterations; ++i) {
      update_state(h, s);
      if (!system_.residual(t, x_.data(), xdot_.data(), r_.data())) return false;
      if (std::abs(matrix_step_ - s.speed * h) > step_change_tolerance * s.speed * h) {
        if (!compute_matrix(t, h, s)) return false;
        renewed = true;
        size_before = 0;
      }
      const double size = correct(h, s);
      const Newton newton = assess(size, size_before, renewed);
      if (newton == Newton::solved) return true;
      if (newton == Newton::fails) return false;
      if (newton == Newton::stalls) matrix_step_ = 0;
      size_before = size;
    }
    return false;
  }

  // Applies one correction to xdot_ and the multipliers; returns its size.
  double correct(double h, const Weights& s) {
    rhs_.head(nv_) = Eigen::Map<const Vector>(r_.data() + nq_, nv_);
    for (int k = 0; k < m_; ++k) rhs_[nv_ + k] = r_[n_ + k] / weight(k, h, s);
    correction_ = lu_.solve(rhs_);
    double size = 0;
    position_change_ = s.position * h * h * correction_.head(nv_).lpNorm<Eigen::Infinity>();
    for (int k = 0; k < nv_; ++k) {
      xdot_[nq_ + k] -= correction_[k];
      size = std::max(size, h * std::abs(correction_[k]) / (1 + std::abs(x_[nq_ + k])));
    }
    for (int k = 0; k < m_; ++k) x_[n_ + k] -= correction_[nv_ + k];
    return correction_.allFinite() ? size : INFINITY;
  }

  // Weight of vdot+ in the quantity that constraint k holds: q, or v alone.
  double weight(int k, double h, const Weights& s) const {
    return system_.index(n_ + k) == 3 ? s.position * h * h : s.speed * h;
  }

  // d(rows of vdot and of the constraints)/d(vdot+, multipliers), the latter rows divided by the weight of vdot+ in q
  // (or in v), so that the condition number does not depend on the step (Bottasso, Bauchau & Cardona 2007). The
  // rotation of a displacement during the step, by an angle of the order of h, is neglected.
  bool compute_matrix(double t, double h, const Weights& s) {
    if (!system_.residual_jacobians(t, x_.data(), xdot_.data(), F_x_.data(), F_xdot_.data())) return false;
    N_ = -F_x_.block(0, nq_, nq_, nv_);
    auto speeds = A_.topLeftCorner(nv_, nv_);
    speeds.noalias() = s.position * h * h * F_x_.block(nq_, 0, nv_, nq_) * N_;
    speeds += F_xdot_.block(nq_, nq_, nv_, nv_) + s.speed * h * F_x_.block(nq_, nq_, nv_, nv_);
    A_.topRightCorner(nv_, m_) = F_x_.block(nq_, n_, nv_, m_);
    A_.bottomLeftCorner(m_, nv_).noalias() = F_x_.block(n_, 0, m_, nq_) * N_;
    for (int k = 0; k < m_; ++k) {
      if (system_.index(n_ + k) == 3) continue;
      A_.row(nv_ + k).head(nv_) *= s.position * h / s.speed;
      A_.row(nv_ + k).head(nv_) += F_x_.row(n_ + k).segment(nq_, nv_);
    }
    A_.bottomRightCorner(m_, m_).setZero();
    lu_.compute(A_);
    matrix_step_ = s.speed * h;
    return is_regular(lu_);
  }

  Coefficients c_;
  int nq_, nv_, m_;
  bool fresh_ = true;           // vdot_ and a_ are not those of the last step
  double position_change_ = 0;  // m or rad: change of q by the last correction
  double last_step_ = 0;        // s
  double matrix_step_ = 0;      // s: weight of vdot+ in v for which the matrix was computed; 0: there is none
  std::vector<double> x_, xdot_, r_;
  Vector dq_, vdot_, a_, q_fixed_, v_fixed_, a_fixed_;
  Matrix F_x_, F_xdot_, A_, N_;
  Vector rhs_, correction_;
  Eigen::PartialPivLU<Matrix> lu_;
};

}  // namespace

// rho: spectral radius at infinite frequency, the same for all eigenvalues there (Chung & Hulbert 1993, eq. 25).
std::unique_ptr<Integrator> make_generalized_alpha(Equations& system, const IntegratorOptions& options) {
  const double rho = options.rho_inf;
  return std::make_unique<GeneralizedAlpha>(system, options, Coefficients{(2 * rho - 1) / (rho + 1), rho / (rho + 1)});
}

// The parameter of the source is alpha = -alpha_f, from -1/3 to 0.
std::unique_ptr<Integrator> make_hht(Equations& system, const IntegratorOptions& options) {
  const double rho = options.rho_inf;
  return std::make_unique<GeneralizedAlpha>(system, options, Coefficients{0, (1 - rho) / (1 + rho)});
}

std::unique_ptr<Integrator> make_newmark(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<GeneralizedAlpha>(system, options, Coefficients{0, 0});
}

}  // namespace gelenk

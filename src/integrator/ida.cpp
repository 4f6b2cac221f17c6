// SPDX-License-Identifier: BSD-3-Clause
// BDF of variable order (SUNDIALS IDA; Hindmarsh et al. 2005). On 0 = ydot - f(t, y), projected within each step: when
// Newton's method has found the correction, the corrected state is put back on the constraints and what is left is
// handed to IDA as its correction. So the history that IDA extrapolates lies on the constraints too. On a DAE,
// F(t, x, xdot) = 0, with errors and Newton's equations scaled by the index.
#include <idas/idas.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "integrator/scaled_solver.h"
#include "integrator/sundials_integrator.h"

namespace gelenk {
namespace {

using NewtonSolve = int (*)(SUNNonlinearSolver, N_Vector, N_Vector, N_Vector, sunrealtype, sunbooleantype, void*);

// The local error test's share of a tolerance of 1e-4 (bdf_tolerance), such that what the steps leave adds up to some
// tens of times the tolerance, with all adaptive methods alike. Here: four-bar, arm with 7 joints, double pendulum,
// heavy top, squeezer and a change point, 0.03 to 5 s, tolerances 1e-4 to 1e-8: 1 to 90 times.
constexpr double local_fraction = 0.006;
// Below this differences of order six of the state's rounding are no small part of the error test: half of it costs an
// engine with six loops three times the steps.
constexpr double least_tolerance = 2e-13;

// Of the shortest time in which something changes by as much as it is: for a quotient of differences.
constexpr double quotient_fraction = 1e-6;
// Of the step whose error meets the tolerance, for the first one.
constexpr double first_share_of_error = 0.5;

// For a DAE:
constexpr double dae_share = 0.01;
// Newton's method leaves this share of the tolerance in q, hence of (tolerance / h) in speeds of index 3. With IDA's
// own 0.33 index3 errs some five times as much for as many evaluations (four-bar, 1e-4 to 1e-10).
constexpr double newton_share = 0.03;
// Newton's method has to reach its share above rounding.
constexpr double least_dae_tolerance = 1e-13;
constexpr double first_share = 1e-3;  // of the first step in the first communication step

class Ida final : public SundialsIntegrator {
 public:
  Ida(Equations& system, const IntegratorOptions& options)
      : SundialsIntegrator(system),
        n_(system.size()),
        dae_(system.multipliers() > 0),
        tolerance_(dae_ ? std::max(least_dae_tolerance, dae_share * options.tolerance)
                        : std::max(least_tolerance, bdf_tolerance(local_fraction, options.tolerance))),
        ydot_(sundials::new_vector(system, context_)),
        f_(system.unknowns()),
        by_rates_(f_.size() * f_.size()) {
    memory_ = sundials::made(IDACreate(context_));
    IDAInit(memory_, residual, 0, y_.get(), ydot_.get());
    IDASetUserData(memory_, this);
    if (dae_) {
      prepare_dae();
    } else {
      IDASStolerances(memory_, tolerance_, tolerance_);
      linear_ = std::make_unique<sundials::DenseSolver>(y_.get(), context_);
      IDASetLinearSolver(memory_, linear_->solver.get(), linear_->matrix.get());
    }
    IDASetJacFn(memory_, jacobian);
    IDASetMaxNumSteps(memory_, -1);
    IDASetMaxErrTestFails(memory_, most_error_fails);
    newton_ = sundials::made(SUNNonlinSol_Newton(y_.get(), context_));
    newton_solve_ = newton_->ops->solve;
    newton_->ops->solve = solve_and_project;
    IDASetNonlinearSolver(memory_, newton_);
  }
  ~Ida() override {
    IDAFree(&memory_);
    SUNNonlinSolFree(newton_);
  }

 private:
  double finest_tolerance() const override {
    return dae_ ? least_dae_tolerance / dae_share : tolerance_of_bdf(local_fraction, least_tolerance);
  }

  void prepare_dae() {
    IDAWFtolerances(memory_, weigh);
    IDASetNonlinConvCoef(memory_, newton_share);
    scaled_ = std::make_unique<sundials::ScaledSolver>(system_, memory_, context_);
    IDASetLinearSolver(memory_, scaled_->solver(), scaled_->matrix());
    // The solver's own scaling is what a changed cj asks for.
    IDASetLinearSolutionScaling(memory_, SUNFALSE);
  }

  // A jump of the inputs that the starter does not meet (started.cpp) does not begin anew: the scene is stiff, and the
  // history is worth keeping.
  void prepare(double end) override {
    if (fresh_) begin_anew(end);
    IDASetStopTime(memory_, end);
  }

  void begin_anew(double end) {
    double* x = sundials::data(y_.get());
    double* xdot = sundials::data(ydot_.get());
    if (!system_.consistent(t_, x, xdot)) refuse(system_, t_, x, "the accelerations are not finite");
    keep_counts();
    IDAReInit(memory_, t_, y_.get(), ydot_.get());
    first_step_ = dae_ ? first_step(end) : first_step_by_curvature(end);
    IDASetInitStep(memory_, first_step_);
    fresh_ = false;
  }

  // [s] Of an ODE; 0: IDA's own, which takes y by its rate to the tolerance and no further, and so is shorter by
  // 1/sqrt(tolerance): thirteen more steps, at least, until it is doubled often enough (1e-8). The first step, of order
  // 1, errs by half its square times yddot.
  double first_step_by_curvature(double end) {
    const double* y = sundials::data(y_.get());
    const double* ydot = sundials::data(ydot_.get());
    double rate = 1 / (end - t_);
    for (int i = 0; i < n_; ++i) rate = std::max(rate, std::abs(ydot[i]) / (1 + std::abs(y[i])));
    const double h = quotient_fraction / rate;
    for (int i = 0; i < n_; ++i) f_[i] = y[i] + h * ydot[i];
    if (!system_.rhs(t_ + h, f_.data(), by_rates_.data())) return 0;
    double most = 1 / ((end - t_) * (end - t_));
    for (int i = 0; i < n_; ++i) {
      most = std::max(most, std::abs(by_rates_[i] - ydot[i]) / h / (2 * tolerance_ * (1 + std::abs(y[i]))));
    }
    return first_share_of_error / std::sqrt(most);
  }

  // [s] Of a DAE: IDA's own, which is as short as the tolerance, leaves of multipliers of index 3 their rounding only.
  // The first step, of order 1, errs by half its square times the acceleration.
  double first_step(double end) const {
    const double* y = sundials::data(y_.get());
    const double* ydot = sundials::data(ydot_.get());
    double most = 0;
    for (int i = system_.coordinates(); i < n_; ++i) {
      most = std::max(most, std::abs(ydot[i]) / (tolerance_ * (1 + std::abs(y[i]))));
    }
    const double longest = first_share * (end - t_);
    return longest * longest * most > 1 ? 1 / std::sqrt(most) : longest;
  }

  Step make_step(double end) override {
    if (dae_) share_out_rest(end);
    const int flag = IDASolve(memory_, end, &t_, y_.get(), ydot_.get(), IDA_ONE_STEP);
    if (flag >= 0) return Step::made;
    if (flag == IDA_ERR_FAIL || flag == IDA_CONV_FAIL || flag == IDA_NLS_FAIL) return Step::too_small;
    const bool residual = flag == IDA_RES_FAIL || flag == IDA_REP_RES_ERR || flag == IDA_FIRST_RES_FAIL;
    return residual ? Step::not_finite : Step::stopped;
  }

  // A step cut very short at `end` would leave index-3 speeds and multipliers what Newton's method leaves of q over it.
  void share_out_rest(double end) {
    const double h = present_step();
    const double rest = end - t_;
    IDASetStopTime(memory_, h < rest && rest < 2 * h ? t_ + rest / 2 : end);
  }

  double reached() const override {
    double t = t_;
    IDAGetCurrentTime(memory_, &t);
    return t;
  }

  // s. Before the first step IDA tells that of the run before.
  double present_step() const {
    double h = 0;
    long steps = 0;
    IDAGetCurrentStep(memory_, &h);
    IDAGetNumSteps(memory_, &steps);
    return steps == 0 || h == 0 ? first_step_ : h;
  }

  // Errors of index p may be larger than the tolerance by h^(1-p) (Hairer, Lubich & Roche 1989). Multipliers are not
  // tested: those of index 3 err by O(1) wherever the step changes, though it does no harm to q and v, and with them in
  // the test one run of index3 in four stopped before its end (four-bar, slider-crank; 1e-4 to 1e-10).
  static int weigh(N_Vector y, N_Vector weights, void* self) {
    const Ida& ida = *static_cast<Ida*>(self);
    const double h = ida.present_step();
    const double* x = sundials::data(y);
    double* w = sundials::data(weights);
    std::fill_n(w, ida.system_.unknowns(), 0.0);
    for (int i = 0; i < ida.n_; ++i) {
      w[i] = std::pow(h, ida.system_.index(i) - 1) / (ida.tolerance_ * (1 + std::abs(x[i])));
    }
    return 0;
  }

  static int residual(sunrealtype t, N_Vector y, N_Vector ydot, N_Vector r, void* self) {
    Ida& ida = *static_cast<Ida*>(self);
    return ida.system_.residual(t, sundials::data(y), sundials::data(ydot), sundials::data(r)) ? 0 : 1;
  }

  static int jacobian(sunrealtype t, sunrealtype cj, N_Vector y, N_Vector ydot, N_Vector, SUNMatrix J, void* self,
                      N_Vector, N_Vector, N_Vector) {
    Ida& ida = *static_cast<Ida*>(self);
    double* columns = SUNDenseMatrix_Data(J);
    if (!ida.system_.residual_jacobians(t, sundials::data(y), sundials::data(ydot), columns, ida.by_rates_.data()))
      return 1;
    for (std::size_t i = 0; i < ida.by_rates_.size(); ++i) columns[i] += cj * ida.by_rates_[i];
    return 0;
  }

  static int solve_and_project(SUNNonlinearSolver solver, N_Vector y0, N_Vector correction, N_Vector weights,
                               sunrealtype tolerance, sunbooleantype setup, void* memory) {
    double t = 0;
    double cj = 0;
    N_Vector predicted = nullptr;
    N_Vector other = nullptr;
    void* self = nullptr;
    IDAGetNonlinearSystemData(memory, &t, &predicted, &other, &other, &other, &other, &cj, &self);
    Ida& ida = *static_cast<Ida*>(self);
    const int flag = ida.newton_solve_(solver, y0, correction, weights, tolerance, setup, memory);
    if (flag != SUN_SUCCESS) return flag;
    IDAGetNonlinearSystemData(memory, &t, &predicted, &other, &other, &other, &other, &cj, &self);
    const double* p = sundials::data(predicted);
    double* c = sundials::data(correction);
    for (int i = 0; i < ida.n_; ++i) ida.f_[i] = p[i] + c[i];
    if (!ida.system_.project(t, ida.f_.data())) return SUN_NLS_CONV_RECVR;
    for (int i = 0; i < ida.n_; ++i) c[i] = ida.f_[i] - p[i];
    return flag;
  }

  Counts count() override {
    long steps = 0;
    long error_fails = 0;
    long solver_fails = 0;
    IDAGetNumSteps(memory_, &steps);
    IDAGetNumErrTestFails(memory_, &error_fails);
    IDAGetNumNonlinSolvConvFails(memory_, &solver_fails);
    return {steps, error_fails + solver_fails};
  }

  int n_;  // of y; of a DAE the multipliers are behind it
  bool dae_;
  double tolerance_;
  double first_step_ = 0;  // s
  sundials::Vector ydot_;
  std::vector<double> f_, by_rates_;
  std::unique_ptr<sundials::DenseSolver> linear_;
  std::unique_ptr<sundials::ScaledSolver> scaled_;
  SUNNonlinearSolver newton_ = nullptr;
  NewtonSolve newton_solve_ = nullptr;
  void* memory_ = nullptr;
};

}  // namespace

std::unique_ptr<Integrator> make_ida(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Ida>(system, options);
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// BDF of variable order (SUNDIALS IDA; Hindmarsh et al. 2005) on 0 = ydot - f(t, y), projected within each step:
// when Newton's method has found the correction, the corrected state is put back on the constraints and what is
// left is handed to IDA as its correction. So the history that IDA extrapolates lies on the constraints too.
#include <idas/idas.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <vector>

#include "integrator/sundials_integrator.h"

namespace gelenk {
namespace {

using NewtonSolve = int (*)(SUNNonlinearSolver, N_Vector, N_Vector, N_Vector, sunrealtype, sunbooleantype, void*);

// The local error test's share of the tolerance, such that what the steps leave adds up to some tens of times the
// tolerance, with all adaptive methods alike. Here: four-bar, double pendulum, heavy top and parallelogram, 5 to 20 s,
// tolerances 1e-4 to 1e-8: 1 to 65 times, once 350.
constexpr double local_share = 0.01;
// Below this the weights of the error test are rounding.
constexpr double least_tolerance = 1e-13;

class Ida final : public SundialsIntegrator {
 public:
  Ida(OdeSystem& system, const IntegratorOptions& options)
      : SundialsIntegrator(system), ydot_(new_vector()), f_(n_), linear_(y_.get(), context_) {
    memory_ = sundials::made(IDACreate(context_));
    IDAInit(memory_, residual, 0, y_.get(), ydot_.get());
    IDASetUserData(memory_, this);
    const double tolerance = std::max(least_tolerance, local_share * options.tolerance);
    IDASStolerances(memory_, tolerance, tolerance);
    IDASetLinearSolver(memory_, linear_.solver.get(), linear_.matrix.get());
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
  // A jump of the inputs alone does not begin anew: on the four-bar with a new torque every millisecond a restart at
  // each costs more than twice as much as carrying the history on, and is less accurate.
  void prepare(double end) override {
    if (fresh_) begin();
    IDASetStopTime(memory_, end);
  }

  void begin() {
    if (!system_.rhs(t_, sundials::data(y_.get()), sundials::data(ydot_.get()))) {
      throw IntegrationError(at_time(t_) + "the accelerations are not finite");
    }
    keep_counts();
    IDAReInit(memory_, t_, y_.get(), ydot_.get());
    fresh_ = false;
  }

  Step make_step(double end) override {
    const int flag = IDASolve(memory_, end, &t_, y_.get(), ydot_.get(), IDA_ONE_STEP);
    if (flag >= 0) return Step::made;
    if (flag == IDA_ERR_FAIL || flag == IDA_CONV_FAIL || flag == IDA_NLS_FAIL) return Step::too_small;
    const bool residual = flag == IDA_RES_FAIL || flag == IDA_REP_RES_ERR || flag == IDA_FIRST_RES_FAIL;
    return residual ? Step::not_finite : Step::stopped;
  }

  double reached() const override {
    double t = t_;
    IDAGetCurrentTime(memory_, &t);
    return t;
  }

  static int residual(sunrealtype t, N_Vector y, N_Vector ydot, N_Vector r, void* self) {
    Ida& ida = *static_cast<Ida*>(self);
    if (!ida.system_.rhs(t, sundials::data(y), ida.f_.data())) return 1;
    const double* rate = sundials::data(ydot);
    double* out = sundials::data(r);
    for (int i = 0; i < ida.n_; ++i) out[i] = rate[i] - ida.f_[i];
    return 0;
  }

  // d residual/dy + cj d residual/d ydot = cj - df/dy.
  static int jacobian(sunrealtype t, sunrealtype cj, N_Vector y, N_Vector, N_Vector, SUNMatrix J, void* self, N_Vector,
                      N_Vector, N_Vector) {
    Ida& ida = *static_cast<Ida*>(self);
    double* columns = SUNDenseMatrix_Data(J);
    if (!ida.system_.jacobian(t, sundials::data(y), columns)) return 1;
    const int n = ida.n_;
    for (int i = 0; i < n * n; ++i) columns[i] = -columns[i];
    for (int i = 0; i < n; ++i) columns[i * n + i] += cj;
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

  void count() override {
    long error_fails = 0;
    long solver_fails = 0;
    IDAGetNumSteps(memory_, &steps_);
    IDAGetNumErrTestFails(memory_, &error_fails);
    IDAGetNumNonlinSolvConvFails(memory_, &solver_fails);
    rejected_ = error_fails + solver_fails;
    add_kept_counts();
  }

  sundials::Vector ydot_;
  std::vector<double> f_;
  sundials::DenseSolver linear_;
  SUNNonlinearSolver newton_ = nullptr;
  NewtonSolve newton_solve_ = nullptr;
  void* memory_ = nullptr;
};

}  // namespace

std::unique_ptr<Integrator> make_ida(OdeSystem& system, const IntegratorOptions& options) {
  return std::make_unique<Ida>(system, options);
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Ownership of SUNDIALS objects, and capture of their error messages.
#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <memory>
#include <new>
#include <span>
#include <string>

namespace gelenk::sundials {

// A SUNDIALS context that prints nothing and keeps the text of the last error.
class Context {
 public:
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  operator SUNContext() const { return context_; }
  const std::string& last_error() const { return last_error_; }

 private:
  static void keep(int line, const char* function, const char* file, const char* message, SUNErrCode code, void* self,
                   SUNContext context);
  SUNContext context_ = nullptr;
  std::string last_error_;
};

// A function that solves a nonlinear system (SUNNonlinSolSolve).
using NewtonSolve = int (*)(SUNNonlinearSolver, N_Vector, N_Vector, N_Vector, sunrealtype, sunbooleantype, void*);

struct DestroyVector {
  void operator()(N_Vector v) const { N_VDestroy(v); }
};
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, DestroyVector>;

struct DestroyMatrix {
  void operator()(SUNMatrix m) const { SUNMatDestroy(m); }
};
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, DestroyMatrix>;

struct DestroyLinearSolver {
  void operator()(SUNLinearSolver s) const { SUNLinSolFree(s); }
};
using LinearSolver = std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, DestroyLinearSolver>;

struct DestroyNonlinearSolver {
  void operator()(SUNNonlinearSolver s) const { SUNNonlinSolFree(s); }
};
using NonlinearSolver = std::unique_ptr<std::remove_pointer_t<SUNNonlinearSolver>, DestroyNonlinearSolver>;

inline double* data(N_Vector v) { return N_VGetArrayPointer(v); }

// Throws std::bad_alloc for null, which SUNDIALS returns only if memory allocation fails.
template <class T>
T* made(T* pointer) {
  if (pointer == nullptr) throw std::bad_alloc();
  return pointer;
}

// A dense linear solver for Newton's method, of the size of y.
struct DenseSolver {
  DenseSolver(N_Vector y, SUNContext context)
      : matrix(made(SUNDenseMatrix(N_VGetLength(y), N_VGetLength(y), context))),
        solver(made(SUNLinSol_Dense(y, matrix.get(), context))) {}

  Matrix matrix;
  LinearSolver solver;
};

}  // namespace gelenk::sundials

// SPDX-License-Identifier: BSD-3-Clause
// Ownership of SUNDIALS objects, and its errors as ours.
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

// A context that prints nothing and keeps the last error's text.
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

// SUNDIALS returns null only when memory is short.
template <class T>
T* made(T* pointer) {
  if (pointer == nullptr) throw std::bad_alloc();
  return pointer;
}

// What Newton's method solves its linear equations with; as many unknowns as y has.
struct DenseSolver {
  DenseSolver(N_Vector y, SUNContext context)
      : matrix(made(SUNDenseMatrix(N_VGetLength(y), N_VGetLength(y), context))),
        solver(made(SUNLinSol_Dense(y, matrix.get(), context))) {}

  Matrix matrix;
  LinearSolver solver;
};

}  // namespace gelenk::sundials

// SPDX-License-Identifier: BSD-3-Clause
// The archives of the sundials4py wheel were built for its Python module: when one of SUNDIALS' objects goes, they
// call these to free the table of Python callables that hangs on it. No object of ours has one, so there is
// nothing to free. Compiled only when that wheel is the SUNDIALS that CMake found.
#define GELENK_NOTHING_TO_FREE(name) \
  void name(void*);                  \
  void name(void*) {}

// NOLINTBEGIN(readability-identifier-naming): the names are SUNDIALS'.
extern "C" {
GELENK_NOTHING_TO_FREE(SUNContextFunctionTable_Destroy)
GELENK_NOTHING_TO_FREE(SUNDomEigEstimatorFunctionTable_Destroy)
GELENK_NOTHING_TO_FREE(SUNLinearSolverFunctionTable_Destroy)
GELENK_NOTHING_TO_FREE(SUNLoggerFunctionTable_Destroy)
GELENK_NOTHING_TO_FREE(SUNNonlinearSolverFunctionTable_Destroy)
GELENK_NOTHING_TO_FREE(SUNStepperFunctionTable_Destroy)
GELENK_NOTHING_TO_FREE(arkode_user_supplied_fn_table_destroy)
GELENK_NOTHING_TO_FREE(cvode_user_supplied_fn_table_destroy)
GELENK_NOTHING_TO_FREE(idas_user_supplied_fn_table_destroy)
GELENK_NOTHING_TO_FREE(kinsol_user_supplied_fn_table_destroy)
GELENK_NOTHING_TO_FREE(mristepinnerstepper_user_supplied_fn_table_destroy)
}
// NOLINTEND(readability-identifier-naming)

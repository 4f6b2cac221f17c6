// SPDX-License-Identifier: BSD-3-Clause
// The static libraries of the sundials4py wheel were built for its Python module: when a SUNDIALS object is destroyed,
// they call these functions to free its table of Python callables. Our objects have none, so there is nothing to free.
// Compiled only when CMake found SUNDIALS in that wheel.
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

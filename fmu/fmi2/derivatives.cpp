// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/derivatives.h"

#include "fmu/fmi2/adapter.h"

using gelenk::as_fmi2;

extern "C" {

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t nUnknown,
                                        const fmi2ValueReference known[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
  return as_fmi2(gelenk::get_directional_derivative(c, "fmi2GetDirectionalDerivative", {"unknowns", unknown, nUnknown},
                                                    {"knowns", known, nKnown}, {"dvKnown", dvKnown, nKnown},
                                                    {"dvUnknown", dvUnknown, nUnknown}));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
  return as_fmi2(gelenk::get_output_derivatives(c, "fmi2GetRealOutputDerivatives", {"value references", vr, nvr}, order,
                                                {"values", value, nvr}));
}

}  // extern "C"

// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/derivatives.h"

#include "fmu/fmi3/adapter.h"

using gelenk::as_fmi3;

extern "C" {

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
  return as_fmi3(gelenk::get_directional_derivative(instance, "fmi3GetDirectionalDerivative",
                                                    {"unknowns", unknowns, nUnknowns}, {"knowns", knowns, nKnowns},
                                                    {"seed", seed, nSeed}, {"sensitivity", sensitivity, nSensitivity}));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
  return as_fmi3(gelenk::get_adjoint_derivative(instance, "fmi3GetAdjointDerivative", {"unknowns", unknowns, nUnknowns},
                                                {"knowns", knowns, nKnowns}, {"seed", seed, nSeed},
                                                {"sensitivity", sensitivity, nSensitivity}));
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
  return as_fmi3(gelenk::get_output_derivatives(instance, "fmi3GetOutputDerivatives",
                                                {"value references", valueReferences, nValueReferences}, orders,
                                                {"values", values, nValues}));
}

}  // extern "C"

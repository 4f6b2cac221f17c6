// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/values.h"

#include "fmu/fmi2/adapter.h"

using gelenk::as_fmi2;

// Booleans are ints in FMI 2.0.
extern "C" {

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
  return as_fmi2(gelenk::get_values(c, {"fmi2GetReal", gelenk::reals, vr, nvr, nvr}, value));
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[]) {
  return as_fmi2(gelenk::get_values(c, {"fmi2GetInteger", gelenk::integers_and_enumerations, vr, nvr, nvr}, value));
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[]) {
  return as_fmi2(gelenk::get_values(c, {"fmi2GetBoolean", gelenk::booleans, vr, nvr, nvr}, value));
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t nvr, fmi2String /*value*/[]) {
  return as_fmi2(gelenk::refuse_type(c, "fmi2GetString", "String", nvr));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
  return as_fmi2(gelenk::set_values(c, {"fmi2SetReal", gelenk::reals, vr, nvr, nvr}, value));
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[]) {
  return as_fmi2(gelenk::set_values(c, {"fmi2SetInteger", gelenk::integers_and_enumerations, vr, nvr, nvr}, value));
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[]) {
  return as_fmi2(gelenk::set_values(c, {"fmi2SetBoolean", gelenk::booleans, vr, nvr, nvr}, value));
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
  return as_fmi2(
      gelenk::set_input_derivatives(c, {"fmi2SetRealInputDerivatives", gelenk::reals, vr, nvr, nvr}, order, value));
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t nvr, const fmi2String /*value*/[]) {
  return as_fmi2(gelenk::refuse_type(c, "fmi2SetString", "String", nvr));
}

}  // extern "C"

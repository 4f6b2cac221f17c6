// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/states.h"

#include "fmu/fmi2/adapter.h"

using gelenk::as_fmi2;

extern "C" {

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* FMUstate) {
  return as_fmi2(gelenk::get_state(c, "fmi2GetFMUstate", FMUstate));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
  return as_fmi2(gelenk::set_state(c, "fmi2SetFMUstate", FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* FMUstate) {
  return as_fmi2(gelenk::free_state(c, "fmi2FreeFMUstate", FMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t* size) {
  return as_fmi2(gelenk::get_serialized_size(c, "fmi2SerializedFMUstateSize", FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size) {
  return as_fmi2(gelenk::serialize_state(c, "fmi2SerializeFMUstate", FMUstate, serializedState, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate* FMUstate) {
  return as_fmi2(gelenk::deserialize_state(c, "fmi2DeSerializeFMUstate", serializedState, size, FMUstate));
}

}  // extern "C"

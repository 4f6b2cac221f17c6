// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/states.h"

#include "fmu/fmi3/adapter.h"

using gelenk::as_fmi3;

extern "C" {

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* FMUState) {
  return as_fmi3(gelenk::get_state(instance, "fmi3GetFMUState", FMUState));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState) {
  return as_fmi3(gelenk::set_state(instance, "fmi3SetFMUState", FMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* FMUState) {
  return as_fmi3(gelenk::free_state(instance, "fmi3FreeFMUState", FMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t* size) {
  return as_fmi3(gelenk::get_serialized_size(instance, "fmi3SerializedFMUStateSize", FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[],
                                 size_t size) {
  return as_fmi3(gelenk::serialize_state(instance, "fmi3SerializeFMUState", FMUState,
                                         reinterpret_cast<char*>(serializedState), size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState* FMUState) {
  return as_fmi3(gelenk::deserialize_state(instance, "fmi3DeserializeFMUState",
                                           reinterpret_cast<const char*>(serializedState), size, FMUState));
}

}  // extern "C"

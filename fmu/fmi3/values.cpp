// SPDX-License-Identifier: BSD-3-Clause
// Variables are Float64, Int32, Boolean and Enumeration, whose values are Int64.
#include "fmu/values.h"

#include "fmu/fmi3/adapter.h"

using gelenk::as_fmi3;
using gelenk::refuse_type;

extern "C" {

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues) {
  return as_fmi3(gelenk::get_values(
      instance, {"fmi3GetFloat64", gelenk::reals, valueReferences, nValueReferences, nValues}, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues) {
  return as_fmi3(gelenk::set_values(
      instance, {"fmi3SetFloat64", gelenk::reals, valueReferences, nValueReferences, nValues}, values));
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int32 values[], size_t nValues) {
  return as_fmi3(gelenk::get_values(
      instance, {"fmi3GetInt32", gelenk::integers, valueReferences, nValueReferences, nValues}, values));
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int32 values[], size_t nValues) {
  return as_fmi3(gelenk::set_values(
      instance, {"fmi3SetInt32", gelenk::integers, valueReferences, nValueReferences, nValues}, values));
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int64 values[], size_t nValues) {
  return as_fmi3(gelenk::get_values(
      instance, {"fmi3GetInt64", gelenk::enumerations, valueReferences, nValueReferences, nValues}, values));
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int64 values[], size_t nValues) {
  return as_fmi3(gelenk::set_values(
      instance, {"fmi3SetInt64", gelenk::enumerations, valueReferences, nValueReferences, nValues}, values));
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues) {
  return as_fmi3(gelenk::get_values(
      instance, {"fmi3GetBoolean", gelenk::booleans, valueReferences, nValueReferences, nValues}, values));
}

// Read as bytes: C callers may pass any number, and in C++ a bool has no others than 0 and 1.
fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Boolean values[], size_t nValues) {
  static_assert(sizeof(fmi3Boolean) == 1);
  return as_fmi3(gelenk::set_values(instance,
                                    {"fmi3SetBoolean", gelenk::booleans, valueReferences, nValueReferences, nValues},
                                    reinterpret_cast<const unsigned char*>(values)));
}

// No variable is of these types.
fmi3Status fmi3GetFloat32(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                          size_t nValueReferences, fmi3Float32 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetFloat32", "Float32", nValueReferences));
}

fmi3Status fmi3SetFloat32(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                          size_t nValueReferences, const fmi3Float32 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetFloat32", "Float32", nValueReferences));
}

fmi3Status fmi3GetInt8(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                       fmi3Int8 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetInt8", "Int8", nValueReferences));
}

fmi3Status fmi3SetInt8(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                       const fmi3Int8 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetInt8", "Int8", nValueReferences));
}

fmi3Status fmi3GetUInt8(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                        fmi3UInt8 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetUInt8", "UInt8", nValueReferences));
}

fmi3Status fmi3SetUInt8(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                        const fmi3UInt8 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetUInt8", "UInt8", nValueReferences));
}

fmi3Status fmi3GetInt16(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                        fmi3Int16 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetInt16", "Int16", nValueReferences));
}

fmi3Status fmi3SetInt16(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                        const fmi3Int16 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetInt16", "Int16", nValueReferences));
}

fmi3Status fmi3GetUInt16(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         fmi3UInt16 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetUInt16", "UInt16", nValueReferences));
}

fmi3Status fmi3SetUInt16(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         const fmi3UInt16 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetUInt16", "UInt16", nValueReferences));
}

fmi3Status fmi3GetUInt32(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         fmi3UInt32 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetUInt32", "UInt32", nValueReferences));
}

fmi3Status fmi3SetUInt32(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         const fmi3UInt32 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetUInt32", "UInt32", nValueReferences));
}

fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         fmi3UInt64 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetUInt64", "UInt64", nValueReferences));
}

fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         const fmi3UInt64 /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetUInt64", "UInt64", nValueReferences));
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         fmi3String /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetString", "String", nValueReferences));
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         const fmi3String /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetString", "String", nValueReferences));
}

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         size_t /*valueSizes*/[], fmi3Binary /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3GetBinary", "Binary", nValueReferences));
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                         const size_t /*valueSizes*/[], const fmi3Binary /*values*/[], size_t /*nValues*/) {
  return as_fmi3(refuse_type(instance, "fmi3SetBinary", "Binary", nValueReferences));
}

}  // extern "C"

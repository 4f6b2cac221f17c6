// SPDX-License-Identifier: BSD-3-Clause
// Clocks, which no FMU has.
#include "fmu/fmi3/adapter.h"
#include "fmu/values.h"

namespace gelenk {
namespace {

fmi3Status refuse_clocks(fmi3Instance instance, const char* function, std::size_t count) noexcept {
  return as_fmi3(refuse_type(instance, function, "Clock", count));
}

}  // namespace
}  // namespace gelenk

using gelenk::refuse_clocks;

extern "C" {

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                        fmi3Clock /*values*/[]) {
  return refuse_clocks(instance, "fmi3GetClock", nValueReferences);
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[], size_t nValueReferences,
                        const fmi3Clock /*values*/[]) {
  return refuse_clocks(instance, "fmi3SetClock", nValueReferences);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                                  size_t nValueReferences, fmi3Float64 /*intervals*/[],
                                  fmi3IntervalQualifier /*qualifiers*/[]) {
  return refuse_clocks(instance, "fmi3GetIntervalDecimal", nValueReferences);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                                   size_t nValueReferences, fmi3UInt64 /*counters*/[], fmi3UInt64 /*resolutions*/[],
                                   fmi3IntervalQualifier /*qualifiers*/[]) {
  return refuse_clocks(instance, "fmi3GetIntervalFraction", nValueReferences);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                               size_t nValueReferences, fmi3Float64 /*shifts*/[]) {
  return refuse_clocks(instance, "fmi3GetShiftDecimal", nValueReferences);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                                size_t nValueReferences, fmi3UInt64 /*counters*/[], fmi3UInt64 /*resolutions*/[]) {
  return refuse_clocks(instance, "fmi3GetShiftFraction", nValueReferences);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                                  size_t nValueReferences, const fmi3Float64 /*intervals*/[]) {
  return refuse_clocks(instance, "fmi3SetIntervalDecimal", nValueReferences);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                                   size_t nValueReferences, const fmi3UInt64 /*counters*/[],
                                   const fmi3UInt64 /*resolutions*/[]) {
  return refuse_clocks(instance, "fmi3SetIntervalFraction", nValueReferences);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                               size_t nValueReferences, const fmi3Float64 /*shifts*/[]) {
  return refuse_clocks(instance, "fmi3SetShiftDecimal", nValueReferences);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference /*valueReferences*/[],
                                size_t nValueReferences, const fmi3UInt64 /*counters*/[],
                                const fmi3UInt64 /*resolutions*/[]) {
  return refuse_clocks(instance, "fmi3SetShiftFraction", nValueReferences);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference /*clockReference*/,
                                      fmi3Float64 /*activationTime*/) {
  return refuse_clocks(instance, "fmi3ActivateModelPartition", 1);
}

}  // extern "C"

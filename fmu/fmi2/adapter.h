// SPDX-License-Identifier: BSD-3-Clause
// The status of FMI 2.0 for what all versions share.
#pragma once

#include "fmi2Functions.h"
#include "fmu/status.h"

namespace gelenk {

inline fmi2Status as_fmi2(Status status) noexcept { return static_cast<fmi2Status>(status); }

inline constexpr bool is_true(fmi2Boolean value) { return value != fmi2False; }
inline constexpr fmi2Boolean fmi2_boolean(bool value) { return value ? fmi2True : fmi2False; }

}  // namespace gelenk

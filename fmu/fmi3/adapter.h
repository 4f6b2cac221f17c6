// SPDX-License-Identifier: BSD-3-Clause
// The status of FMI 3.0 for what all versions share.
#pragma once

#include "fmi3Functions.h"
#include "fmu/status.h"

namespace gelenk {

inline fmi3Status as_fmi3(Status status) noexcept { return static_cast<fmi3Status>(status); }

}  // namespace gelenk

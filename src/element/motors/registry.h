// SPDX-License-Identifier: BSD-3-Clause
// The list of all motors. A new one requires a header and its name here.
#pragma once

#include <variant>

#include "element/motors/drive.h"

namespace gelenk {

struct AnyMotor : std::variant<Drive> {
  using variant::variant;
};

}  // namespace gelenk

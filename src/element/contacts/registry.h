// SPDX-License-Identifier: BSD-3-Clause
// The list of all contact laws. A new one requires a header and its name here.
#pragma once

#include <variant>

#include "element/contacts/surface_contact.h"

namespace gelenk {

struct AnyContact : std::variant<SurfaceContact> {
  using variant::variant;
};

}  // namespace gelenk

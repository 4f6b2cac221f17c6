// SPDX-License-Identifier: BSD-3-Clause
// Which shapes of a mechanism can touch each other.
#pragma once

#include "mechanism/mechanism.h"

namespace gelenk {

// The contact of the scene between two shapes; -1: they cannot touch.
int contact_between(const ContactTable& table, const LinkShape& a, const LinkShape& b);

}  // namespace gelenk

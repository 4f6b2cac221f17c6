// SPDX-License-Identifier: BSD-3-Clause
// Arguments that are places for results.
#pragma once

#include <initializer_list>

namespace gelenk {

struct Place {
  const char* name;
  const void* pointer;
};

// Throws UsageError for a place that is null.
void expect_places(std::initializer_list<Place> results);

}  // namespace gelenk

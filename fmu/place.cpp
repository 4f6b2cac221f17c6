// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/place.h"

#include <string>

#include "simulation/simulation.h"

namespace gelenk {

void expect_places(std::initializer_list<Place> results) {
  for (const Place& result : results) {
    if (result.pointer == nullptr)
      throw UsageError(std::string(result.name) + ": found a null pointer, expected a place for the result");
  }
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Settings: the values of all parameters of a scene, as numbers.
#pragma once

#include <cstdint>
#include <vector>

#include "modelDescription/catalog.h"
#include "util/archive.h"

namespace gelenk {

struct Settings {
  std::vector<double> values;             // of Catalog::parameters()
  std::vector<std::uint64_t> start_bits;  // per joint: flags of start values that are given, and that are fixed

  Settings(const Catalog& catalog, const Scene& scene);
  bool operator==(const Settings&) const = default;

  void serialize(Archive& archive) { archive.serialize(values, start_bits); }
  // Sets the parameters of a scene with the same elements. Throws std::invalid_argument for values out of range.
  void put(const Catalog& catalog, Scene& scene) const;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Settings: what the parameters of a scene are set to, as numbers.
#pragma once

#include <cstdint>
#include <vector>

#include "modelDescription/catalog.h"
#include "util/archive.h"

namespace gelenk {

struct Settings {
  std::vector<double> values;             // of Catalog::parameters()
  std::vector<std::uint64_t> start_bits;  // per joint: which of its start values are given, and which fixed

  Settings(const Catalog& catalog, const Scene& scene);
  bool operator==(const Settings&) const = default;

  void serialize(Archive& archive) { archive.serialize(values, start_bits); }
  // Into a scene with the same elements. Throws std::invalid_argument for values out of range.
  void put(const Catalog& catalog, Scene& scene) const;
};

}  // namespace gelenk

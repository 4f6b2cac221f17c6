// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/runtime/settings.h"

#include <array>

namespace gelenk {
namespace {

// The flags of a joint: at most 26, for 7 coordinates and 6 velocities.
template <class Start>
auto flags(Start& start) {
  return std::array{&start.q_given, &start.v_given, &start.q_fixed, &start.v_fixed};
}

std::uint64_t pack(const JointStart& start) {
  std::uint64_t bits = 0;
  for (const std::vector<bool>* of : flags(start)) {
    for (const bool flag : *of) bits = bits << 1U | (flag ? 1U : 0U);
  }
  return bits;
}

void unpack(std::uint64_t bits, JointStart& start) {
  const auto all = flags(start);
  for (auto of = all.rbegin(); of != all.rend(); ++of) {
    for (std::size_t i = (*of)->size(); i > 0; --i) {
      (**of)[i - 1] = (bits & 1U) != 0;
      bits >>= 1U;
    }
  }
}

}  // namespace

Settings::Settings(const Catalog& catalog, const Scene& scene) {
  values.reserve(catalog.parameters().size());
  for (const Parameter& parameter : catalog.parameters()) values.push_back(parameter.get(scene));
  start_bits.reserve(scene.joints.size());
  for (const Joint& joint : scene.joints) start_bits.push_back(pack(joint.start));
}

void Settings::put(const Catalog& catalog, Scene& scene) const {
  for (std::size_t i = 0; i < values.size(); ++i) set_parameter(scene, catalog.parameters()[i], values[i]);
  for (std::size_t j = 0; j < start_bits.size(); ++j) unpack(start_bits[j], scene.joints[j].start);
}

}  // namespace gelenk

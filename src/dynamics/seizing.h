// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// Friction of meshes that grows faster with its load than the motion can yield.
class Seizing {
 public:
  virtual ~Seizing() = default;
  // Of the last solve(): the index, among all forces with modes, of the only friction with loads that slips, if it is
  // that of a mesh and no motion agrees with it, so that it stops at once; -1: there is none.
  virtual int seized() const = 0;
};

}  // namespace gelenk

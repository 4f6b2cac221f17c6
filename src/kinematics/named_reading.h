// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kinematics/readings.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk {

// An output of a sensor that expressions name: it depends on positions and velocities alone.
class NamedReading {
 public:
  virtual ~NamedReading() = default;

  virtual double read(const Readings<double>& at) const = 0;
  virtual Dual read(const Readings<Dual>& at) const = 0;
  virtual Series read(const Readings<Series>& at) const = 0;
  // Marks the links of which it reads the poses.
  virtual void mark_links(std::vector<bool>& marked) const = 0;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// Locks of whole joints, which an input engages: by lock of a coordinate (switching_forces.h), of which one may have a
// part of them, a latch.
class Latches {
 public:
  // Whether an engaged latch holds the coordinate in the held modes; of this lock or of another one of the coordinate.
  virtual bool hold_coordinate(int lock) const = 0;
  // Of the latch of its coordinate, with the present inputs: above 0, engaged. 0 without one.
  virtual double engagement(int lock) const = 0;

 protected:
  virtual ~Latches() = default;
};

}  // namespace gelenk

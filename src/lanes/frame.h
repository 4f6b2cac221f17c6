// SPDX-License-Identifier: BSD-3-Clause
// The slots in which programs compute: those with a place of their own, and those of temporary values after them.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace gelenk::lanes {

class Frame {
 public:
  // The first of so many new slots, one after the other.
  int add(int count) {
    const int first = size_;
    size_ += count;
    return first;
  }
  // The slot of a constant.
  int constant(double value) {
    for (const auto& [slot, known] : constants_) {
      if (known == value) return slot;
    }
    constants_.emplace_back(add(1), value);
    return constants_.back().first;
  }
  // Programs use these temporary slots, of which values are lost when another program runs.
  void need_temporaries(int count) { temporaries_ = std::max(temporaries_, count); }

  int fixed() const { return size_; }
  int size() const { return size_ + temporaries_; }
  // Slots and their values.
  const std::vector<std::pair<int, double>>& constants() const { return constants_; }

 private:
  int size_ = 0, temporaries_ = 0;
  std::vector<std::pair<int, double>> constants_;
};

}  // namespace gelenk::lanes

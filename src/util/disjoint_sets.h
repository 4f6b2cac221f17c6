// SPDX-License-Identifier: BSD-3-Clause
// Union-find: disjoint sets of the numbers 0 ... n-1 (Tarjan 1975).
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace gelenk {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) { reset(n); }

  // Each number on its own. Allocates nothing for no more numbers than before.
  void reset(std::size_t n) {
    parent_.resize(n);
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  // The representative of the set of i.
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  // Merges the sets of i and k. Returns false if they were the same set.
  bool join(int i, int k) {
    const int a = find(i);
    const int b = find(k);
    parent_[a] = b;
    return a != b;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace gelenk

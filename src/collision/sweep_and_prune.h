// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shape/shape.h"

namespace gelenk {

// Finds the pairs of boxes that overlap: the broad phase of collision detection. Boxes are sorted along x, with the
// order of the previous call as a start, and swept within square columns along x. The columns are hashed, so that
// neither the extent of the scene nor a body far away costs anything. Boxes much larger than the others, half-spaces
// among them, are compared with all. The cost is linear in the number of boxes and pairs if few boxes are large.
class SweepAndPrune {
 public:
  // Indices of two boxes, i < j.
  struct Pair {
    int i, j;
    friend auto operator<=>(const Pair&, const Pair&) = default;
  };

  // Returns all pairs of overlapping boxes for which keep(i, j) is true, sorted by i and then j, until the next call.
  // Sides of boxes may be infinite; a box with a NaN overlaps nothing. The result depends on the boxes only, not on
  // earlier calls. Allocates only if there are more boxes or pairs than in any earlier call.
  template <class Keep>
  std::span<const Pair> pairs(std::span<const Aabb> boxes, const Keep& keep) {
    find(boxes);
    std::erase_if(pairs_, [&](const Pair& p) { return !keep(p.i, p.j); });
    return pairs_;
  }
  std::span<const Pair> pairs(std::span<const Aabb> boxes) {
    find(boxes);
    return pairs_;
  }

  // Number of pairs of boxes that the last call has compared.
  std::size_t comparisons() const { return comparisons_; }

 private:
  struct Entry {
    Aabb box;
    int index;
  };
  // Numbers of columns along y and z.
  struct Columns {
    std::int64_t first_y, last_y, first_z, last_z;
  };

  void find(std::span<const Aabb> boxes);
  void choose_width(std::span<const Aabb> boxes);
  bool is_large(const Aabb& box) const;
  void sort_along_x(std::span<const Aabb> boxes);
  void fill_columns(std::span<const Aabb> boxes);
  void sweep();
  void compare_large(std::span<const Aabb> boxes);
  void sort_pairs(std::size_t n);

  Columns columns(const Aabb& box) const;
  std::int64_t column(double x) const;
  std::size_t bucket(std::int64_t y, std::int64_t z) const;
  template <class Visit>
  void for_buckets(const Aabb& box, const Visit& visit) const;

  double width_ = 1;   // of a column [m]
  int half_bits_ = 1;  // half of the number of bits of a bucket's number
  std::vector<double> extents_, x_;
  std::vector<int> order_, large_;
  std::vector<unsigned char> is_large_;  // or without pairs
  std::vector<std::size_t> begin_;       // of the entries of a bucket
  std::vector<Entry> entries_;
  std::vector<Pair> pairs_, unsorted_;
  std::vector<std::size_t> begin_of_i_;
  std::size_t comparisons_ = 0;
};

}  // namespace gelenk

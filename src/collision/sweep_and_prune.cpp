// SPDX-License-Identifier: BSD-3-Clause
#include "collision/sweep_and_prune.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace gelenk {
namespace {

bool has_nan(const Aabb& box) { return box.lower.hasNaN() || box.upper.hasNaN(); }

double extent(const Aabb& box) { return (box.upper - box.lower).maxCoeff(); }

// Boxes of more than this number of column widths are large: they would be in too many columns.
constexpr double widest = 16;

// Up to this number of boxes, comparing all of them is faster than sorting them.
constexpr std::size_t few = 24;

}  // namespace

// Columns are twice as wide as the median of a sample of the boxes, so that most boxes are in one to four of them;
// wider if more than a fiftieth of the boxes were large.
void SweepAndPrune::choose_width(std::span<const Aabb> boxes) {
  constexpr std::size_t sample = 2048;
  const std::size_t stride = boxes.size() / sample + 1;
  extents_.clear();
  for (std::size_t i = 0; i < boxes.size(); i += stride)
    if (const double x = extent(boxes[i]); std::isfinite(x) && x > 0) extents_.push_back(x);
  if (extents_.empty()) return;
  const auto rank = [&](double fraction) {
    const auto place = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(extents_.size() - 1));
    std::nth_element(extents_.begin(), extents_.begin() + place, extents_.end());
    return extents_[static_cast<std::size_t>(place)];
  };
  width_ = std::max(2 * rank(0.5), rank(0.98) / widest);
}

bool SweepAndPrune::is_large(const Aabb& box) const { return !(extent(box) <= widest * width_); }

void SweepAndPrune::sort_along_x(std::span<const Aabb> boxes) {
  const auto n = static_cast<int>(boxes.size());
  x_.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) x_[i] = has_nan(boxes[i]) ? 0 : boxes[i].lower.x();
  if (order_.size() != boxes.size()) {
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0);
  }
  const auto before = [&](int i, int j) {
    const double a = x_[static_cast<std::size_t>(i)];
    const double b = x_[static_cast<std::size_t>(j)];
    return a < b || (a == b && i < j);
  };
  // Boxes that have moved little are sorted by a few exchanges each; otherwise from the start.
  const std::size_t budget = 16 * order_.size();
  std::size_t exchanges = 0;
  for (int k = 1; k < n && exchanges <= budget; ++k) {
    const int box = order_[static_cast<std::size_t>(k)];
    int at = k;
    for (; at > 0 && before(box, order_[static_cast<std::size_t>(at - 1)]) && exchanges <= budget; --at, ++exchanges)
      order_[static_cast<std::size_t>(at)] = order_[static_cast<std::size_t>(at - 1)];
    order_[static_cast<std::size_t>(at)] = box;
  }
  if (exchanges > budget) std::sort(order_.begin(), order_.end(), before);
}

std::int64_t SweepAndPrune::column(double x) const {
  constexpr double most = 1e15;  // columns; beyond it all are one
  return static_cast<std::int64_t>(std::floor(std::clamp(x / width_, -most, most)));
}

SweepAndPrune::Columns SweepAndPrune::columns(const Aabb& box) const {
  return {column(box.lower.y()), column(box.upper.y()), column(box.lower.z()), column(box.upper.z())};
}

std::size_t SweepAndPrune::bucket(std::int64_t y, std::int64_t z) const {
  // Columns side by side are neighbors in memory; those a period apart share a bucket.
  const auto mask = (std::uint64_t{1} << half_bits_) - 1;
  return static_cast<std::size_t>(((static_cast<std::uint64_t>(y) & mask) << half_bits_) |
                                  (static_cast<std::uint64_t>(z) & mask));
}

template <class Visit>
void SweepAndPrune::for_buckets(const Aabb& box, const Visit& visit) const {
  const Columns of = columns(box);
  for (std::int64_t y = of.first_y; y <= of.last_y; ++y)
    for (std::int64_t z = of.first_z; z <= of.last_z; ++z) visit(bucket(y, z));
}

// Entries of each bucket are in the order along x.
void SweepAndPrune::fill_columns(std::span<const Aabb> boxes) {
  std::fill(begin_.begin(), begin_.end(), 0);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (is_large_[i] == 0) for_buckets(boxes[i], [&](std::size_t b) { ++begin_[b]; });
  std::size_t sum = 0;
  for (std::size_t& begin : begin_) sum += std::exchange(begin, sum);
  entries_.resize(sum);
  for (const int i : order_) {
    if (is_large_[static_cast<std::size_t>(i)] != 0) continue;
    const Aabb& box = boxes[static_cast<std::size_t>(i)];
    for_buckets(box, [&](std::size_t b) { entries_[begin_[b]++] = {box, i}; });
  }
  // Each begin has become that of the next bucket.
  std::copy_backward(begin_.begin(), begin_.end() - 1, begin_.end());
  begin_[0] = 0;
}

void SweepAndPrune::sweep() {
  for (std::size_t b = 0; b + 1 < begin_.size(); ++b) {
    for (std::size_t k = begin_[b]; k < begin_[b + 1]; ++k) {
      const auto& [box, i] = entries_[k];
      for (std::size_t l = k + 1; l < begin_[b + 1] && entries_[l].box.lower.x() <= box.upper.x(); ++l) {
        ++comparisons_;
        const auto& [other, j] = entries_[l];
        if (i == j || !box.meets(other)) continue;
        // Of the columns that both share, the first one counts.
        const std::int64_t y = column(std::max(box.lower.y(), other.lower.y()));
        const std::int64_t z = column(std::max(box.lower.z(), other.lower.z()));
        if (bucket(y, z) == b) unsorted_.push_back({std::min(i, j), std::max(i, j)});
      }
    }
  }
}

void SweepAndPrune::compare_large(std::span<const Aabb> boxes) {
  const auto n = static_cast<int>(boxes.size());
  for (const int i : large_) {
    const Aabb& box = boxes[static_cast<std::size_t>(i)];
    for (int j = 0; j < n; ++j) {
      // Pairs of two large boxes once.
      if (i == j || (is_large_[static_cast<std::size_t>(j)] != 0 && j < i)) continue;
      ++comparisons_;
      if (box.meets(boxes[static_cast<std::size_t>(j)])) unsorted_.push_back({std::min(i, j), std::max(i, j)});
    }
  }
}

// Counting sort by i, then each group by j.
void SweepAndPrune::sort_pairs(std::size_t n) {
  begin_of_i_.assign(n + 1, 0);
  for (const Pair& p : unsorted_) ++begin_of_i_[static_cast<std::size_t>(p.i)];
  std::size_t sum = 0;
  for (std::size_t& begin : begin_of_i_) sum += std::exchange(begin, sum);
  pairs_.resize(unsorted_.size());
  for (const Pair& p : unsorted_) pairs_[begin_of_i_[static_cast<std::size_t>(p.i)]++] = p;
  auto from = pairs_.begin();
  for (std::size_t i = 0; i < n; ++i) {
    const auto to = pairs_.begin() + static_cast<std::ptrdiff_t>(begin_of_i_[i]);
    std::sort(from, to);
    from = to;
  }
  // Two columns that both boxes share can be in the same bucket.
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
}

void SweepAndPrune::find(std::span<const Aabb> boxes) {
  comparisons_ = 0;
  unsorted_.clear();
  large_.clear();
  const bool compares_all = boxes.size() <= few;
  if (compares_all) {
    const std::size_t all = boxes.size() * boxes.size() / 2;
    unsorted_.reserve(all);
    pairs_.reserve(all);
  } else {
    choose_width(boxes);
  }
  is_large_.assign(boxes.size(), 0);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    // A NaN would break the order; the box meets nothing.
    const bool none = has_nan(boxes[i]);
    if (!none && !compares_all && !is_large(boxes[i])) continue;
    is_large_[i] = 1;
    if (!none) large_.push_back(static_cast<int>(i));
  }
  if (large_.size() + 1 < boxes.size()) {
    half_bits_ = (std::bit_width(boxes.size()) + 1) / 2;
    begin_.resize((std::size_t{1} << (2 * half_bits_)) + 1);
    sort_along_x(boxes);
    fill_columns(boxes);
    sweep();
  }
  compare_large(boxes);
  sort_pairs(boxes.size());
}

}  // namespace gelenk

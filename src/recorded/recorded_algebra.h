// SPDX-License-Identifier: BSD-3-Clause
// The number that records, and matrices of it in the form in which the kernels write those of double.
#pragma once

#include <cstddef>
#include <vector>

#include "kinematics/kernels.h"
#include "math/planar.h"
#include "math/spatial.h"
#include "recording/recorded.h"
#include "recording/recorded_tape.h"

namespace gelenk {

using recording::Recorded;

// Rows as those of SparseFactor: the entries of velocity k with the velocities on its path from the root to itself.
struct FullMatrix {
  std::vector<std::vector<Recorded>> rows;
  std::vector<std::vector<int>> columns;  // ascending, the last one is k

  template <class A>
  explicit FullMatrix(const Model<A>& model) : rows(static_cast<std::size_t>(model.nv)), columns(rows.size()) {
    for (const auto& link : model.links) {
      std::vector<int> path;
      if (link.parent > 0) {
        const auto& inner = model.links[static_cast<std::size_t>(link.parent)];
        // Of a parent without velocities: those of the first ancestor with some.
        for (const auto* at = &inner;;) {
          if (at->nv > 0) {
            path = columns[static_cast<std::size_t>(at->iv + at->nv - 1)];
            break;
          }
          if (at->parent <= 0) break;
          at = &model.links[static_cast<std::size_t>(at->parent)];
        }
      }
      for (int k = link.iv; k < link.iv + link.nv; ++k) {
        path.push_back(k);
        columns[static_cast<std::size_t>(k)] = path;
        rows[static_cast<std::size_t>(k)].resize(path.size());
      }
    }
  }

  Recorded* row(int k) { return rows[static_cast<std::size_t>(k)].data(); }
  int depth(int k) const { return static_cast<int>(rows[static_cast<std::size_t>(k)].size()) - 1; }
};

// Rows as those of SparseRows, one after the other.
struct FullRows {
  std::vector<Recorded> all;
  std::vector<std::vector<int>> columns;  // by row
  std::vector<std::size_t> first;

  template <class A>
  explicit FullRows(const Model<A>& model) {
    std::size_t count = 0;
    for (const auto& cut : model.cuts) {
      std::vector<int> speeds;
      for (const std::vector<int>* path : {&cut.path_a, &cut.path_b}) {
        for (const int i : *path) {
          const auto& link = model.links[static_cast<std::size_t>(i)];
          for (int k = 0; k < link.nv; ++k) speeds.push_back(link.iv + k);
        }
      }
      for (int r = 0; r < cut.rows; ++r) {
        columns.push_back(speeds);
        first.push_back(count);
        count += speeds.size();
      }
    }
    all.resize(count);
  }

  Recorded* values(int row) { return all.data() + first[static_cast<std::size_t>(row)]; }
  int entries(int row) const { return static_cast<int>(columns[static_cast<std::size_t>(row)].size()); }
};

}  // namespace gelenk

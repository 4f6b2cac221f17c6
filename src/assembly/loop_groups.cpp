// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/loop_groups.h"

#include <algorithm>

#include "mechanism/mechanism.h"
#include "util/disjoint_sets.h"

namespace gelenk {

std::vector<int> velocities_between(const Mechanism& mechanism, const Cut& cut) {
  std::vector<int> out;
  for (const auto* path : {&cut.path_a, &cut.path_b}) {
    for (const int i : *path) {
      for (int k = 0; k < mechanism.links[i].nv; ++k) out.push_back(mechanism.links[i].iv + k);
    }
  }
  return out;
}

std::vector<LoopGroup> loop_groups(const Mechanism& mechanism) {
  const std::size_t n = mechanism.nv;
  // The joints of a loop, and of a coordinate row, belong together; so do the coordinates of one joint.
  DisjointSets sets(n + mechanism.cuts.size());
  std::vector<bool> moves(n, false);
  for (std::size_t c = 0; c < mechanism.cuts.size(); ++c) {
    for (const int k : velocities_between(mechanism, mechanism.cuts[c])) {
      sets.join(k, static_cast<int>(n + c));
      moves[k] = true;
    }
  }
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    for (const CoordinateRow::Term& term : row.terms) {
      sets.join(row.terms.front().v, term.v);
      moves[term.v] = true;
    }
  }
  for (const Link& link : mechanism.links) {
    const auto first = moves.begin() + link.iv;
    if (std::find(first, first + link.nv, true) == first + link.nv) continue;
    std::fill_n(first, link.nv, true);
    for (int k = 1; k < link.nv; ++k) sets.join(link.iv, link.iv + k);
  }
  std::vector<LoopGroup> out;
  std::vector<int> group_of(n + mechanism.cuts.size(), -1);  // by root
  const auto group = [&](int element) -> LoopGroup& {
    int& found = group_of[sets.find(element)];
    if (found < 0) {
      found = static_cast<int>(out.size());
      out.push_back({std::vector<bool>(n, false), std::vector<bool>(mechanism.cut_nv, false),
                     std::vector<bool>(mechanism.rows, false)});
    }
    return out[found];
  };
  for (int k = 0; k < mechanism.nv; ++k) {
    if (!moves[k]) continue;
    LoopGroup& of = group(k);
    of.velocities[k] = true;
    ++of.size;
  }
  for (std::size_t c = 0; c < mechanism.cuts.size(); ++c) {
    const Cut& cut = mechanism.cuts[c];
    LoopGroup& of = group(static_cast<int>(n + c));
    std::fill_n(of.cut_velocities.begin() + cut.iv, cut.nv, true);
    std::fill_n(of.rows.begin() + cut.first_row, cut.rows, true);
    of.size += cut.nv;
  }
  for (std::size_t i = 0; i < mechanism.coordinate_rows.size(); ++i) {
    const CoordinateRow& row = mechanism.coordinate_rows[i];
    if (!row.terms.empty())
      group(row.terms.front().v).rows[mechanism.first_coordinate_row() + static_cast<int>(i)] = true;
  }
  return out;
}

InitialGuess guesses_of(const InitialGuess& all, const std::vector<bool>& own, double largest_weight,
                        bool hold_others) {
  InitialGuess out = all;
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (own[k]) {
      out.q_weight[k] /= largest_weight;
      continue;
    }
    out.q_weight[k] = 0;
    out.q_given[k] = false;
    out.q_fixed[k] = hold_others;
  }
  return out;
}

double largest_weight(const LoopGroup& group, const InitialGuess& tree, const InitialGuess& cuts) {
  double out = 0;
  const auto add = [&](const InitialGuess& guesses, const std::vector<bool>& own) {
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (own[k] && !guesses.q_fixed[k]) out = std::max(out, guesses.q_weight[k]);
    }
  };
  add(tree, group.velocities);
  add(cuts, group.cut_velocities);
  return out > 0 ? out : 1;
}

}  // namespace gelenk

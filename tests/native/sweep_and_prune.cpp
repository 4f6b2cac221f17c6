// SPDX-License-Identifier: BSD-3-Clause
#include "collision/sweep_and_prune.h"

#include <nanobind/ndarray.h>

#include "units.h"

namespace nb = nanobind;

namespace native {
namespace {

using Rows = nb::ndarray<const double, nb::shape<-1, 6>, nb::c_contig>;
using Groups = std::vector<int>;

std::vector<gelenk::Aabb> boxes(const Rows& rows) {
  std::vector<gelenk::Aabb> out;
  for (std::size_t i = 0; i < rows.shape(0); ++i) {
    const double* row = rows.data() + 6 * i;
    out.push_back({{row[0], row[1], row[2]}, {row[3], row[4], row[5]}});
  }
  return out;
}

// groups: pairs of the same group other than 0 are left out; empty: none.
std::vector<std::pair<int, int>> pairs(gelenk::SweepAndPrune& of, const Rows& rows, const Groups& groups) {
  const std::vector<gelenk::Aabb> all = boxes(rows);
  const auto keep = [&](int i, int j) {
    const int group = groups.at(static_cast<std::size_t>(i));
    return group == 0 || group != groups.at(static_cast<std::size_t>(j));
  };
  std::vector<std::pair<int, int>> out;
  for (const auto& [i, j] : groups.empty() ? of.pairs(all) : of.pairs(all, keep)) out.emplace_back(i, j);
  return out;
}

}  // namespace

// Rows of 6 numbers: lower and upper corner.
void bind_sweep_and_prune(nb::module_& m) {
  nb::class_<gelenk::SweepAndPrune>(m, "SweepAndPrune")
      .def(nb::init<>())
      .def("pairs", pairs, nb::arg("boxes"), nb::arg("groups") = Groups())
      .def("comparisons", &gelenk::SweepAndPrune::comparisons);
}

}  // namespace native

// SPDX-License-Identifier: BSD-3-Clause
#include "collision/contacts.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <limits>

#include "shapes.h"

namespace nb = nanobind;

namespace native {
namespace {

using Contact = std::tuple<Numbers, Numbers, double, int>;  // p, normal, gap, feature

std::vector<Contact> contacts(const gelenk::AnyShape& A, const Numbers& X_A, const gelenk::AnyShape& B,
                              const Numbers& X_B, double margin) {
  std::array<gelenk::ContactPoint, gelenk::max_contact_points> found;
  const int n = gelenk::find_contacts(A, pose(X_A), B, pose(X_B), margin, found.data());
  std::vector<Contact> out;
  for (int i = 0; i < n; ++i) {
    const gelenk::ContactPoint& c = found[static_cast<std::size_t>(i)];
    out.emplace_back(numbers(c.p), numbers(c.normal), c.gap, c.feature);
  }
  return out;
}

using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig>;

// Rows of 24 numbers: poses of A and B. Returns the smallest gap of each; infinite without contact points.
Numbers gaps(const gelenk::AnyShape& A, const gelenk::AnyShape& B, Rows poses, double margin) {
  Numbers out;
  for (std::size_t i = 0; i < poses.shape(0); ++i) {
    const double* row = poses.data() + 24 * i;
    double least = std::numeric_limits<double>::infinity();
    for (const Contact& c : contacts(A, Numbers(row, row + 12), B, Numbers(row + 12, row + 24), margin))
      least = std::min(least, std::get<2>(c));
    out.push_back(least);
  }
  return out;
}

}  // namespace

void bind_contacts(nb::module_& m) {
  m.def("contacts", contacts);
  m.def("gaps", gaps);
}

}  // namespace native

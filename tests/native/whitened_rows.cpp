// SPDX-License-Identifier: BSD-3-Clause
// The choice between the factorizations of the constraint Jacobian, with arbitrary mass matrices, through a fictitious
// algebra.
#include "dynamics/mass_weighted_jacobian.h"

#include <memory>

#include "units.h"

namespace native {
struct Given {};
}  // namespace native

namespace gelenk {

// The interface that MassWeightedJacobian requires of a mass matrix, implemented by its factor.
template <>
class MassFactor<native::Given> {
 public:
  explicit MassFactor(std::vector<int> parent) : factor(parent), parent_(std::move(parent)) {}
  std::vector<int> inwards(const int* speeds, int count) const {
    std::set<int> out;
    for (const int* speed = speeds; speed != speeds + count; ++speed) {
      for (int k = *speed; k >= 0 && out.insert(k).second; k = parent_[k]) continue;
    }
    return {out.begin(), out.end()};
  }
  void solve_transposed(double* x, const std::vector<int>& speeds) const { factor.solve_transposed(x, speeds); }

  SparseFactor factor;

 private:
  std::vector<int> parent_;
};

}  // namespace gelenk

namespace nb = nanobind;

namespace native {
namespace {

using Whitened = gelenk::MassWeightedJacobian<Given>;

// Gives access to a private member: access is not checked in explicit template instantiations.
bool by_pattern(const Whitened& rows);
template <bool Whitened::* member>
struct Access {
  friend bool by_pattern(const Whitened& rows) { return rows.*member; }
};
template struct Access<&Whitened::by_pattern_>;

struct Rows {
  Rows(std::vector<int> parent, const std::vector<std::vector<int>>& touched) : mass(std::move(parent)) {
    for (const std::vector<int>& speeds : touched) J.append(speeds);
    whitened = std::make_unique<Whitened>(mass, J, mass.factor.size());
  }

  gelenk::MassFactor<Given> mass;
  gelenk::SparseRows J;
  std::unique_ptr<Whitened> whitened;
};

}  // namespace

void bind_whitened_rows(nb::module_& m) {
  nb::class_<Rows>(m, "WhitenedRows")
      .def(nb::init<std::vector<int>, std::vector<std::vector<int>>>())
      .def("factorize",
           [](Rows& rows, const Table& M, const Table& J, int max_rank) {
             gelenk::SparseFactor& L = rows.mass.factor;
             for (int i = 0; i < L.size(); ++i) {
               for (int d = 0; d <= L.depth(i); ++d) L.row(i)[d] = M[i][L.ancestors(i)[d]];
             }
             if (L.factorize() >= 0) throw std::runtime_error("no mass");
             for (int r = 0; r < rows.J.rows(); ++r) {
               for (int k = 0; k < rows.J.entries(r); ++k) rows.J.values(r)[k] = J[r][rows.J.columns(r)[k]];
             }
             rows.whitened->factorize(max_rank);
           })
      .def_prop_ro("by_pattern", [](const Rows& rows) { return by_pattern(*rows.whitened); })
      .def_prop_ro("rank", [](const Rows& rows) { return rows.whitened->rank(); })
      .def("solve", [](const Rows& rows, Numbers w, const Numbers& gamma) {
        rows.whitened->solve_constrained(w.data(), gamma.data(), nullptr);
        Numbers lambda(rows.J.rows());
        rows.whitened->multipliers(lambda.data());
        return std::pair(w, lambda);
      });
}

}  // namespace native

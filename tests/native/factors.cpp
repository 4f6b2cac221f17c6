// SPDX-License-Identifier: BSD-3-Clause
// The factorizations of the constraint Jacobian and of the mass matrix. Matrices are lists of columns or rows.
#include <algorithm>

#include "linear/row_factor.h"
#include "linear/sparse_factor.h"
#include "linear/sparse_row_factor.h"
#include "units.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace native {
namespace {

// The members common to both factorizations of the constraint Jacobian.
template <class Factor>
void bind_answers(nb::class_<Factor>& c) {
  c.def_prop_ro("rank", &Factor::rank)
      .def_prop_ro("pivot_ratio", &Factor::pivot_ratio)
      .def("set_weak", &Factor::set_singular_threshold)
      .def(
          "constrain",
          [](const Factor& f, Numbers w, const Numbers& gamma, const std::optional<Numbers>& expected) {
            f.solve_constrained(w.data(), gamma.data(), expected ? expected->data() : nullptr);
            return w;
          },
          "w"_a, "gamma"_a, "expected"_a.none() = nb::none())
      .def("constrain_columns",
           [](const Factor& f, Numbers w, const Numbers& gamma, int columns, bool follows) {
             f.solve_constrained(w.data(), gamma.data(), columns, follows);
             return w;
           })
      .def("multipliers",
           [](const Factor& f, int rows) {
             Numbers out(rows);
             f.multipliers(out.data());
             return out;
           })
      .def("shortest", [](const Factor& f, const Numbers& residual, int speeds) {
        Numbers out(speeds);
        f.min_norm(residual.data(), out.data());
        return out;
      });
}

}  // namespace

void bind_factors(nb::module_& m) {
  using gelenk::RowFactor;
  using gelenk::SparseFactor;
  using gelenk::SparseRowFactor;

  auto dense = nb::class_<RowFactor>(m, "RowFactor").def(nb::init<int, int>());
  dense.def("factorize", [](RowFactor& f, const Table& columns, int max_rank) {
    for (std::size_t r = 0; r < columns.size(); ++r) std::ranges::copy(columns[r], f.column(static_cast<int>(r)));
    f.factorize(max_rank);
  });
  bind_answers(dense);

  auto sparse = nb::class_<SparseRowFactor>(m, "SparseRowFactor").def(nb::init<int, std::vector<std::vector<int>>>());
  sparse.def_prop_ro("possible", &SparseRowFactor::is_applicable)
      .def("factorize", [](SparseRowFactor& f, const Table& columns) {
        f.begin();
        return std::ranges::all_of(f.blocks(), [&](const SparseRowFactor::Block& block) {
          for (std::size_t i = 0; i < block.size(); ++i) {
            double* to = f.work(static_cast<int>(i));
            const Numbers& column = columns[block[i]];
            for (std::size_t k = 0; k < column.size(); ++k) {
              if (column[k] != 0) to[k] = column[k];
            }
          }
          return f.append(block);
        });
      });
  bind_answers(sparse);

  nb::class_<SparseFactor>(m, "SparseFactor")
      .def(nb::init<std::vector<int>>())
      .def("factorize",
           [](SparseFactor& f, const Table& M) {
             for (int i = 0; i < f.size(); ++i) {
               for (int d = 0; d <= f.depth(i); ++d) f.row(i)[d] = M[i][f.ancestors(i)[d]];
             }
             return f.factorize();
           })
      .def("factor",
           [](const SparseFactor& f) {
             Table L(f.size(), Numbers(f.size()));
             for (int i = 0; i < f.size(); ++i) {
               for (int d = 0; d <= f.depth(i); ++d) L[i][f.ancestors(i)[d]] = f.row(i)[d];
             }
             return L;
           })
      .def("null_motion",
           [](const SparseFactor& f, int k) {
             Numbers z(f.size());
             f.null_motion(k, z.data());
             return z;
           })
      .def("solve_transposed",
           [](const SparseFactor& f, Numbers x) {
             f.solve_transposed(x.data());
             return x;
           })
      .def("solve",
           [](const SparseFactor& f, Numbers x) {
             f.solve(x.data());
             return x;
           })
      .def("multiply",
           [](const SparseFactor& f, const Numbers& x) {
             Numbers y(x.size());
             f.multiply(x.data(), y.data());
             return y;
           })
      .def("solve_transposed_columns",
           [](const SparseFactor& f, Numbers x, int columns) {
             f.solve_transposed(x.data(), columns);
             return x;
           })
      .def("solve_columns", [](const SparseFactor& f, Numbers x, int columns) {
        f.solve(x.data(), columns);
        return x;
      });
}

}  // namespace native

// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/cone.h"

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "complementarity/independent_parts.h"
#include "complementarity/projection.h"
#include "units.h"

namespace nb = nanobind;

namespace native {
namespace {

using gelenk::Cone;

// A matrix that does not show itself.
class Hidden final : public gelenk::ConeOperator {
 public:
  explicit Hidden(const Eigen::MatrixXd& G) : shown_(G) {}
  int size() const override { return shown_.size(); }
  void apply(const double* x, double* y) const override { shown_.apply(x, y); }
  void diagonal_block(const Cone& cone, double* out) const override { shown_.diagonal_block(cone, out); }

 private:
  gelenk::DenseConeOperator shown_;
};

// G = W^T W, of which only W shows. W is stored by columns, without its zeros.
class Rooted final : public gelenk::ConeOperator {
 public:
  // columns: of W, one for each unknown.
  explicit Rooted(const Table& columns) {
    for (const Numbers& column : columns) {
      rows_ = static_cast<int>(column.size());
      for (int i = 0; i < rows_; ++i) {
        const double entry = column[static_cast<std::size_t>(i)];
        if (entry == 0) continue;
        row_.push_back(i);
        value_.push_back(entry);
      }
      first_.push_back(static_cast<int>(row_.size()));
    }
  }
  int size() const override { return static_cast<int>(first_.size()) - 1; }
  void apply(const double* x, double* y) const override {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(rows_);
    for (int j = 0; j < size(); ++j) {
      for (std::size_t k = begin(j); k < begin(j + 1); ++k) w[row_[k]] += value_[k] * x[j];
    }
    for (int j = 0; j < size(); ++j) {
      y[j] = 0;
      for (std::size_t k = begin(j); k < begin(j + 1); ++k) y[j] += value_[k] * w[row_[k]];
    }
  }
  void diagonal_block(const Cone& cone, double* out) const override {
    for (int i = 0; i < cone.size(); ++i) {
      for (int j = 0; j < cone.size(); ++j) *out++ = dot(cone.first + i, cone.first + j);
    }
  }
  gelenk::ConeRoot root() const override { return {rows_, first_, row_, value_}; }

 private:
  std::size_t begin(int j) const { return static_cast<std::size_t>(first_[static_cast<std::size_t>(j)]); }
  double dot(int i, int j) const {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(rows_);
    for (std::size_t k = begin(i); k < begin(i + 1); ++k) w[row_[k]] = value_[k];
    double sum = 0;
    for (std::size_t k = begin(j); k < begin(j + 1); ++k) sum += value_[k] * w[row_[k]];
    return sum;
  }

  int rows_ = 0;
  std::vector<int> first_{0}, row_;
  std::vector<double> value_;
};

class Solved {
 public:
  Numbers x;
  gelenk::ConeResult result;
  long allocations = 0;  // during the solution
};

// A solver, of independent parts one by one if asked to, and the options of its calls.
class Solver {
 public:
  Solver(const std::string& name, bool in_parts) : solver_(gelenk::make_cone_solver(name)) {
    if (in_parts) solver_ = std::make_unique<gelenk::IndependentParts>(std::move(solver_));
  }

  Solved solve(const Table& rows, const Numbers& b, const std::vector<Cone>& cones, const Numbers& start,
               double tolerance, int max_iterations, bool exact, bool matrix_free) {
    const auto n = static_cast<Eigen::Index>(rows.size());
    Eigen::MatrixXd G(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      G.row(i) = Eigen::Map<const Eigen::RowVectorXd>(rows[static_cast<std::size_t>(i)].data(), n);
    }
    const gelenk::DenseConeOperator dense(G);
    const Hidden hidden(G);
    const gelenk::ConeOperator& chosen = matrix_free ? static_cast<const gelenk::ConeOperator&>(hidden) : dense;
    return call(chosen, b, cones, start, tolerance, max_iterations, exact);
  }

  Solved solve_root(const Table& columns, const Numbers& b, const std::vector<Cone>& cones, const Numbers& start,
                    double tolerance, int max_iterations, bool exact) {
    return call(Rooted(columns), b, cones, start, tolerance, max_iterations, exact);
  }

 private:
  Solved call(const gelenk::ConeOperator& chosen, const Numbers& b, const std::vector<Cone>& cones,
              const Numbers& start, double tolerance, int max_iterations, bool exact) {
    Solved out;
    out.x = start;
    gelenk::ConeOptions options;
    options.tolerance = tolerance;
    options.max_iterations = max_iterations;
    const long before = native::allocations();
    out.result = solver_->solve({chosen, b, cones, exact}, options, out.x.data());
    out.allocations = native::allocations() - before;
    return out;
  }

  std::unique_ptr<gelenk::ConeSolver> solver_;
};

}  // namespace

void bind_cones(nb::module_& m) {
  nb::class_<Cone>(m, "Cone")
      .def_static("contact", &Cone::contact, nb::arg("first"), nb::arg("friction"), nb::arg("spinning") = 0.0,
                  nb::arg("rolling") = 0.0)
      .def_static("planar_contact", &Cone::planar_contact, nb::arg("first"), nb::arg("friction"),
                  nb::arg("rolling") = 0.0)
      .def_static("within", &Cone::within, nb::arg("first"), nb::arg("lower"), nb::arg("upper"))
      .def_static("ball", &Cone::ball, nb::arg("first"), nb::arg("size"), nb::arg("radius"))
      .def_rw("tangential", &Cone::tangential)
      .def_rw("spin", &Cone::spin)
      .def_rw("roll", &Cone::roll)
      .def_ro("first", &Cone::first)
      .def_prop_ro("size", &Cone::size)
      .def("project",
           [](const Cone& cone, const Numbers& y) {
             Numbers out(y.size());
             gelenk::project(cone, y.data(), out.data());
             return out;
           })
      .def("projection_jacobian", [](const Cone& cone, const Numbers& y) {
        Numbers out(y.size() * y.size());
        gelenk::projection_jacobian(cone, y.data(), out.data());
        return out;
      });
  nb::class_<Solved>(m, "SolvedCones")
      .def_ro("x", &Solved::x)
      .def_prop_ro("residual", [](const Solved& of) { return of.result.residual; })
      .def_prop_ro("iterations", [](const Solved& of) { return of.result.iterations; })
      .def_prop_ro("products", [](const Solved& of) { return of.result.products; })
      .def_prop_ro("converged", [](const Solved& of) { return of.result.converged; })
      .def_ro("allocations", &Solved::allocations);
  nb::class_<Solver>(m, "ConeSolver")
      .def(nb::init<const std::string&, bool>(), nb::arg("name"), nb::arg("in_parts") = false)
      .def("solve", &Solver::solve, nb::arg("G"), nb::arg("b"), nb::arg("cones"), nb::arg("start"),
           nb::arg("tolerance") = 1e-10, nb::arg("max_iterations") = 1000, nb::arg("exact") = true,
           nb::arg("matrix_free") = false)
      .def("solve_root", &Solver::solve_root, nb::arg("columns"), nb::arg("b"), nb::arg("cones"), nb::arg("start"),
           nb::arg("tolerance") = 1e-10, nb::arg("max_iterations") = 1000, nb::arg("exact") = true);
  m.def("cone_solvers", [] {
    std::vector<std::pair<std::string, std::string>> out;
    for (const gelenk::ConeSolverKind& kind : gelenk::cone_solver_kinds()) out.emplace_back(kind.name, kind.summary);
    return out;
  });
}

}  // namespace native

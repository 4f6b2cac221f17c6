// SPDX-License-Identifier: BSD-3-Clause
// Cone complementarity problems and their solvers (src/cone), for charts.
#include "cone/cone.h"

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.h"

namespace nb = nanobind;

namespace gelenk {
namespace {

using Clock = std::chrono::steady_clock;
using History = std::vector<std::tuple<int, double, double>>;  // products, seconds, residual

class Recorder final : public ConeObserver {
 public:
  void reached(const ConeResult& so_far) override {
    const std::chrono::duration<double> time = Clock::now() - start_;
    history_.emplace_back(so_far.products, time.count(), so_far.residual);
  }
  const History& history() const { return history_; }

 private:
  Clock::time_point start_ = Clock::now();
  History history_;
};

struct Solution {
  Eigen::VectorXd x;
  ConeResult result;
  History history;
};

Solution solve_cones(const Eigen::MatrixXd& G, const Eigen::VectorXd& b, const std::vector<Cone>& cones,
                     const std::string& solver, double tolerance, int max_iterations, bool exact_coulomb,
                     const Eigen::VectorXd& start) {
  if (G.rows() != G.cols()) throw nb::value_error("G: expected a square matrix");
  if (start.size() != 0 && start.size() != G.rows())
    throw nb::value_error("start: expected one number for each row of G");
  for (const ConeSolverKind& kind : cone_solver_kinds()) {
    if (kind.name != solver) continue;
    const DenseConeOperator matrix(G);
    Solution out;
    out.x = start.size() == 0 ? Eigen::VectorXd::Zero(G.rows()) : start;
    Recorder recorder;
    ConeOptions options;
    options.tolerance = tolerance;
    options.max_iterations = max_iterations;
    options.observer = &recorder;
    const std::span<const double> velocities(b.data(), static_cast<std::size_t>(b.size()));
    out.result = kind.make()->solve({matrix, velocities, cones, exact_coulomb}, options, out.x.data());
    out.history = recorder.history();
    return out;
  }
  throw nb::value_error(("no cone solver is called '" + solver + "'").c_str());
}

}  // namespace

void bind_cones(nb::module_& m) {
  nb::class_<Cone>(m, "Cone")
      .def_static("contact", &Cone::contact, nb::arg("first"), nb::arg("friction"), nb::arg("spinning") = 0.0,
                  nb::arg("rolling") = 0.0)
      .def_static("planar_contact", &Cone::planar_contact, nb::arg("first"), nb::arg("friction"),
                  nb::arg("rolling") = 0.0)
      .def_static("within", &Cone::within, nb::arg("first"), nb::arg("lower"), nb::arg("upper"))
      .def_ro("first", &Cone::first)
      .def_prop_ro("size", &Cone::size)
      // Also those of a group whose coefficient is 0.
      .def_rw("tangential", &Cone::tangential);
  nb::class_<Solution>(m, "ConeSolution")
      .def_ro("x", &Solution::x)
      .def_prop_ro("residual", [](const Solution& of) { return of.result.residual; })
      .def_prop_ro("iterations", [](const Solution& of) { return of.result.iterations; })
      .def_prop_ro("products", [](const Solution& of) { return of.result.products; })
      .def_prop_ro("converged", [](const Solution& of) { return of.result.converged; })
      .def_ro("history", &Solution::history);
  m.def("solve_cones", &solve_cones, nb::arg("G"), nb::arg("b"), nb::arg("cones"), nb::arg("solver") = "hybrid",
        nb::arg("tolerance") = 1e-10, nb::arg("max_iterations") = 1000, nb::arg("exact_coulomb") = true,
        nb::arg("start") = Eigen::VectorXd());
  m.def("cone_solvers", [] {
    std::vector<std::pair<std::string, std::string>> out;
    for (const ConeSolverKind& kind : cone_solver_kinds()) out.emplace_back(kind.name, kind.summary);
    return out;
  });
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Cone complementarity problems and their solvers (src/cone), for charts.
#include "complementarity/cone.h"

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.h"
#include "time_stepping/recorded_problem.h"

namespace nb = nanobind;

namespace gelenk {
namespace {

using SteadyClock = std::chrono::steady_clock;
using History = std::vector<std::tuple<int, double, double>>;  // products, seconds, residual

class Recorder final : public ConeObserver {
 public:
  void reached(const ConeResult& so_far) override {
    const std::chrono::duration<double> time = SteadyClock::now() - start_;
    history_.emplace_back(so_far.products, time.count(), so_far.residual);
  }
  const History& history() const { return history_; }

 private:
  SteadyClock::time_point start_ = SteadyClock::now();
  History history_;
};

struct Solution {
  Eigen::VectorXd x;
  ConeResult result;
  History history;
};

Solution solve(const RecordedProblem& problem, const std::string& solver, double tolerance, int max_iterations,
               bool exact_coulomb, const std::optional<Eigen::VectorXd>& start) {
  if (start && start->size() != problem.size()) throw nb::value_error("start: expected one number for each row of G");
  for (const ConeSolverKind& kind : cone_solver_kinds()) {
    if (kind.name != solver) continue;
    Solution out;
    out.x = start ? *start : Eigen::VectorXd::Zero(problem.size());
    Recorder recorder;
    ConeOptions options;
    options.tolerance = tolerance;
    options.max_iterations = max_iterations;
    options.observer = &recorder;
    out.result = kind.make()->solve(problem.problem(exact_coulomb), options, out.x.data());
    out.history = recorder.history();
    return out;
  }
  throw nb::value_error(("no cone solver is called '" + solver + "'").c_str());
}

RecordedProblem checked(const Eigen::MatrixXd& G, const Eigen::VectorXd& b, std::vector<Cone> cones) {
  if (G.rows() != G.cols()) throw nb::value_error("G: expected a square matrix");
  if (b.size() != G.rows()) throw nb::value_error("b: expected one number for each row of G");
  return {G, b, std::move(cones)};
}

Eigen::VectorXd vector(std::span<const double> numbers) {
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

}  // namespace

void bind_cones(nb::module_& m) {
  nb::class_<Cone>(m, "Cone")
      .def_static("contact", &Cone::contact, nb::arg("first"), nb::arg("friction"), nb::arg("spinning") = 0.0,
                  nb::arg("rolling") = 0.0)
      .def_static("planar_contact", &Cone::planar_contact, nb::arg("first"), nb::arg("friction"),
                  nb::arg("rolling") = 0.0)
      .def_static("within", &Cone::within, nb::arg("first"), nb::arg("lower"), nb::arg("upper"))
      .def_static("ball", &Cone::ball, nb::arg("first"), nb::arg("size"), nb::arg("radius"))
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
  nb::class_<RecordedProblem>(m, "ConeProblem", "A cone complementarity problem, given or recorded from a step.")
      .def(nb::new_(&checked), nb::arg("G"), nb::arg("b"), nb::arg("cones"))
      .def_prop_ro("G", &RecordedProblem::matrix)
      .def_prop_ro("b", [](const RecordedProblem& of) { return vector(of.b()); })
      .def_prop_ro("cones",
                   [](const RecordedProblem& of) { return std::vector<Cone>(of.cones().begin(), of.cones().end()); })
      .def("without_matrix", &RecordedProblem::without_matrix,
           "The same for methods as if there were too many rows for a matrix, if there is a root.")
      .def("solve", &solve, nb::arg("solver") = "hybrid", nb::arg("tolerance") = 1e-10,
           nb::arg("max_iterations") = 1000, nb::arg("exact_coulomb") = true, nb::arg("start") = nb::none(),
           "start: first approximation, a number for each row of G; None: zeros.");
  m.def("cone_solvers", [] {
    std::vector<std::pair<std::string, std::string>> out;
    for (const ConeSolverKind& kind : cone_solver_kinds()) out.emplace_back(kind.name, kind.summary);
    return out;
  });
}

}  // namespace gelenk

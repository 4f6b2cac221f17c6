// SPDX-License-Identifier: BSD-3-Clause
#include "linear/descent.h"

#include <nanobind/stl/function.h>

#include <functional>

#include "units.h"

namespace nb = nanobind;

namespace native {

// Levenberg-Marquardt descent on functions of plain numbers. step(x, r, damping) returns the step.
void bind_descent(nb::module_& m) {
  using Residual = std::function<Numbers(const Numbers&)>;
  using Step = std::function<Numbers(const Numbers&, const Numbers&, double)>;
  m.def(
      "descend",
      [](Numbers x, const Residual& residual, const Step& step, double tolerance, double rounding, double min_progress,
         double min_damping, double max_step, int max_steps) {
        const auto vector = [](const Numbers& of) {
          return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(of.data(), static_cast<Eigen::Index>(of.size())));
        };
        const auto list = [](const Eigen::VectorXd& of) { return Numbers(of.begin(), of.end()); };
        const Eigen::VectorXd left = gelenk::descend(
            x, {tolerance, rounding, min_progress, min_damping, max_step, max_steps},
            [&](const Numbers& at) { return vector(residual(at)); },
            [&](const Numbers& at) {
              return [&, at](const Eigen::VectorXd& r, double damping) { return vector(step(at, list(r), damping)); };
            },
            [&](const Numbers& at, const Eigen::VectorXd& dx) { return list(vector(at) + dx); });
        return std::pair(x, list(left));
      },
      nb::arg("x"), nb::arg("residual"), nb::arg("step"), nb::kw_only(), nb::arg("tolerance") = 0.0,
      nb::arg("rounding") = 0.0, nb::arg("min_progress") = 1e-6, nb::arg("min_damping") = 0.0,
      nb::arg("max_step") = 1e3, nb::arg("max_steps") = 100);
}

}  // namespace native

// SPDX-License-Identifier: BSD-3-Clause
// Output of a run: the joint coordinates at the samples at which runs are compared.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "ref_kernel.h"

struct RunRecord {
  std::string method;
  double setting = 0;  // tolerance, or step [s]
  double cpu = 1e30;   // s, of the steps alone
  long steps = 0, evaluations = 0;
  bool finished = false;
  std::vector<std::vector<double>> samples;  // coordinates by sample, the start first
};

inline void print(const RunRecord& run) {
  std::printf(R"({"method": "%s", "setting": %.6g, "cpu_s": %.6g, "steps": %ld, "evaluations": %ld, )"
              R"("finished": %s, "ref_us": %.6g, "samples": [)",
              run.method.c_str(), run.setting, run.cpu, run.steps, run.evaluations, run.finished ? "true" : "false",
              1e6 * ref_kernel(500));
  for (std::size_t k = 0; k < run.samples.size(); ++k) {
    std::printf(k == 0 ? "[" : ", [");
    for (std::size_t i = 0; i < run.samples[k].size(); ++i) {
      const double x = run.samples[k][i];
      std::printf(i == 0 ? "%.17g" : ", %.17g", std::isfinite(x) ? x : 1e300);
    }
    std::printf("]");
  }
  std::printf("]}\n");
  std::fflush(stdout);
}

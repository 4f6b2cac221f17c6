// SPDX-License-Identifier: BSD-3-Clause
// The domain of the constraint equations: those of some loop-closing joints are not defined everywhere (a rod collinear
// with an axis).
#pragma once

#include <string>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

class RowDomain {
 public:
  RowDomain(const Mechanism& mechanism, const Dynamics& dynamics);

  // Whether the constraint equations are defined at the present position of `dynamics`.
  bool is_defined() const;
  // Describes why constraint equations are not defined near there; empty: they are.
  std::string undefined_reason() const;

 private:
  const Mechanism& mechanism_;
  const Dynamics& dynamics_;
  std::vector<int> cuts_;  // cut joints whose constraint equations are not defined everywhere
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Where the rows of loops are defined: of some joints that close loops they are not everywhere (a rod in line with an
// axis).
#pragma once

#include <string>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

class RowDomain {
 public:
  RowDomain(const Mechanism& mechanism, const Dynamics& dynamics);

  // Where `dynamics` stands.
  bool holds() const;
  // Why rows are not defined near there, in words; empty: they are.
  std::string edge() const;

 private:
  const Mechanism& mechanism_;
  const Dynamics& dynamics_;
  std::vector<int> cuts_;  // whose rows are not defined everywhere
};

}  // namespace gelenk

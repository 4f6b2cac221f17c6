// SPDX-License-Identifier: BSD-3-Clause
// Formulas of a scene become a part of what is recorded.
#pragma once

#include "expression/tape.h"
#include "recording/recorded.h"

namespace gelenk::expression {

// Without held branches: each choice is recorded with both of them. Throws recording::HiddenBranch for tables.
template <>
void Tape::evaluate(const recording::Recorded*, recording::Recorded*, const bool*, recording::Recorded*,
                    const bool*) const;

}  // namespace gelenk::expression

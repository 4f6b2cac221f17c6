// SPDX-License-Identifier: BSD-3-Clause
// Parts of terms.
#pragma once

#include <functional>
#include <vector>

#include "expression/graph.h"

namespace gelenk {

// The largest parts of terms that depend on none of the variables for which `depends` holds, and are no constants.
std::vector<expression::Term> independent_parts(const expression::Graph& graph, const std::vector<expression::Term>& of,
                                                const std::function<bool(int)>& depends);

}  // namespace gelenk

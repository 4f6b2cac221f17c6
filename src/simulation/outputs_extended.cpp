// SPDX-License-Identifier: BSD-3-Clause
// Outputs as numbers that carry derivatives.
#include "math/dual.h"
#include "math/series.h"
#include "simulation/outputs_impl.h"

namespace gelenk {

template Dual Outputs::value(int, const ReadingOf<Dual>&) const;
template Series Outputs::value(int, const ReadingOf<Series>&) const;

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Outputs as dual numbers (forward-mode automatic differentiation) and as power series in time.
#include "math/dual.h"
#include "math/series.h"
#include "outputs/outputs_impl.h"

namespace gelenk {

template Dual Outputs::value(int, const ReadingOf<Dual>&) const;
template Series Outputs::value(int, const ReadingOf<Series>&) const;
template void Outputs::rates_of_forces(int, const std::vector<Formula>&, const ReadingOf<Dual>&, Dual*) const;
template void Outputs::rates_of_forces(int, const std::vector<Formula>&, const ReadingOf<Series>&, Series*) const;
template Dual Outputs::of_energy(int, const EnergyOf<Dual>&) const;
template Series Outputs::of_energy(int, const EnergyOf<Series>&) const;

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "derivatives/residual_evaluator_impl.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk {

template std::unique_ptr<ResidualEvaluator<Dual>> make_residual_evaluator(const Mechanism&, const Loads&);
template std::unique_ptr<ResidualEvaluator<Series>> make_residual_evaluator(const Mechanism&, const Loads&);

}  // namespace gelenk

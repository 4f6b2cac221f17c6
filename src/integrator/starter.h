// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "integrator/integrator.h"

namespace gelenk {

// Adds explicit Runge-Kutta steps after each jump of the inputs to a multistep method for an ODE; for a DAE returns the
// method unchanged.
std::unique_ptr<Integrator> with_starter(std::unique_ptr<Integrator> multistep, Equations& system,
                                         const IntegratorOptions& options);

}  // namespace gelenk

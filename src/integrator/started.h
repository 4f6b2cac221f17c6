// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "integrator/integrator.h"

namespace gelenk {

// A multistep method for an ODE, with explicit Runge-Kutta steps after each jump of the inputs; that of a DAE itself.
std::unique_ptr<Integrator> with_starter(std::unique_ptr<Integrator> multistep, Equations& system,
                                         const IntegratorOptions& options);

}  // namespace gelenk

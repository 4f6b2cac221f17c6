// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "event_driven/contact_equations.h"
#include "nonsmooth/shared_load.h"

namespace gelenk {

// A load on which the motion depends and that a contact shares with joints at rest, at the last accelerate() of
// `equations`. Overwrites the multipliers of the last solve() of `dynamics`.
std::optional<SharedLoad> find_shared_load(ContactEquations& equations, const Mechanism& mechanism, Dynamics& dynamics);

}  // namespace gelenk

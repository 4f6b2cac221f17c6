// SPDX-License-Identifier: BSD-3-Clause
// Messages about forces that break their laws, in the names of the scene and in SI units.
#pragma once

#include <string>

#include "nonsmooth/law_audit.h"
#include "scene/scene.h"

namespace gelenk {

struct Loads;

std::string describe_broken_law(const Scene& scene, const Loads& loads, const BrokenLaw& broken);

}  // namespace gelenk

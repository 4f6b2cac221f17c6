// SPDX-License-Identifier: BSD-3-Clause
// documentation/index.html of an FMU, generated from the catalog.
#pragma once

#include <string>

#include "fmu/export/picture.h"
#include "modelDescription/catalog.h"
#include "simulation/simulation.h"

namespace gelenk {

// simulation: of the same scene, assembled at its start values. left_out: clause about parts that were omitted because
// no wanted output depends on them; may be empty.
std::string write_documentation(Simulation& simulation, const Catalog& catalog, const Picture& picture,
                                const std::string& left_out);

}  // namespace gelenk

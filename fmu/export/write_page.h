// SPDX-License-Identifier: BSD-3-Clause
// documentation/index.html of an FMU, from the catalogue.
#pragma once

#include <string>

#include "fmu/export/picture.h"
#include "modelDescription/catalog.h"
#include "simulation/simulation.h"

namespace gelenk {

// simulation: of the same scene, assembled at its start values. left_out: what no wanted output depends on, as a
// sentence.
std::string write_documentation(Simulation& simulation, const Catalog& catalog, const Picture& picture,
                                const std::string& left_out);

}  // namespace gelenk

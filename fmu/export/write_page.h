// SPDX-License-Identifier: BSD-3-Clause
// documentation/index.html of an FMU, generated from the catalog.
#pragma once

#include <string>

#include "fmu/export/picture.h"
#include "modelDescription/catalog.h"
#include "modelDescription/write_xml.h"
#include "simulation/simulation.h"

namespace gelenk {

struct PageContents {
  const Picture& picture;
  bool has_view;         // whether view.html, with a view in three dimensions, is beside the page
  std::string left_out;  // clause about parts that were omitted because no wanted output depends on them; may be empty
  FmiVersion version;
};

// simulation: of the same scene as the catalog, assembled at its start values.
std::string write_documentation(Simulation& simulation, const Catalog& catalog, const PageContents& contents);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// modelDescription.xml of FMI 2.0, generated from the catalog.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "modelDescription/catalog.h"
#include "modelDescription/dependencies.h"

namespace gelenk {

// Data that several files of an FMU contain.
struct FmuFacts {
  std::string model_identifier;  // names the binary
  std::string guid;
  int order = 0;                          // number of states of the mechanism, counting three for a quaternion
  std::optional<int> event_indicators{};  // none: the FMU is for co-simulation only
};

// Returns the XML text. dependencies: those of dependencies_of().
std::string write_model_description(const Scene& scene, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                                    const FmuFacts& facts);

// The text with line breaks and tabs as spaces, as attributes of XML contain none; those at the end, which YAML's
// folded texts have, are dropped.
std::string on_one_line(std::string text);

// The text with the special characters of XML and HTML escaped; control characters are dropped.
std::string escaped(std::string_view text);

}  // namespace gelenk

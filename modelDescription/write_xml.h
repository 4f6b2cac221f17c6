// SPDX-License-Identifier: BSD-3-Clause
// modelDescription.xml, generated from the catalog.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "modelDescription/catalog.h"
#include "modelDescription/dependencies.h"

namespace gelenk {

enum class FmiVersion { fmi2 = 2, fmi3 = 3 };

// Data that several files of an FMU contain.
struct FmuFacts {
  std::string model_identifier;  // names the binary
  std::string guid;
  int order = 0;                          // number of states of the mechanism, counting three for a quaternion
  std::optional<int> event_indicators{};  // none: the FMU is for co-simulation only
};

// Return the XML text. dependencies: those of dependencies_of().
std::string write_fmi2_description(const Scene& scene, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                                   const FmuFacts& facts);
std::string write_fmi3_description(const Scene& scene, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                                   const FmuFacts& facts);

// terminalsAndIcons/terminalsAndIcons.xml of FMI 3.0: each joint a terminal, with the outputs of its motion and the
// inputs of its motors. has_icon: whether icon.png is beside it.
std::string write_terminals(const Scene& scene, const Catalog& catalog, bool has_icon);

// The text with line breaks and tabs as spaces, as attributes of XML contain none; those at the end, which YAML's
// folded texts have, are dropped.
std::string on_one_line(std::string text);

// The text with the special characters of XML and HTML escaped; control characters are dropped.
std::string escaped(std::string_view text);

}  // namespace gelenk

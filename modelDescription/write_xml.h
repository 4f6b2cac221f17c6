// SPDX-License-Identifier: BSD-3-Clause
// modelDescription.xml of FMI 2.0, from the catalogue.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "modelDescription/catalog.h"
#include "modelDescription/dependencies.h"

namespace gelenk {

// What an FMU's files share.
struct FmuFacts {
  std::string model_identifier;  // names the binary
  std::string guid;
  int order = 0;  // how many states the mechanism has, three for a quaternion
};

// dependencies: by variable, as dependencies_of() tells them.
std::string write_model_description(const Scene& scene, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                                    const FmuFacts& facts);

// The text with the characters that XML and HTML keep for themselves written out; control characters are dropped.
std::string escaped(std::string_view text);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "element/element.h"

namespace gelenk {

// Where an element of a section acts: its frames and joints, in the order of the kind's ports. The name of an optional
// joint that is not given is empty.
struct ElementPlace {
  std::string name;
  std::vector<BodyFrame> frames;
  std::vector<std::string> joints;
  std::string coordinate;               // coordinate of the first joint, if the kind has a coordinate
  std::vector<std::string> surfaces{};  // two, if the kind refers to surfaces
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// A drawing of a scene at its start, for documentation/index.html and model.png.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "fmu/export/zip.h"
#include "simulation/simulation.h"

namespace gelenk {

using Color = std::array<std::uint8_t, 3>;  // red, green, blue

// Filled inside, with an edge `width` wide; points in pixels, x to the right, y down.
struct Shape {
  enum class Kind { line, polygon, disc };
  Kind kind = Kind::line;
  std::vector<Eigen::Vector2d> points;  // line: open; polygon: closed, convex; disc: the centre
  double radius = 0;                    // of a disc
  double width = 1;
  Color edge{}, fill{};
};

struct Label {
  Eigen::Vector2d at;
  std::string text;
};

struct Picture {
  int width = 480, height = 360;
  std::vector<Shape> shapes;  // from back to front
  std::vector<Label> labels;
};

// simulation: assembled. Its bodies are drawn where they are, in their plane or from aslant above.
Picture draw(Simulation& simulation);

std::string write_svg(const Picture& picture);

// Without the labels.
std::string write_png(const Picture& picture, const Compress& compress);

}  // namespace gelenk

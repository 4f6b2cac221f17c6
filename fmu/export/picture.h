// SPDX-License-Identifier: BSD-3-Clause
// A drawing of a scene at its start, for documentation/index.html and model.png.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fmu/export/zip.h"
#include "simulation/simulation.h"

namespace gelenk {

using Color = std::array<std::uint8_t, 3>;  // red, green, blue

// A filled shape with an outline; points and sizes in pixels, x to the right, y down.
struct Shape {
  enum class Kind { line, polygon, disc };
  Kind kind = Kind::line;
  std::vector<Eigen::Vector2d> points;  // line: open; polygon: closed, convex; disc: the center
  double radius = 0;                    // of a disc
  double width = 1;                     // of the outline or line
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

constexpr double font_size = 13;  // pixels; of labels

// The width of a label in pixels, at most: fonts differ.
double text_width(std::string_view text);

// Draws the bodies of an assembled simulation at their present positions, in their plane or seen obliquely from above.
Picture draw(Simulation& simulation);

// The picture as an SVG element.
std::string write_svg(const Picture& picture);

// The picture as PNG, without labels.
std::string write_png(const Picture& picture, const Compress& compress);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>

#include "fmu/export/picture.h"
#include "modelDescription/write_xml.h"

namespace gelenk {
namespace {

// A number with one decimal, formatted with integers because printf depends on the locale.
std::string tenths(double x) {
  const long n = std::lround(10 * x);
  const long whole = std::abs(n) / 10;
  const long rest = std::abs(n) % 10;
  return (n < 0 ? "-" : "") + std::to_string(whole) + (rest != 0 ? "." + std::to_string(rest) : "");
}

std::string hex(const Color& color) {
  std::string text = "#";
  for (const unsigned part : color) {
    text += "0123456789abcdef"[part / 16];
    text += "0123456789abcdef"[part % 16];
  }
  return text;
}

std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + "\"";
}

std::string element(const Shape& shape) {
  const std::string style = attribute("fill", shape.kind == Shape::Kind::line ? "none" : hex(shape.fill)) +
                            attribute("stroke", hex(shape.edge)) + attribute("stroke-width", tenths(shape.width)) +
                            "/>\n";
  if (shape.kind == Shape::Kind::disc) {
    return "<circle" + attribute("cx", tenths(shape.points[0].x())) + attribute("cy", tenths(shape.points[0].y())) +
           attribute("r", tenths(shape.radius)) + style;
  }
  std::string points;
  for (const Eigen::Vector2d& p : shape.points) {
    points += (points.empty() ? "" : " ") + tenths(p.x()) + "," + tenths(p.y());
  }
  return (shape.kind == Shape::Kind::line ? "<polyline" : "<polygon") + attribute("points", points) +
         attribute("stroke-linecap", "round") + attribute("stroke-linejoin", "round") + style;
}

// An attribute for labels that are longer than the picture is wide.
std::string squeezed(const std::string& text, int width) {
  constexpr double margins = 8;  // pixels
  if (text_width(text) <= width - margins) return "";
  return attribute("textLength", tenths(width - margins)) + attribute("lengthAdjust", "spacingAndGlyphs");
}

}  // namespace

double text_width(std::string_view text) {
  constexpr double em = 0.65;  // of the letters of a wide font, in font sizes
  const auto starts =
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  return em * font_size * static_cast<double>(starts);
}

std::string write_svg(const Picture& picture) {
  std::string text =
      "<svg" + attribute("xmlns", "http://www.w3.org/2000/svg") + attribute("role", "img") +
      attribute("viewBox", "0 0 " + std::to_string(picture.width) + " " + std::to_string(picture.height)) +
      attribute("width", std::to_string(picture.width)) + ">\n";
  for (const Shape& shape : picture.shapes) text += element(shape);
  for (const Label& label : picture.labels) {
    text += "<text" + attribute("x", tenths(label.at.x())) + attribute("y", tenths(label.at.y())) +
            attribute("font-size", tenths(font_size)) + squeezed(label.text, picture.width) + ">" +
            escaped(label.text) + "</text>\n";
  }
  return text + "</svg>\n";
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Rasterization of a picture, and PNG (ISO/IEC 15948).
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "fmu/export/picture.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d ab = b - a;
  const double t = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

// Distance of p from the outline of a shape; negative inside a closed one.
double distance(const Shape& shape, const Vector2d& p) {
  if (shape.kind == Shape::Kind::disc) return (p - shape.points[0]).norm() - shape.radius;
  const std::size_t n = shape.points.size();
  const bool closed = shape.kind == Shape::Kind::polygon;
  double nearest = std::numeric_limits<double>::infinity();
  int left = 0;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
    const Vector2d& a = shape.points[i];
    const Vector2d& b = shape.points[(i + 1) % n];
    nearest = std::min(nearest, distance_to_segment(p, a, b));
    left += (b - a).x() * (p - a).y() > (b - a).y() * (p - a).x() ? 1 : -1;
  }
  const bool inside = closed && std::abs(left) == static_cast<int>(n);
  return inside ? -nearest : nearest;
}

class Canvas {
 public:
  explicit Canvas(const Picture& picture)
      : width_(picture.width),
        height_(picture.height),
        pixels_(std::size_t{3} * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 255) {
    for (const Shape& shape : picture.shapes) paint(shape);
  }

  // The scanlines of PNG: the filter type (none), then the pixels.
  std::string rows() const {
    std::string out;
    const auto stride = std::size_t{3} * static_cast<std::size_t>(width_);
    for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y) {
      out += '\0';
      for (std::size_t i = 0; i < stride; ++i) out += static_cast<char>(pixels_[y * stride + i]);
    }
    return out;
  }

 private:
  // Pixel ranges, right and bottom exclusive.
  struct Box {
    int left, top, right, bottom;
    bool contains(int x, int y) const { return left <= x && x < right && top <= y && y < bottom; }
  };

  Box around(std::span<const Vector2d> points, double reach) const {
    Vector2d least = points.front();
    Vector2d most = least;
    for (const Vector2d& p : points) {
      least = least.cwiseMin(p);
      most = most.cwiseMax(p);
    }
    const auto clipped = [](double x, int end) {
      return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(end)));
    };
    return {clipped(least.x() - reach, width_), clipped(least.y() - reach, height_),
            clipped(most.x() + reach + 1, width_), clipped(most.y() + reach + 1, height_)};
  }

  // For a line, only the boxes around its segments are examined, since the box around an oblique line is mostly empty.
  void paint(const Shape& shape) {
    const double reach = shape.radius + shape.width + 1;
    const bool line = shape.kind == Shape::Kind::line;
    const std::span<const Vector2d> points = shape.points;
    std::vector<Box> done;
    for (std::size_t i = 0; i + 1 < (line ? points.size() : 2); ++i) {
      const Box box = around(line ? points.subspan(i, 2) : points, reach);
      for (int y = box.top; y < box.bottom; ++y) {
        for (int x = box.left; x < box.right; ++x) {
          if (std::ranges::any_of(done, [&](const Box& b) { return b.contains(x, y); })) continue;
          const double d = distance(shape, {x + 0.5, y + 0.5});
          if (!line) blend(x, y, shape.fill, 0.5 - d);
          blend(x, y, shape.edge, 0.5 + shape.width / 2 - std::abs(d));
        }
      }
      done.push_back(box);
    }
  }

  // cover: fraction of the pixel that the color covers; clamped to 0 and 1.
  void blend(int x, int y, const Color& color, double cover) {
    const double part = std::clamp(cover, 0.0, 1.0);
    std::uint8_t* pixel = &pixels_[std::size_t{3} * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                                     static_cast<std::size_t>(x))];
    for (std::size_t c = 0; c < 3; ++c) {
      pixel[c] = static_cast<std::uint8_t>(std::lround(part * color[c] + (1 - part) * pixel[c]));
    }
  }

  int width_, height_;
  std::vector<std::uint8_t> pixels_;
};

std::string big_endian(std::uint32_t value) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>((value >> shift) & 255U);
  return out;
}

std::string chunk(std::string_view type, std::string_view content) {
  const std::string body = std::string(type) + std::string(content);
  return big_endian(static_cast<std::uint32_t>(content.size())) + body + big_endian(crc32(body));
}

}  // namespace

std::string write_png(const Picture& picture, const Compress& compress) {
  using namespace std::string_view_literals;
  const std::string header = big_endian(static_cast<std::uint32_t>(picture.width)) +
                             big_endian(static_cast<std::uint32_t>(picture.height)) +
                             std::string("\x08\x02\x00\x00\x00"sv);  // 8 bits each of red, green and blue
  return std::string("\x89PNG\r\n\x1a\n"sv) + chunk("IHDR", header) + chunk("IDAT", compress(Canvas(picture).rows())) +
         chunk("IEND", {});
}

}  // namespace gelenk

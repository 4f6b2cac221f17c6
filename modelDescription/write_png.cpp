// SPDX-License-Identifier: BSD-3-Clause
// Drawing into pixels, and PNG (ISO/IEC 15948) around DEFLATE (RFC 1951) with fixed codes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "modelDescription/picture.h"
#include "modelDescription/zip.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;

double to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d ab = b - a;
  const double t = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

// From p to the shape's line; negative inside a closed one.
double distance(const Shape& shape, const Vector2d& p) {
  if (shape.kind == Shape::Kind::disc) return (p - shape.points[0]).norm() - shape.radius;
  const std::size_t n = shape.points.size();
  const bool closed = shape.kind == Shape::Kind::polygon;
  double nearest = std::numeric_limits<double>::infinity();
  int left = 0;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
    const Vector2d& a = shape.points[i];
    const Vector2d& b = shape.points[(i + 1) % n];
    nearest = std::min(nearest, to_segment(p, a, b));
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

  // Rows as PNG has them: a filter's number (none), then the pixels.
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
  // Pixels, the end not included.
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

  // Of a line only what lies about its pieces is looked at: a long one goes slantwise through much that is empty.
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

  // cover: how much of the pixel the colour takes, if between 0 and 1.
  void blend(int x, int y, const Colour& colour, double cover) {
    const double part = std::clamp(cover, 0.0, 1.0);
    std::uint8_t* pixel = &pixels_[std::size_t{3} * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                                     static_cast<std::size_t>(x))];
    for (std::size_t c = 0; c < 3; ++c) {
      pixel[c] = static_cast<std::uint8_t>(std::lround(part * colour[c] + (1 - part) * pixel[c]));
    }
  }

  int width_, height_;
  std::vector<std::uint8_t> pixels_;
};

// One block of DEFLATE with fixed codes that looks for repetitions at two distances only: of the pixel before and of
// the row above. Drawings are made of these.
class Deflate {
 public:
  Deflate(std::string_view data, std::size_t row) : data_(data) {
    bits(0b011, 3);  // the last block, fixed codes
    for (std::size_t at = 0; at < data.size();) {
      const std::size_t beside = repeated(at, 3);
      const std::size_t above = repeated(at, row);
      const std::size_t length = std::max(beside, above);
      if (length < 3) {
        literal(static_cast<unsigned char>(data[at++]));
        continue;
      }
      put_length(static_cast<unsigned>(length));
      put_distance(static_cast<unsigned>(above >= beside ? row : 3));
      at += length;
    }
    code(0, 7);  // end of block
    if (used_ > 0) out_ += static_cast<char>(byte_);
  }
  std::string take() { return std::move(out_); }

 private:
  std::size_t repeated(std::size_t at, std::size_t distance) const {
    if (at < distance) return 0;
    std::size_t n = 0;
    while (n < 258 && at + n < data_.size() && data_[at + n] == data_[at + n - distance]) ++n;
    return n;
  }

  // From the lowest bit on.
  void bits(unsigned value, int count) {
    for (int i = 0; i < count; ++i) {
      byte_ |= ((value >> i) & 1U) << used_;
      if (++used_ < 8) continue;
      out_ += static_cast<char>(byte_);
      byte_ = 0;
      used_ = 0;
    }
  }
  // Huffman codes go from the highest bit on.
  void code(unsigned value, int count) {
    for (int i = count - 1; i >= 0; --i) bits(value >> i, 1);
  }
  void literal(unsigned value) { value < 144 ? code(48 + value, 8) : code(256 + value, 9); }

  // RFC 1951, 3.2.5: codes 257 to 285; from 265 on, four to each further bit.
  void put_length(unsigned length) {
    if (length == 258) return code(0b11000101, 8);
    unsigned extra = 0;
    while (length - 3 >= 8U << extra) ++extra;
    const unsigned symbol = 257 + 4 * extra + ((length - 3) >> extra);
    symbol < 280 ? code(symbol - 256, 7) : code(192 + symbol - 280, 8);
    bits((length - 3) & ((1U << extra) - 1), static_cast<int>(extra));
  }
  // Likewise; two codes to each further bit.
  void put_distance(unsigned distance) {
    unsigned extra = 0;
    while (distance - 1 >= 4U << extra) ++extra;
    code(2 * extra + ((distance - 1) >> extra), 5);
    bits((distance - 1) & ((1U << extra) - 1), static_cast<int>(extra));
  }

  std::string_view data_;
  std::string out_;
  unsigned byte_ = 0;
  int used_ = 0;
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

// RFC 1950.
std::uint32_t adler32(std::string_view data) {
  std::uint32_t a = 1;
  std::uint32_t b = 0;
  for (const char c : data) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  return (b << 16U) | a;
}

}  // namespace

std::string write_png(const Picture& picture) {
  using namespace std::string_view_literals;
  const std::string rows = Canvas(picture).rows();
  const std::string header = big_endian(static_cast<std::uint32_t>(picture.width)) +
                             big_endian(static_cast<std::uint32_t>(picture.height)) +
                             std::string("\x08\x02\x00\x00\x00"sv);  // 8 bits each of red, green and blue
  const std::string packed = std::string("\x78\x01"sv) +
                             Deflate(rows, static_cast<std::size_t>(3 * picture.width + 1)).take() +
                             big_endian(adler32(rows));
  return std::string("\x89PNG\r\n\x1a\n"sv) + chunk("IHDR", header) + chunk("IDAT", packed) + chunk("IEND", {});
}

}  // namespace gelenk

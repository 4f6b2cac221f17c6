// SPDX-License-Identifier: BSD-3-Clause
// Shapes and poses made from lists of numbers.
#pragma once

#include <string>

#include "shape/registry.h"
#include "units.h"

namespace native {

inline Eigen::Vector3d vector3(const Numbers& of) { return {of.at(0), of.at(1), of.at(2)}; }
inline Numbers numbers(const Eigen::Vector3d& of) { return {of.begin(), of.end()}; }

inline std::vector<Eigen::Vector3d> points3(const Table& rows) {
  std::vector<Eigen::Vector3d> out;
  for (const Numbers& row : rows) out.push_back(vector3(row));
  return out;
}

// 12 numbers: the rows of R, then p.
inline gelenk::Pose3 pose(const Numbers& of) {
  gelenk::Pose3 X;
  for (int i = 0; i < 9; ++i) X.R(i / 3, i % 3) = of.at(static_cast<std::size_t>(i));
  X.p = {of.at(9), of.at(10), of.at(11)};
  return X;
}

// dimensions: the values of all fields in order; points: of a hull.
inline gelenk::AnyShape shape(const std::string& kind, const Numbers& dimensions, const Table& points) {
  const gelenk::ShapeKind* found = gelenk::find_shape_kind(kind);
  if (found == nullptr) throw nanobind::value_error("no such shape");
  const auto index = static_cast<std::size_t>(found - gelenk::shape_kinds().data());
  if (found->of_points) return *gelenk::make_shape_of_points(index, points3(points));
  gelenk::AnyShape out = *gelenk::make_shape(index);
  std::size_t next = 0;
  for (const gelenk::Field& field : found->fields) {
    if (field.type == gelenk::Field::Type::number) {
      field.of<double>(gelenk::data_of(out)) = dimensions.at(next++);
    } else {
      field.of<Eigen::Vector3d>(gelenk::data_of(out)) =
          vector3({dimensions.begin() + static_cast<int>(next), dimensions.end()});
      next += 3;
    }
  }
  return out;
}

}  // namespace native

// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/parallel_axes.h"

#include <cmath>

namespace gelenk {
namespace {

using Eigen::Vector3d;

// Sine of the angle between axes that are parallel up to rounding: such a group is left unchanged.
constexpr double max_rounding_sine = 1e-15;

Vector3d axis_of(const LoopGeometry& loops, std::size_t frame) { return loops.frames()[frame].X.R.col(2); }

// Frames of one link, from `first` on, whose axes are parallel to that of another member of the group.
std::vector<std::size_t> group_of(const LoopGeometry& loops, std::size_t first, const std::vector<bool>& grouped,
                                  double tolerance) {
  const std::vector<LoopGeometry::Frame>& frames = loops.frames();
  std::vector<std::size_t> out = {first};
  std::vector<bool> in_group(frames.size(), false);
  in_group[first] = true;
  for (std::size_t k = 0; k < out.size(); ++k) {
    for (std::size_t i = first + 1; i < frames.size(); ++i) {
      if (in_group[i] || grouped[i] || !frames[i].has_axis || frames[i].link != frames[first].link) continue;
      // Each of the two may deviate by the tolerance.
      if (axis_of(loops, out[k]).cross(axis_of(loops, i)).norm() > 2 * tolerance) continue;
      in_group[i] = true;
      out.push_back(i);
    }
  }
  return out;
}

void align(LoopGeometry& loops, const std::vector<std::size_t>& group) {
  const Vector3d first = axis_of(loops, group.front());
  Vector3d mean = Vector3d::Zero();
  double max_sine = 0;
  for (const std::size_t i : group) {
    const Vector3d axis = axis_of(loops, i);
    mean += axis.dot(first) < 0 ? Vector3d(-axis) : axis;
    max_sine = std::max(max_sine, axis.cross(first).norm());
  }
  if (max_sine <= max_rounding_sine) return;
  mean.normalize();
  for (const std::size_t i : group) {
    // Twice: the second turn removes the rounding of the first.
    for (int k = 0; k < 2; ++k) {
      const Vector3d axis = axis_of(loops, i);
      const Vector3d across = axis.cross(axis.dot(mean) < 0 ? Vector3d(-mean) : mean);
      const double sine = across.norm();
      if (sine > 0) loops.turn(i, Eigen::AngleAxisd(std::asin(sine), across / sine).toRotationMatrix());
    }
  }
}

}  // namespace

std::vector<bool> make_parallel(LoopGeometry& loops, double tolerance) {
  std::vector<bool> grouped(loops.frames().size(), false);
  for (std::size_t i = 0; i < grouped.size(); ++i) {
    if (grouped[i] || !loops.frames()[i].has_axis) continue;
    const std::vector<std::size_t> group = group_of(loops, i, grouped, tolerance);
    if (group.size() < 2) continue;
    for (const std::size_t k : group) grouped[k] = true;
    align(loops, group);
  }
  return grouped;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Positions, rotations and directions in a scene file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene_file/json_fields.h"

namespace gelenk {

// One of {quaternion: [w, x, y, z]}, {rpy: [r, p, y]} (R = Rz(y) Ry(p) Rx(r)), {axis: [..], angle: a},
// {matrix: rows}.
std::optional<Eigen::Matrix3d> read_rotation(const Json& value, const std::string& path, Faults& faults);

// The `position` and `rotation` among the fields; identity where the file is silent.
Pose3 read_pose(Fields& fields, bool with_rotation = true);

// A unit vector.
std::optional<Eigen::Vector3d> read_direction(const Json& value, const std::string& path, Faults& faults);

// The name of a body, ground included; empty after a fault. names: those there are, ground first;
// none when they could not be read, which is told elsewhere.
std::string read_body_name(const Json& value, const std::string& path, Faults& faults,
                           const std::vector<std::string>& names);

// {body, position, rotation}, or only the body's name. placed: whether the file gave position or rotation.
BodyFrame read_body_frame(const Json& value, const std::string& path, Faults& faults,
                          const std::vector<std::string>& names, bool with_rotation = true, bool* placed = nullptr);

}  // namespace gelenk

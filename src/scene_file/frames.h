// SPDX-License-Identifier: BSD-3-Clause
// Positions, rotations and directions in a scene file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "scene_file/json_fields.h"

namespace gelenk {

// Reads a rotation in one of the forms {quaternion: [w, x, y, z]}, {rpy: [r, p, y]} (R = Rz(y) Ry(p) Rx(r)),
// {axis: [..], angle: a}, {matrix: rows}. This and the functions below add errors to `faults`.
std::optional<Eigen::Matrix3d> read_rotation(const Json& value, const std::string& path, Faults& faults);

// Reads the fields `position` [m] and `rotation`; identity if the file gives neither.
Pose3 read_pose(Fields& fields, bool with_rotation = true);

// Reads a direction and normalizes it.
std::optional<Eigen::Vector3d> read_direction(const Json& value, const std::string& path, Faults& faults);

// Reads the name of a body or of the ground; returns an empty text after an error. names: the existing names, ground
// first; empty if they could not be read, which is reported elsewhere.
std::string read_body_name(const Json& value, const std::string& path, Faults& faults,
                           const std::vector<std::string>& names);

// Reads {body, position, rotation}, or only the name of a body. placed: set to true if a position or rotation is given.
BodyFrame read_body_frame(const Json& value, const std::string& path, Faults& faults,
                          const std::vector<std::string>& names, bool with_rotation = true, bool* placed = nullptr);

}  // namespace gelenk

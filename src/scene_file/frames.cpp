// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file/frames.h"

#include <cmath>
#include <limits>

#include "check/warnings.h"
#include "math/rotations.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Largest deviation from orthonormality of a matrix in a file, whose digits may be rounded.
constexpr double matrix_tolerance = 1e-6;

using Rotation = std::optional<Eigen::Matrix3d>;

Rotation read_quaternion(const Json& value, const std::string& path, Faults& faults) {
  const auto given = read_list(value, path, faults, 4, "");
  if (!given) return {};
  const Eigen::Vector4d wxyz(given->data());
  if (wxyz.isZero(0)) {
    faults.add(path, "[0, 0, 0, 0]", "a quaternion [w, x, y, z] other than zero");
    return {};
  }
  const Eigen::VectorXd u = unit(wxyz);
  // No rotation, if it were written as [x, y, z, w], as other programs and `Q` of joints do.
  if (wxyz.head<3>().isZero(0)) {
    faults.warn(path, "[0, 0, 0, " + text::number(wxyz[3]) + "], half a turn about z",
                "a quaternion [w, x, y, z]; [1, 0, 0, 0] is no rotation");
  }
  return Eigen::Quaterniond(u[0], u[1], u[2], u[3]).toRotationMatrix();
}

Rotation read_rpy(const Json& value, const std::string& path, Faults& faults) {
  const auto rpy = read_vector(value, path, faults, "rad");
  if (!rpy) return {};
  for (int i = 0; i < 3; ++i) warn_about_angle((*rpy)[i], path + "[" + std::to_string(i + 1) + "]", faults);
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd((*rpy)[2], Vector3d::UnitZ()).toRotationMatrix() *
          AngleAxisd((*rpy)[1], Vector3d::UnitY()).toRotationMatrix() *
          AngleAxisd((*rpy)[0], Vector3d::UnitX()).toRotationMatrix());
}

Rotation read_axis_angle(const Json* axis, const Json* angle, const std::string& path, Faults& faults) {
  if (axis == nullptr) faults.add(path + ".axis", "nothing", "the direction of the rotation axis");
  if (angle == nullptr) faults.add(path + ".angle", "nothing", "the rotation angle about 'axis', a number in rad");
  if (axis == nullptr || angle == nullptr) return {};
  const auto n = read_direction(*axis, path + ".axis", faults);
  const auto a = read_number(*angle, path + ".angle", faults, "rad");
  if (!n || !a) return {};
  warn_about_angle(*a, path + ".angle", faults);
  return Eigen::AngleAxisd(*a, *n).toRotationMatrix();
}

Rotation read_matrix(const Json& value, const std::string& path, Faults& faults) {
  if (!value.is_array() || value.size() != 3) {
    faults.add(path, shown(value), "a list of 3 rows of 3 numbers");
    return {};
  }
  Eigen::Matrix3d R;
  bool complete = true;
  for (int i = 0; i < 3; ++i) {
    const auto row =
        read_vector(value[static_cast<std::size_t>(i)], path + "[" + std::to_string(i + 1) + "]", faults, "");
    complete = complete && row.has_value();
    if (row) R.row(i) = row->transpose();
  }
  if (!complete) return {};
  // Not `>`: entries may be so large that the error is NaN.
  const double error = rotation_error(R);
  if (!(error <= matrix_tolerance)) {
    faults.add(path, "columns that deviate from orthonormality by " + text::rounded(error),
               "a rotation matrix (deviation at most 1e-6)");
    return {};
  }
  if (R.determinant() < 0) {
    faults.add(path, "a reflection (determinant -1)", "a rotation (determinant +1)");
    return {};
  }
  return R;
}

}  // namespace

std::optional<Eigen::Matrix3d> read_rotation(const Json& value, const std::string& path, Faults& faults) {
  constexpr const char* forms =
      "one of {quaternion: [w, x, y, z]}, {rpy: [r, p, y]}, {axis: [x, y, z], angle: a}, {matrix: rows}";
  Fields fields(value, path, faults, forms);
  const Json* quaternion = fields.find("quaternion");
  const Json* rpy = fields.find("rpy");
  const Json* axis = fields.find("axis");
  const Json* angle = fields.find("angle");
  const Json* matrix = fields.find("matrix");
  fields.done();
  if (!fields.valid()) return {};
  const bool turn = axis != nullptr || angle != nullptr;
  const int given = (quaternion != nullptr) + (rpy != nullptr) + turn + (matrix != nullptr);
  if (given != 1) {
    faults.add(path, given == 0 ? "no rotation" : std::to_string(given) + " rotations", forms);
    return {};
  }
  Rotation R;
  if (quaternion != nullptr) R = read_quaternion(*quaternion, path + ".quaternion", faults);
  if (rpy != nullptr) R = read_rpy(*rpy, path + ".rpy", faults);
  if (turn) R = read_axis_angle(axis, angle, path, faults);
  if (matrix != nullptr) R = read_matrix(*matrix, path + ".matrix", faults);
  if (R) R = orthonormalized(*R);
  return R;
}

Pose3 read_pose(Fields& fields, bool with_rotation) {
  Pose3 X;
  X.p = fields.vector("position", "m");
  if (!with_rotation) return X;
  if (const Json* rotation = fields.find("rotation")) {
    X.R = read_rotation(*rotation, fields.path("rotation"), fields.faults()).value_or(X.R);
  }
  return X;
}

std::optional<Eigen::Vector3d> read_direction(const Json& value, const std::string& path, Faults& faults) {
  const auto n = read_vector(value, path, faults, "");
  if (!n) return {};
  if (n->isZero(0)) {
    faults.add(path, "[0, 0, 0]", "a direction");
    return {};
  }
  return Eigen::Vector3d(unit(*n));
}

std::string read_body_name(const Json& value, const std::string& path, Faults& faults,
                           const std::vector<std::string>& names) {
  const auto name = read_text(value, path, faults, "the name of a body");
  if (!name || names.empty()) return {};
  if (std::ranges::find(names, *name) != names.end()) return *name;
  faults.add(path, text::quoted(*name), text::one_of(*name, names, "bodies"));
  return {};
}

BodyFrame read_body_frame(const Json& value, const std::string& path, Faults& faults,
                          const std::vector<std::string>& names, bool with_rotation, bool* placed) {
  BodyFrame frame;
  if (value.is_string()) {
    frame.body = read_body_name(value, path, faults, names);
    return frame;
  }
  Fields fields(
      value, path, faults,
      with_rotation ? "{body, position, rotation} or the name of a body" : "{body, position} or the name of a body");
  const Json* body = fields.require("body", "the name of a body");
  frame.body = body != nullptr ? read_body_name(*body, fields.path("body"), faults, names) : "";
  if (placed != nullptr)
    *placed = fields.find("position") != nullptr || fields.find("rotation") != nullptr;  // joints only
  frame.X_BF = read_pose(fields, with_rotation);
  fields.done();
  return frame;
}

}  // namespace gelenk

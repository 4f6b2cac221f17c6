// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/projection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

// Eigenvalues below this are those of rotations of a group that is very long compared with its limit; they are dropped.
constexpr double least_eigenvalue = 1e-13;

// Where the projection of y is: its normal component, and the groups that are at their limits there.
struct Face {
  double n = 0;
  std::array<ConeGroup, Cone::groups> groups{};
  std::array<double, Cone::groups> length{};  // of each group of y
  std::array<bool, Cone::groups> at_limit{};
  double denominator = 1;  // 1 + sum of the squared coefficients of the groups at their limits
};

double norm(const double* x, int size) {
  double sum = 0;
  for (int i = 0; i < size; ++i) sum += x[i] * x[i];
  return std::sqrt(sum);
}

// The normal component n minimizes (n - y_n)^2 + sum over the groups of max(0, |y_g| - mu_g n)^2. The derivative is
// increasing and linear between the breakpoints |y_g| / mu_g, which are tried from the largest downward.
Face face(const Cone& cone, const double* y) {
  Face out;
  out.groups = cone.limited();
  std::array<std::size_t, Cone::groups> order{};
  std::size_t candidates = 0;
  const auto earlier = [&](std::size_t i, std::size_t j) {
    return out.length[i] * out.groups[j].coefficient > out.length[j] * out.groups[i].coefficient;
  };
  for (std::size_t g = 0; g < out.groups.size(); ++g) {
    out.length[g] = norm(y + out.groups[g].offset, out.groups[g].size);
    if (!(out.groups[g].coefficient > 0 && out.length[g] > 0)) continue;
    std::size_t place = candidates++;
    for (; place > 0 && earlier(g, order[place - 1]); --place) order[place] = order[place - 1];
    order[place] = g;
  }
  double numerator = y[0];
  out.n = y[0];
  for (std::size_t k = 0; k < candidates; ++k) {
    const std::size_t g = order[k];
    const double mu = out.groups[g].coefficient;
    if (mu * out.n >= out.length[g]) break;
    out.at_limit[g] = true;
    numerator += mu * out.length[g];
    out.denominator += mu * mu;
    out.n = numerator / out.denominator;
  }
  out.n = std::max(out.n, 0.0);
  return out;
}

void append_unit(int component, ProjectionModes& out) {
  auto& q = out.q[static_cast<std::size_t>(out.count)];
  q.fill(0);
  q[static_cast<std::size_t>(component)] = 1;
  out.lambda[static_cast<std::size_t>(out.count++)] = 1;
}

// The direction of the ray on which the projection lies, with all groups at their limits.
void append_ray(const Face& at, const double* y, ProjectionModes& out) {
  auto& q = out.q[static_cast<std::size_t>(out.count)];
  q.fill(0);
  const double unit = 1 / std::sqrt(at.denominator);
  q[0] = unit;
  for (std::size_t g = 0; g < at.groups.size(); ++g) {
    if (!at.at_limit[g]) continue;
    const double factor = unit * at.groups[g].coefficient / at.length[g];
    for (int i = at.groups[g].offset; i < at.groups[g].offset + at.groups[g].size; ++i) {
      q[static_cast<std::size_t>(i)] = factor * y[i];
    }
  }
  out.lambda[static_cast<std::size_t>(out.count++)] = 1;
}

// The directions normal to y, in which a ball of less radius than the length of y shrinks.
void append_rotations(const Cone& ball, double length, const double* y, ProjectionModes& out) {
  const double lambda = ball.radius / length;
  if (lambda < least_eigenvalue) return;
  const auto append = [&](const Eigen::Vector3d& direction) {
    auto& q = out.q[static_cast<std::size_t>(out.count)];
    q.fill(0);
    for (int i = 0; i < ball.tangential; ++i) q[static_cast<std::size_t>(i)] = direction[i];
    out.lambda[static_cast<std::size_t>(out.count++)] = lambda;
  };
  Eigen::Vector3d d = Eigen::Vector3d::Zero();
  for (int i = 0; i < ball.tangential; ++i) d[i] = y[i] / length;
  if (ball.tangential == 2) append(Eigen::Vector3d(-d.y(), d.x(), 0));
  if (ball.tangential != 3) return;
  const Eigen::Vector3d across = d.unitOrthogonal();
  append(across);
  append(d.cross(across));
}

// The rotation of a group of two components at its limit.
void append_rotation(const ConeGroup& group, double length, double n, const double* y, ProjectionModes& out) {
  const double lambda = group.coefficient * n / length;
  if (group.size < 2 || lambda < least_eigenvalue) return;
  auto& q = out.q[static_cast<std::size_t>(out.count)];
  q.fill(0);
  const auto first = static_cast<std::size_t>(group.offset);
  q[first] = -y[group.offset + 1] / length;
  q[first + 1] = y[group.offset] / length;
  out.lambda[static_cast<std::size_t>(out.count++)] = std::min(lambda, 1.0);
}

}  // namespace

void project(const Cone& cone, const double* y, double* out) {
  if (cone.interval) {
    out[0] = std::clamp(y[0], cone.lower, cone.upper);
    return;
  }
  if (cone.is_ball) {
    const double length = norm(y, cone.tangential);
    const double factor = length > cone.radius ? cone.radius / length : 1;
    for (int i = 0; i < cone.tangential; ++i) out[i] = factor * y[i];
    return;
  }
  const Face at = face(cone, y);
  for (std::size_t g = 0; g < at.groups.size(); ++g) {
    const ConeGroup& group = at.groups[g];
    const double limit = group.coefficient * at.n;
    const double factor = at.n <= 0 || limit <= 0 ? 0 : at.at_limit[g] ? limit / at.length[g] : 1;
    for (int i = group.offset; i < group.offset + group.size; ++i) out[i] = factor * y[i];
  }
  out[0] = at.n;
}

void projection_modes(const Cone& cone, const double* y, ProjectionModes& out) {
  out.count = 0;
  if (cone.interval) {
    if (y[0] >= cone.lower && y[0] <= cone.upper && cone.lower < cone.upper) append_unit(0, out);
    return;
  }
  if (cone.is_ball) {
    const double length = norm(y, cone.tangential);
    if (length > cone.radius) return append_rotations(cone, length, y, out);
    for (int i = 0; i < cone.tangential && cone.radius > 0; ++i) append_unit(i, out);
    return;
  }
  const Face at = face(cone, y);
  if (at.n <= 0) return;
  append_ray(at, y, out);
  for (std::size_t g = 0; g < at.groups.size(); ++g) {
    const ConeGroup& group = at.groups[g];
    if (group.coefficient <= 0) continue;
    if (at.at_limit[g]) {
      append_rotation(group, at.length[g], at.n, y, out);
    } else {
      for (int i = group.offset; i < group.offset + group.size; ++i) append_unit(i, out);
    }
  }
}

void projection_jacobian(const Cone& cone, const double* y, double* out) {
  ProjectionModes modes;
  projection_modes(cone, y, modes);
  const int n = cone.size();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < static_cast<std::size_t>(modes.count); ++k) {
        sum += modes.lambda[k] * modes.q[k][static_cast<std::size_t>(i)] * modes.q[k][static_cast<std::size_t>(j)];
      }
      out[i * n + j] = sum;
    }
  }
}

}  // namespace gelenk

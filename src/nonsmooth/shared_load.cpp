// SPDX-License-Identifier: BSD-3-Clause
#include "nonsmooth/shared_load.h"

#include <algorithm>
#include <cmath>

#include "decomposition/singular_values.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Singular values below this fraction of the largest are rounding.
constexpr double rank_threshold = 1e-11;
// Entries of directions and of their effects that are rounding, relative to the largest; and forces.
constexpr double no_effect = 1e-9;
constexpr double no_force = 1e-9;
// Of a limit of friction: more than decisions leave.
constexpr double beyond = 1e-6;
// How far beyond what counts as contact with it a limit still acts.
constexpr double reach = 1e4;

double largest(const VectorXd& x) { return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff(); }

// One direction.
class Exchange {
 public:
  Exchange(const SharedLoads& of, Index k)
      : of_(of),
        r_(of.directions.col(k)),
        joints_(of.joints.col(k)),
        effect_(of.effects.col(k)),
        force_(std::max(largest(of.x), largest(of.held))) {}

  bool takes_part(const SharedLoads::Point& point) const {
    return std::abs(r_[point.normal]) > no_effect * largest(r_);
  }
  bool joins_any() const { return largest(joints_) > no_effect * largest(r_); }
  bool moves() const { return largest(effect_) > no_effect * largest(r_) * of_.largest_effect; }
  int lock() const {
    Index at = 0;
    joints_.cwiseAbs().maxCoeff(&at);
    return of_.locks[static_cast<std::size_t>(at)];
  }

  // Whether forces that act now may become less in favor of others, this way (1) or the other (-1). Where all would
  // have to grow, they are a prestress without a cause.
  bool is_possible(int way) const {
    bool relieves = false;
    for (const SharedLoads::Point& point : of_.points) {
      const double change = way * r_[point.normal];
      if (std::abs(change) <= no_effect * largest(r_) || change > 0) continue;
      if (of_.x[point.normal] <= no_force * force_) return false;
      relieves = true;
    }
    for (Index i = 0; i < joints_.size(); ++i) {
      const double change = way * joints_[i];
      if (std::abs(change) <= no_effect * largest(joints_)) continue;
      const DirectedLimit& may = of_.may[static_cast<std::size_t>(i)];
      const double room = change > 0 ? may.positive - of_.held[i] : may.negative + of_.held[i];
      if (!(room > no_force * force_)) return false;
      relieves = relieves || (change * of_.held[i] < 0 && std::abs(of_.held[i]) > no_force * force_);
    }
    return relieves;
  }

  // The contact that holds only as the joints press on it: with the least forces of these, it would slide.
  const SharedLoads::Point* held_by_pressure() const {
    const double square = joints_.squaredNorm();
    double amount = -of_.held.dot(joints_) / square;
    for (const SharedLoads::Point& point : of_.points) {  // which must not pull
      const double r = r_[point.normal];
      if (!takes_part(point)) continue;
      const double until = -std::max(0.0, of_.x[point.normal]) / r;
      amount = r > 0 ? std::max(amount, until) : std::min(amount, until);
    }
    for (const SharedLoads::Point& point : of_.points) {
      if (point.size == 0 || !takes_part(point)) continue;
      const double normal = of_.x[point.normal] + amount * r_[point.normal];
      const auto friction = of_.x.segment(point.first, point.size) + amount * r_.segment(point.first, point.size);
      if (friction.norm() > (1 + beyond) * point.coefficient * std::max(0.0, normal) + beyond * force_) return &point;
    }
    return nullptr;
  }

 private:
  const SharedLoads& of_;
  VectorXd r_, joints_, effect_;
  double force_;
};

}  // namespace

MatrixXd directions_without_effect(const MatrixXd& G) {
  std::vector<Index> others;
  const double size = G.size() == 0 ? 0 : G.cwiseAbs().maxCoeff();
  std::vector<Index> alone;
  for (Index j = 0; j < G.cols(); ++j) {
    const bool is_zero = !(G.col(j).cwiseAbs().maxCoeff() > rank_threshold * size);
    (is_zero ? alone : others).push_back(j);
  }
  MatrixXd combined;
  if (!others.empty()) {
    MatrixXd rest(G.rows(), static_cast<Index>(others.size()));
    for (Index k = 0; k < rest.cols(); ++k) rest.col(k) = G.col(others[static_cast<std::size_t>(k)]);
    const SingularValues found(rest);
    combined = found.V.rightCols(rest.cols() - found.rank(rank_threshold));
  }
  MatrixXd out = MatrixXd::Zero(G.cols(), static_cast<Index>(alone.size()) + combined.cols());
  for (std::size_t k = 0; k < alone.size(); ++k) out(alone[k], static_cast<Index>(k)) = 1;
  for (std::size_t k = 0; k < others.size() && combined.cols() > 0; ++k)
    out.row(others[k]).tail(combined.cols()) = combined.row(static_cast<Index>(k));
  return out;
}

std::optional<SharedLoad> find_shared_load(const SharedLoads& of) {
  for (Index k = 0; k < of.directions.cols(); ++k) {
    const Exchange exchange(of, k);
    if (!exchange.joins_any()) continue;
    if (const SharedLoads::Point* const point = exchange.held_by_pressure())
      return SharedLoad{point->contact, exchange.lock()};
    const auto slides = [&](const SharedLoads::Point& point) { return point.slides && exchange.takes_part(point); };
    const auto point = std::ranges::find_if(of.points, slides);
    if (point == of.points.end() || !exchange.moves()) continue;
    if (exchange.is_possible(1) || exchange.is_possible(-1)) return SharedLoad{point->contact, exchange.lock()};
  }
  return std::nullopt;
}

DirectedLimit largest_holding_forces(const SwitchingForces& forces, int lock) {
  if (forces.hold_coordinate(lock) || forces.engagement(lock) > 0)
    return {.positive = unlimited, .negative = unlimited};
  const DirectedLimit friction = forces.sticking_limit(lock);
  // Against a motion in the negative direction friction is positive.
  DirectedLimit out{.positive = friction.negative, .negative = friction.positive};
  if (forces.lock(lock).limit < 0) return out;
  const auto touches = [&](int side) {
    const SwitchingForces::Depth at = forces.depth(lock, side);
    return at.depth >= -reach * at.tolerance;
  };
  if (touches(1)) out.negative = unlimited;
  if (touches(-1)) out.positive = unlimited;
  return out;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/hidden_contacts.h"

#include <algorithm>
#include <array>

#include "collision/contacts.h"
#include "contact_geometry/contact_finder.h"
#include "math/bounds.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

// Of accelerations estimated by the change of velocities in the step: what they may be in between.
constexpr double acceleration_margin = 2;
// Error of interpolated positions, relative to the way that the accelerations cause: where a gap comes as near to zero
// as that, the step is made up to there to see. As for other events (event/step_course.cpp).
constexpr double interpolation_error = 0.05;
// Penetrations of less depth may remain unnoticed [natural units of length]: what touches so slightly leaves with a
// speed that errors of any step change as much.
constexpr double noticed_depth = 1e-8;
// Positions that are looked at in a step; and the fraction of it that must be safe if they do not suffice, for the step
// to be shortened.
constexpr int most_samples = 100;
constexpr double least_fraction = 1. / 8;

// Whether a distance with gaps g0 and g1 at the ends of a time h and a second derivative of at most `acceleration`
// stays positive.
bool bends_little(double g0, double g1, double h, double acceleration) {
  return std::sqrt(g0) + std::sqrt(g1) >= h * std::sqrt(acceleration / 2);
}

// The corners of a shape without round ones, or the centers of its round ones, in its link.
std::vector<Tip> corners_of(const LinkShape& shape) {
  std::vector<Tip> out = tips_of(*shape.is);
  for (Tip& corner : out) corner.center = shape.X_LS.point(corner.center);
  return out;
}

}  // namespace

HiddenContacts::HiddenContacts(const Mechanism& mechanism, Dynamics& dynamics, ContactEquations& contact_equations)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      contact_equations_(contact_equations),
      pairs_(static_cast<std::size_t>(contact_equations.candidates().pairs())),
      samples_(most_halvings),
      qdot0_(static_cast<std::size_t>(mechanism.nq)),
      qdot1_(qdot0_.size()),
      q_(qdot0_.size()) {
  const ContactCandidates& candidates = contact_equations.candidates();
  for (int i = 0; i < candidates.count(); ++i) {
    const ContactCandidate& candidate = candidates[i];
    Pair& pair = pairs_[static_cast<std::size_t>(candidate.pair)];
    pair.core_link = candidate.core_link;
    pair.tip_link = candidate.tip_link;
    pair.core_center = candidate.X_LS.p;
    pair.tip_center = candidate.X_tip.p;
    pair.tip_is_smaller = candidates.tip_is_smaller(candidate.pair);
    if (candidate.kind == ContactCandidate::Kind::corner || candidate.kind == ContactCandidate::Kind::edges) {
      if (!pair.is_sharp()) {
        pair.core = corners_of(mechanism.shapes[static_cast<std::size_t>(candidate.core)]);
        pair.tip = corners_of(mechanism.shapes[static_cast<std::size_t>(candidate.tip)]);
      }
    } else if (candidate.is_given()) {
      pair.is_apart = true;
    } else if (candidate.turns()) {
      pair.normal = candidate.core_axis / std::sin(candidate.swing);  // its gap is linear in the end of the other axis
    } else if (candidate.box.half_space || candidate.kind == ContactCandidate::Kind::rim) {
      pair.normal = candidate.X_LS.R.col(2);
    } else {
      pair.curvature = std::max(pair.curvature, 1 / (candidate.radius + candidate.box.radius));
    }
  }
  unsafe_.reserve(pairs_.size());
  for (Sample* sample : {&first_, &last_}) sample->gaps.resize(pairs_.size());
  for (Sample& sample : samples_) sample.gaps.resize(pairs_.size());
}

// Of a pair at the position read last; infinite if it has sharp features and is closed.
void HiddenContacts::gap(int pair, Gap& out) const {
  const ContactCandidates& candidates = contact_equations_.candidates();
  const ContactCandidates::Range range = candidates.range(pair);
  out.size = unlimited;
  if (range.first == range.last || pairs_[static_cast<std::size_t>(pair)].is_apart) return;
  const auto mode = [&](int candidate) -> const CandidateMode& {
    return contact_equations_.modes()[static_cast<std::size_t>(candidate)];
  };
  const Pair& of = pairs_[static_cast<std::size_t>(pair)];
  if (of.is_sharp()) {
    for (int i = range.first; i < range.last; ++i) {
      if (mode(i).closed) return;
    }
    const Pose3& X_core = candidates.pose(of.core_link);
    const Pose3& X_tip = candidates.pose(of.tip_link);
    out.X = X_core.inverse() * X_tip;
    if (!candidates.is_close(range.first)) {
      double rate = 0;  // not used
      out.size = candidates.distance(range.first, rate);
      out.n = (out.X.point(of.tip_center) - of.core_center).normalized();
      return;
    }
    const ContactCandidate& candidate = candidates[range.first];
    std::array<ContactPoint, max_contact_points> points;
    const int count =
        find_contacts(*mechanism_.shapes[static_cast<std::size_t>(candidate.core)].is, X_core * candidate.X_LS,
                      *mechanism_.shapes[static_cast<std::size_t>(candidate.tip)].is, X_tip * candidate.X_tip,
                      unlimited, points.data());
    for (int k = 0; k < count; ++k) {
      const ContactPoint& point = points[static_cast<std::size_t>(k)];
      if (!(point.gap < out.size)) continue;
      out.size = point.gap;
      out.n = X_core.R.transpose() * point.normal;
    }
    return;
  }
  if (!candidates.is_close(range.first)) {
    double rate = 0;  // not used
    out.size = candidates.distance(range.first, rate);
    return;
  }
  for (int i = range.first; i < range.last; ++i) {
    if (!mode(i).closed) out.size = std::min(out.size, candidates.gap(i) + mode(i).leaves_from);
  }
}

// At an end of the step.
void HiddenContacts::read(int pair, int end) {
  Pair& of = pairs_[static_cast<std::size_t>(pair)];
  const ContactCandidates& candidates = contact_equations_.candidates();
  if (of.moves_tip()) of.tip_at[end] = candidates.approach(pair, true);
  if (of.moves_core()) of.core_at[end] = candidates.approach(pair, false);
}

// What overlaps already can touch no more: how deep it gets is watched elsewhere (ContactModes::find_penetration).
void HiddenContacts::begin() {
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    Gap& now = pairs_[i].gaps[0];
    gap(static_cast<int>(i), now);
    if (now.size < -noticed_depth) now.size = unlimited;
    if (now.size < unlimited) read(static_cast<int>(i), 0);
  }
}

// Of what happens across a plane only that along its normal counts. The way of a center that velocities at the ends do
// not explain shows turns within the step; the points of a shape turn with its angular velocity, and where it turns
// about an axis outside, so does the velocity of its center.
HiddenContacts::Bounds HiddenContacts::bound(const Pair& pair, const ContactCandidates::Approach& a,
                                             const ContactCandidates::Approach& b) const {
  const bool is_plane = !pair.normal.isZero(0);
  const auto along = [&](const Eigen::Vector3d& x) { return is_plane ? std::abs(pair.normal.dot(x)) : x.norm(); };
  const auto across = [&](const Eigen::Vector3d& w) { return is_plane ? pair.normal.cross(w).norm() : w.norm(); };
  const auto speed = [&](const ContactCandidates::Approach& at) { return along(at.v) + across(at.w) * at.arm; };
  const auto turning = [&](const ContactCandidates::Approach& at) {
    return across(at.w) * (at.w.norm() * at.arm + at.v.norm());
  };
  const double change = along(b.v - a.v) + across(b.w - a.w) * a.arm;
  const double unexplained = along(b.p - a.p - h_ / 2 * (a.v + b.v));
  Bounds out;
  out.acceleration = (acceleration_margin * change + 8 * unexplained / h_) / h_ + std::max(turning(a), turning(b));
  out.speed = std::max(speed(a), speed(b)) + h_ / 2 * out.acceleration;
  return out;
}

bool HiddenContacts::is_safe(const Pair& pair, const Gap& a, const Gap& b, double h) const {
  const Bounds& bounds = pair.tip_is_smaller ? pair.tip_bounds : pair.core_bounds;
  const double g0 = std::max(0.0, a.size) + noticed_depth;
  const double g1 = std::max(0.0, b.size) + noticed_depth;
  if (g0 + g1 > h * bounds.speed) return true;
  if (pair.is_sharp()) return stays_apart(pair, a, a, b, h) || stays_apart(pair, b, a, b, h);
  return bends_little(g0, g1, h, bounds.acceleration + pair.curvature * bounds.speed * bounds.speed);
}

// Whether the plane normal to the gap `at`, fixed to one of the shapes, separates them in all of the time h.
bool HiddenContacts::stays_apart(const Pair& pair, const Gap& at, const Gap& a, const Gap& b, double h) {
  const auto separates = [h](const Eigen::Vector3d& normal, const std::vector<Tip>& fixed,
                             const std::vector<Tip>& moving, const Pose3& X0, const Pose3& X1, double acceleration) {
    double plane = -unlimited;
    for (const Tip& corner : fixed) plane = std::max(plane, normal.dot(corner.center) + corner.radius);
    return std::ranges::all_of(moving, [&](const Tip& corner) {
      const double g0 = normal.dot(X0.point(corner.center)) - corner.radius - plane;
      const double g1 = normal.dot(X1.point(corner.center)) - corner.radius - plane;
      return g0 > -noticed_depth && g1 > -noticed_depth &&
             bends_little(std::max(0.0, g0) + noticed_depth, std::max(0.0, g1) + noticed_depth, h, acceleration);
    });
  };
  if (separates(at.n, pair.core, pair.tip, a.X, b.X, pair.tip_bounds.acceleration)) return true;
  const Eigen::Vector3d to_core = -(at.X.R.transpose() * at.n);
  return separates(to_core, pair.tip, pair.core, a.X.inverse(), b.X.inverse(), pair.core_bounds.acceleration);
}

bool HiddenContacts::is_safe(const Sample& a, const Sample& b) const {
  return std::ranges::all_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    return is_safe(pairs_[i], a.gaps[i], b.gaps[i], (b.s - a.s) * h_);
  });
}

double HiddenContacts::find(double t0, const double* y0, double t1, const double* y1) {
  unsafe_.clear();
  h_ = t1 - t0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    Pair& pair = pairs_[i];
    if (!(pair.gaps[0].size < unlimited)) continue;
    gap(static_cast<int>(i), pair.gaps[1]);
    if (!(pair.gaps[1].size < unlimited)) continue;
    read(static_cast<int>(i), 1);
    if (pair.moves_tip()) pair.tip_bounds = bound(pair, pair.tip_at[0], pair.tip_at[1]);
    if (pair.moves_core()) pair.core_bounds = bound(pair, pair.core_at[0], pair.core_at[1]);
    const Bounds& bounds = pair.tip_is_smaller ? pair.tip_bounds : pair.core_bounds;
    pair.error_bound = interpolation_error * bounds.acceleration * h_ * h_ / 8;
    if (!is_safe(pair, pair.gaps[0], pair.gaps[1], h_)) unsafe_.push_back(static_cast<int>(i));
  }
  if (unsafe_.empty()) return unlimited;
  q0_ = y0;
  q1_ = y1;
  dynamics_.set_position(y0);
  dynamics_.qdot_from_v(y0, y0 + mechanism_.nq, qdot0_.data());
  dynamics_.qdot_from_v(y1, y1 + mechanism_.nq, qdot1_.data());
  first_.s = 0;
  last_.s = 1;
  for (const int pair : unsafe_) {
    const auto i = static_cast<std::size_t>(pair);
    first_.gaps[i] = pairs_[i].gaps[0];
    last_.gaps[i] = pairs_[i].gaps[1];
  }
  samples_left_ = most_samples;
  const double s = search(first_, last_, 0);
  dynamics_.set_position(y1);
  dynamics_.set_velocity(y1 + mechanism_.nq);
  contact_equations_.candidates().read_motion(dynamics_);
  return s < 1 ? t0 + s * h_ : unlimited;
}

// Interpolates the position, and writes the gaps there.
void HiddenContacts::look_at(double s, Sample& out) {
  const double r = 1 - s;
  for (std::size_t k = 0; k < q_.size(); ++k) {
    q_[k] = r * r * (1 + 2 * s) * q0_[k] + s * s * (3 - 2 * s) * q1_[k] + s * r * h_ * (r * qdot0_[k] - s * qdot1_[k]);
  }
  dynamics_.normalize(q_.data());
  dynamics_.set_position(q_.data());
  contact_equations_.candidates().read_position(dynamics_);
  out.s = s;
  for (const int pair : unsafe_) gap(pair, out.gaps[static_cast<std::size_t>(pair)]);
}

// Whether something penetrates, or comes so near between a and b that it may.
bool HiddenContacts::may_touch(const Sample& a, const Sample& at, const Sample& b) const {
  return std::ranges::any_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    const double gap = at.gaps[i].size;
    if (gap < -touch_tolerance) return true;
    return gap < a.gaps[i].size && gap < b.gaps[i].size && gap < pairs_[i].error_bound;
  });
}

// Whether nothing is closer at b than at a, but for rounding: what leaves without a speed hardly moves at first.
bool HiddenContacts::separates(const Sample& a, const Sample& b) const {
  return std::ranges::all_of(unsafe_, [&](int pair) {
    const auto i = static_cast<std::size_t>(pair);
    return b.gaps[i].size > a.gaps[i].size - touch_tolerance;
  });
}

// The first fraction of the step at which something may touch between a and b; 1: nothing does. What has just left is
// so near that bounds of speeds would permit no step; in one of the smallest parts it is seen to continue to leave.
double HiddenContacts::search(const Sample& a, const Sample& b, int halvings) {
  if (is_safe(a, b)) return 1;
  if (samples_left_ == 0) return a.s >= least_fraction ? a.s : 1;
  if (halvings == most_halvings) return separates(a, b) ? 1 : b.s < 1 ? b.s : a.s;
  --samples_left_;
  Sample& middle = samples_[static_cast<std::size_t>(halvings)];
  look_at((a.s + b.s) / 2, middle);
  if (const double s = search(a, middle, halvings + 1); s < 1) return s;
  if (may_touch(a, middle, b)) return middle.s;
  return search(middle, b, halvings + 1);
}

}  // namespace gelenk

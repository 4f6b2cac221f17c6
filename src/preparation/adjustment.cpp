// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/adjustment.h"

#include <algorithm>
#include <cmath>

#include "assembly/frame_adjustment.h"
#include "math/rotations.h"
#include "mechanism/mechanism.h"
#include "preparation/start.h"
#include "scene/locking_elements.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Reduces a scene without planar reduction and distance constraints, which would remove the redundancy to be examined.
ReducedScene reduce_in_space(const Scene& scene) {
  Scene literal = scene;
  for (const Reduction pass : {Reduction::planar, Reduction::massless}) {
    literal.solver.reductions[static_cast<std::size_t>(pass)] = false;
  }
  erase_locking_elements(literal);  // so that all cuts are joints
  return reduce(literal);
}

BodyFrame& half(Scene& scene, const FrameMove& move) {
  Joint& joint = scene.joints[move.scene_joint];
  return move.child ? joint.child : joint.parent;
}

// Moves a frame of the scene. Its axes may be rotated with respect to those in which the move is given.
void apply(const ReducedScene& reduced, int island, const FrameMove& move, Scene& scene) {
  BodyFrame& frame = half(scene, move);
  const Pose3 X_LF = place(scene, reduced, island, frame).X_LB;
  const Eigen::Matrix3d R = X_LF.R.transpose() * move.X_given.R;
  frame.X_BF.p += frame.X_BF.R * (R * move.X_move.p);
  frame.X_BF.R = orthonormalized(Eigen::Matrix3d(frame.X_BF.R * R * move.X_move.R * R.transpose()));
}

constexpr double max_tolerance_ratio = 100;  // of a tolerance that gives more degrees of freedom to the smallest one

double size_of_move(const MovedFrame& frame) { return std::max(frame.turn, frame.shift); }

}  // namespace

AdjustedScene adjust(const Scene& scene, double tolerance) {
  AdjustedScene out{.scene = scene, .moved = {}};
  const ReducedScene reduced = reduce_in_space(scene);
  std::vector<FrameMove> moves;
  for (int i = 0; i < static_cast<int>(reduced.islands.size()); ++i) {
    const Mechanism& mechanism = reduced.islands[i];
    if (mechanism.cuts.empty()) continue;
    const FrameAdjustment found = adjust_frames(mechanism, start_guesses(scene, reduced, i).tree.q, tolerance);
    const bool closes =
        found.outcome == FrameAdjustment::Outcome::as_given || found.outcome == FrameAdjustment::Outcome::adjusted;
    out.closes = out.closes && closes;
    out.degrees_of_freedom += found.degrees_of_freedom;
    for (const FrameMove& move : found.moves) {
      moves.push_back(move);
      if (closes) apply(reduced, i, move, out.scene);
    }
  }
  std::ranges::sort(moves, {}, [](const FrameMove& m) { return 2 * m.scene_joint + (m.child ? 1 : 0); });
  for (const FrameMove& move : moves) {
    out.moved.push_back({scene.joints[move.scene_joint].name, half(out.scene, move).body, move.turn, move.shift});
  }
  return out;
}

double sufficient_tolerance(const Scene& scene, double from, double max_tolerance) {
  double sufficient = 0;
  int degrees_of_freedom = -1;
  for (int decade = static_cast<int>(std::ceil(std::log10(from))); decade <= std::lround(std::log10(max_tolerance));
       ++decade) {
    const double tolerance = std::pow(10.0, decade);
    if (tolerance <= from) continue;
    if (sufficient > 0 && tolerance > 1.01 * max_tolerance_ratio * sufficient) break;
    const AdjustedScene found = adjust(scene, tolerance);
    if (!found.closes || found.moved.empty() || found.degrees_of_freedom <= degrees_of_freedom) continue;
    sufficient = tolerance;
    degrees_of_freedom = found.degrees_of_freedom;
  }
  return sufficient;
}

std::string describe_moves(const Scene& scene, const std::vector<MovedFrame>& moved) {
  if (moved.empty()) return {};
  const auto largest_move = std::ranges::max_element(moved, {}, size_of_move);
  const auto n = static_cast<int>(moved.size());
  return std::to_string(n) + (n == 1 ? " joint frame was" : " joint frames were") +
         " moved so that the loops close at every position; the largest displacement is that of " +
         largest_move->joint + " in " + largest_move->body + ", " + text::rounded(largest_move->turn, 2) + " rad and " +
         text::rounded(largest_move->shift * scene.units.size_of("m"), 2) + " m";
}

}  // namespace gelenk

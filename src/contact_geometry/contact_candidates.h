// SPDX-License-Identifier: BSD-3-Clause
// The candidates at which shapes of a mechanism can touch, each with a gap that is a smooth function of time: the tips
// of one shape on the core of another (shape/rounded.h), corners on faces, edges on edges, rims on planes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "contact_geometry/contact_candidate.h"
#include "contact_geometry/feature_states.h"
#include "dynamics/dynamics.h"

namespace gelenk {

struct LinkFriction;
struct Swing;

// Motion of the tip's link relative to the core's, about the origin of the root frame; the acceleration is that without
// generalized accelerations.
struct RelativeMotion {
  Spatial::Motion V, A;

  Eigen::Vector3d velocity(const Eigen::Vector3d& p) const { return V.v + V.w.cross(p); }
  // The rate of velocity(p), where p moves.
  Eigen::Vector3d acceleration(const Eigen::Vector3d& p, const Eigen::Vector3d& p_dot) const {
    return A.v + A.w.cross(p) + V.w.cross(p_dot);
  }
  // The rate of the rate of a gap; turns: of an angle.
  double normal_acceleration(const CandidateState& at, bool turns) const {
    if (turns) return at.n.dot(A.w) + at.n_dot.dot(V.w);
    return at.n.dot(acceleration(at.p, at.p_dot)) + at.n_dot.dot(velocity(at.p));
  }
};

class ContactCandidates {
 public:
  // located: otherwise there are none.
  ContactCandidates(const Mechanism& mechanism, bool located);

  int count() const { return static_cast<int>(candidates_.size()); }
  const ContactCandidate& operator[](int candidate) const { return candidates_[static_cast<std::size_t>(candidate)]; }

  // Reads the present position of `dynamics`, and its velocity and bias accelerations.
  void read_position(Dynamics& dynamics);
  void read_motion(Dynamics& dynamics);

  // After read_position(): whether the balls about the two shapes meet, without which nothing touches; after
  // read_motion(), otherwise: their distance and its rate, shown by the first candidate of a pair alone.
  bool is_close(int candidate) const { return pair_of(candidate).is_close; }
  bool shows_distance(int candidate) const { return pair_of(candidate).first == candidate; }
  double distance(int candidate, double& rate) const;

  // Pairs of shapes, and their candidates.
  int pairs() const { return static_cast<int>(pairs_.size()); }
  struct Range {
    int first = 0, last = 0;  // candidate; the one after the last
  };
  Range range(int pair) const;
  // After read_motion(): the motion of one shape of a pair, that with the tips or the core, as seen from the other one,
  // in the frame of its link: that of the origin of the shape's frame, and its angular velocity.
  struct Approach {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();  // m: that origin
    Eigen::Vector3d v = Eigen::Vector3d::Zero();  // m/s
    Eigen::Vector3d w = Eigen::Vector3d::Zero();  // rad/s
    double arm = 0;  // m: the largest distance of its points from that origin; infinite if it is not bounded
  };
  // Of a swing: of the end of the tip's axis, as if it were a point at the distance 1 from the joint.
  Approach approach(int pair, bool of_tip) const;
  // Whether the shape with the tips is that whose points are nearer to the origin of its frame.
  bool tip_is_smaller(int pair) const;
  // After read_position(): of a link, in the root frame.
  const Pose3& pose(int link) const { return poses_[static_cast<std::size_t>(link)]; }
  // After read_position(). Of a feature beyond its ends, as if it were longer.
  double gap(int candidate) const;
  // How far the point of contact is from the ends of a feature, negative beyond them; positive for what has none.
  double margin(int candidate) const;
  // Whether this feature is where the shapes touch if their gap is zero.
  bool is_near(int candidate) const;
  // After read_motion().
  CandidateState state(int candidate) const;
  RelativeMotion motion(int candidate) const;
  // A vector fixed to the link of the second surface, and its rate, both in the root frame.
  Eigen::Vector3d belt(int candidate, const Eigen::Vector3d& velocity, Eigen::Vector3d& rate) const;

 private:
  // Two shapes in balls, the second with the tips.
  struct Pair {
    int first = 0;  // candidate
    int core_link = 0, tip_link = 0;
    Eigen::Vector3d core, tip;                       // centers in their links [m]
    double reach = INFINITY;                         // m: sum of the radii
    double core_arm = INFINITY, tip_arm = INFINITY;  // m: largest distances of points from the centers
    bool is_close = true;
  };
  const Pair& pair_of(int candidate) const { return pairs_[static_cast<std::size_t>((*this)[candidate].pair)]; }
  Eigen::Vector3d between(const Pair& pair) const;
  void begin_pair(const Mechanism& mechanism, int tip, int core);
  using Line = features::Line<double>;
  // ContactCandidates of the tips of one shape on the core of another; both: numbers of shapes.
  void add_shapes(const Mechanism& mechanism);
  void add_pair(const Mechanism& mechanism, int contact, int tip, int core);
  void add_edges(const Mechanism& mechanism, int contact, int tip, int core);
  void add_rims(const Mechanism& mechanism, int contact, int tip, int core);
  void add_swing(const Swing& swing);
  void add_friction(const LinkFriction& friction);
  ContactCandidate& add_without_shapes(ContactCandidate::Kind kind, int core_link, int tip_link, int contact);
  ContactCandidate candidate_between(const Mechanism& mechanism, int contact, int tip, int core);
  void add_corner(const ContactCandidate& candidate);
  Line line(const ContactCandidate& candidate) const;
  Eigen::Vector3d center(const ContactCandidate& candidate) const;      // of the tip, in S
  Eigen::Vector3d way_to_tip(const ContactCandidate& candidate) const;  // ContactCandidate::way, in S
  // An edge of a shape, which has several candidates.
  struct PlacedEdge {
    int pair = 0, link = 0;
    SolidEdge edge;  // in the link
    // In the root frame, where the shapes of the pair are close.
    Eigen::Vector3d center, direction;
    std::array<Eigen::Vector3d, 2> normals;  // of a sharp edge
    Eigen::Vector3d outward;                 // their sum
  };
  int place_edge(int link, const SolidEdge& edge);
  const PlacedEdge& placed_edge(int i) const { return edges_[static_cast<std::size_t>(i)]; }
  using Crossing = features::Crossing<double>;
  Crossing crossing(const ContactCandidate& candidate) const;
  // To the nearest end of an edge; negative beyond it [m].
  static double left(const ContactCandidate& candidate, const Crossing& at);
  static double margin(const ContactCandidate& candidate, const Crossing& at);
  bool is_outside(const ContactCandidate& candidate, const Crossing& at) const;
  bool is_near(const ContactCandidate& candidate, const Crossing& at) const;
  features::Lowest<double> lowest(const ContactCandidate& candidate) const;
  features::PairMotion<double> pair_motion(const ContactCandidate& candidate) const;
  const Pose3& core_pose(const ContactCandidate& candidate) const {
    return candidate.has_shapes() ? core_poses_[static_cast<std::size_t>(candidate.core)] : pose(candidate.core_link);
  }
  const Spatial::Motion& velocity(int link) const { return V_[static_cast<std::size_t>(link)]; }

  std::vector<ContactCandidate> candidates_;
  std::vector<Pair> pairs_;
  std::vector<PlacedEdge> edges_;
  std::vector<int> links_;              // with shapes
  std::vector<Pose3> poses_;            // by link, in the root frame
  bool has_position_ = false;           // what follows from the poses does
  std::vector<int> cores_;              // candidates of all shapes that are cores, one of each
  std::vector<Pose3> core_poses_;       // by shape, in the root frame: of these
  std::vector<Spatial::Motion> V_, A_;  // by link, in and about the root frame
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Equations of motion with closed contacts between events. In its mode, each closed candidate has a normal force and,
// where friction holds, tangential forces and moments that keep relative accelerations zero; where it does not hold,
// friction opposes the motion in proportion to the normal force. With the rows R of what is kept, and B = R^T + D^T,
// where D has what slips,
//
//   M vdot + J^T lambda = f + B x,    J vdot = gamma,    R vdot = -(rates of R) v
//
// is solved for x by the small matrix R K^-1 B, K^-1 the response of the mechanism with its constraint equations.
// Redundant forces are those of least norm. Friction of joints is that of a contact whose normal force is given: there
// is no normal row in R, and its multiplier is known.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "contact_geometry/contact_candidates.h"
#include "element/contacts/contact.h"
#include "linear/least_norm.h"
#include "nonsmooth/rounding.h"

namespace gelenk {

// Groups of components of a contact, as in cone/cone.h: tangential forces, moment about the normal, rolling moments.
inline constexpr int contact_groups = 3;

struct CandidateMode {
  struct Group {
    bool moves = false;
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // of the motion, in the root frame, while it moves

    bool operator==(const Group&) const = default;
  };

  bool closed = false;
  double leaves_from = 0;  // m: depth up to which shapes that still touch may separate; 0: they do not touch
  std::array<Group, contact_groups> groups{};

  bool operator==(const CandidateMode&) const = default;
};

// Speeds far above those by which differences are taken, up to which directions are kept then [natural units].
inline constexpr double slow_sliding = 1e-4;

class ContactEquations {
 public:
  // All must outlive it. laws: by contact of the scene. located: otherwise there are no candidates.
  ContactEquations(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<ContactLaw>& laws, bool located);

  ContactCandidates& candidates() { return candidates_; }
  const ContactCandidates& candidates() const { return candidates_; }
  const ContactLaw& law(int candidate) const;
  // Largest force or moment of a group per normal force.
  double coefficient(int candidate, int group, bool moves) const;
  const std::vector<CandidateMode>& modes() const { return modes_; }
  void set_modes(const std::vector<CandidateMode>& modes);
  // See EventSource.
  void keep_directions_below(double speed) { no_direction_ = speed; }
  std::span<const int> closed() const { return closed_; }

  // --- the rows of some candidates, after set_position() and set_velocity() of `dynamics` ---
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  struct Entry {
    int candidate = 0;
    CandidateState at;
    Eigen::Matrix3d axes;                               // the normal and two tangential axes, in columns
    int first = 0;                                      // its normal row
    std::array<int, contact_groups> rows{};             // first row of each group that is kept; -1: there is none
    std::array<int, contact_groups> moving{};           // row of S of each group that moves; -1: it does not
    std::array<Eigen::Vector3d, contact_groups> slip;   // relative motions
    std::array<Eigen::Vector3d, contact_groups> along;  // directions of those that move

    int tangential = 2;     // components of the first group; 3: in all directions
    bool is_given = false;  // the normal force: its row is empty, and its multiplier known

    int kept(int group) const { return group == 1 ? 1 : group == 0 ? tangential : 2; }
    // Direction of a component of a group.
    Eigen::Vector3d axis(int group, Eigen::Index k) const {
      return axes.col((group == 1 || kept(group) == 3 ? 0 : 1) + k);
    }
    bool is_at_rest() const {
      return at.rate == 0 && std::ranges::all_of(slip, [](const Eigen::Vector3d& of) { return of.isZero(0); });
    }
    bool any_moves() const {
      return std::ranges::any_of(moving, [](int row) { return row >= 0; });
    }
  };
  struct Rows {
    std::vector<Entry> entries;
    RowMatrix R;               // kept relative velocities, by velocity
    RowMatrix S;               // relative velocities of what moves, along its direction
    RowMatrix D;               // forces of what moves, by entry and velocity, for a normal force of 1
    Eigen::VectorXd demanded;  // velocities of belts: kept are R v + demanded = 0
    Eigen::VectorXd rates;     // relative accelerations without generalized ones: of R, of S
    Eigen::VectorXd moving_rates;
    bool any_moves() const { return S.rows() > 0; }
  };
  // by_modes: otherwise nothing moves, and all groups have rows.
  void build(std::span<const int> candidates, const std::vector<CandidateMode>& modes, bool by_modes, Rows& out);
  // Z <- K^-1 F^T, F by rows, with the last factors of `dynamics`; by velocity and row.
  void respond(const RowMatrix& F, RowMatrix& Z);

  // Derivatives by differences. From begin_differences(), after accelerate() at a state, slow sliding keeps its
  // direction, which small changes of the state could reverse; record_difference() follows accelerate() at a state of
  // which component k differs by dy; and end_differences(), after accelerate() at the first state again, adds the
  // effect of the directions to the derivatives of vdot (nv rows, components in columns). vdot: at the first state;
  // elapsed [s]: of the step. Sliding that begins is as fast as it becomes in this time: iterations of a step begin
  // with the speed at its start, where directions turn infinitely fast, and would leave them as they are.
  void begin_differences(int components, const double* vdot, double elapsed);
  void record_difference(int k, double dy);
  void end_differences(Eigen::Ref<Eigen::MatrixXd> vdot_y);
  // No differences have been taken: where a run is restored, those of a later time say nothing.
  void forget_differences() { differenced_slips_.clear(); }
  // Whether something slid at quite another speed, or in another direction, at the last accelerate() than at the last
  // begin_differences().
  bool slides_otherwise() const;
  // Adds the effect of closed contacts to the vdot of the last solve() of `dynamics`. again: that solve() has applied
  // the forces of the last call as loads; what is left is added to them. Returns by how much they have changed,
  // relative to the largest.
  double accelerate(double* vdot, bool again = false);
  // Forces of the last accelerate(), by closed candidate, distributed so that where they are redundant, friction is in
  // proportion to normal forces.
  struct CandidateForce {
    double normal = 0;                          // N
    std::array<double, contact_groups> held{};  // N, N m: of the groups that are kept
    Eigen::Vector3d force, moment;              // on the tip, in the root frame
  };
  const std::vector<CandidateForce>& forces() { return forces_of(shared()); }
  // The same of other multipliers x of the rows, with the same effect.
  const std::vector<CandidateForce>& forces_of(const Eigen::VectorXd& x);
  // Whether those of the last accelerate() are unique; and whether a contact would have to pull or to hold more than it
  // can, too.
  bool are_unique() const { return closed_.empty() || least_norm_.was_unique(); }
  bool are_overloaded() const;
  const Rows& rows() const { return rows_; }
  // Of the last accelerate(): its multipliers x, the responses K^-1 B to them, and the matrix R K^-1 B with the weights
  // of the norm of x.
  struct Solution {
    const Eigen::VectorXd& x;
    const RowMatrix& responses;
    const Eigen::MatrixXd& G;
    const Eigen::VectorXd& weights;
  };
  Solution last_solution() const { return {x_, Z_, G_, scale_}; }
  // Displaces q so that closed contacts have no gap; returns whether it was necessary.
  bool close_position(double* q);
  // Changes v by the least amount in the mass metric so that what is kept does not move; `dynamics` must be at the
  // position.
  void close_velocity(double* v);

 private:
  // The force of candidates of which it is given [N, N m].
  double given_normal(const Entry& entry) const { return entry.is_given ? law(entry.candidate).given_normal : 0; }
  Eigen::Vector3d moving_direction(const Entry& entry, int group, const std::vector<CandidateMode>& modes) const;
  void number_rows(const std::vector<CandidateMode>& modes, bool by_modes, Rows& out) const;
  void set_group(const std::vector<CandidateMode>& modes, int group, const RelativeMotion& motion, Entry& entry,
                 Rows& out);
  void add_row(const Entry& entry, const Eigen::Vector3d& d, bool turns, double* out) const;
  double weight(const Entry& entry, int group) const;
  void solve_for_forces(double* vdot, bool again);
  bool is_in_solved_modes() const;
  bool stops_all(Eigen::Index rank) const;
  void add_holding_forces(const Eigen::VectorXd& x);
  const Eigen::VectorXd& shared();
  Eigen::VectorXd constrained_response(const Eigen::VectorXd& force);

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  const std::vector<ContactLaw>& laws_;
  ContactCandidates candidates_;
  std::vector<CandidateMode> modes_;
  std::vector<int> closed_;
  // A motion so slow that differences cannot show how its direction turns.
  struct SlowMotion {
    std::size_t entry = 0, group = 0;
    Eigen::Vector3d slip;        // at the first state
    Eigen::Vector3d across;      // unit: where the direction turns to
    Eigen::Vector3d turns_with;  // unit: a slip velocity along it turns the direction
    double speed = 0;            // for which it turns
  };
  // Of the last accelerate(): what was closed, the modes of that, and its result.
  std::vector<int> solved_closed_;
  std::vector<CandidateMode> solved_modes_;
  std::vector<double> vdot_;
  long solved_at_ = -1;  // Dynamics::solution() of it; -1: none that can be repeated
  double no_direction_ = rest_speed;
  bool keeps_directions_ = false;
  std::vector<CandidateMode> modes_before_;
  std::vector<SlowMotion> slow_;
  std::vector<Eigen::Vector3d> differenced_slips_;  // by candidate and group
  Eigen::MatrixXd turning_;                         // by slow motion and component: derivatives of its velocity across
  Rows rows_, kept_;
  RowMatrix B_, Z_;
  std::vector<double> zero_;
  Eigen::MatrixXd G_, weighted_;
  Eigen::VectorXd x_, right_, given_, scale_, force_, weights_, shared_;
  bool shared_is_current_ = false;
  LeastNormSolver least_norm_, sharing_;
  // To remove gaps or velocities of what is closed, in matrices that keep their sizes between events.
  struct Closing {
    explicit Closing(double threshold) : solver(threshold) {}
    RowMatrix N, Z;
    Eigen::MatrixXd G;
    Eigen::VectorXd left, x, change;
    LeastNormSolver solver;
  };
  void close(const RowMatrix& N, Closing& of);
  Closing closing_gaps_, closing_speeds_;
  std::vector<double> holding_;  // by lock
  std::vector<CandidateForce> forces_;
};

// At the last accelerate(), by closed(): whether what is held permits no motion along the normal, so that the contact
// has no force.
inline bool is_blocked(const ContactEquations& equations, std::size_t i) {
  if (equations.rows().entries[i].is_given) return false;
  const int normal = equations.rows().entries[i].first;
  return equations.last_solution().G(normal, normal) == 0;
}

// Whether a row permits no motion, of which the product with its response, of these lengths, is rounding.
inline bool is_blocked(double product, double row, double response) {
  constexpr double cosine = 1e-12;
  return !(std::abs(product) > cosine * row * response);
}

// x <- the multipliers of normal forces that are given. given: by row.
void set_given_forces(const ContactEquations::Rows& rows, const Eigen::VectorXd& given, Eigen::VectorXd& x);

// Adds forces of closed candidates to `out`, by link (ContactRows::apply_forces).
void add_wrenches(const ContactEquations& contact_equations,
                  const std::vector<ContactEquations::CandidateForce>& forces, std::vector<Spatial::Force>& out);

}  // namespace gelenk

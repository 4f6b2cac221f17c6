// SPDX-License-Identifier: BSD-3-Clause
// The time-stepping scheme of Moreau and Jean (Jean 1999; Acary & Brogliato 2008, ch. 10): one step of length h of a
// mechanism whose velocities may jump. With the middle position q_m = q + h/2 v,
//
//   M (v' - v) = h f(q_m, (v + v')/2) + J^T Lambda + R^T x,     q' = q_m + h/2 v'
//
// where the impulses x of contacts, joint friction and limits solve a cone complementarity problem for the velocities
// at the end of the step; loops are eliminated exactly (dynamics/contact_rows.h). Times of events are not located: the
// scheme is of order 1 where velocities jump, and of order 2 elsewhere. What penetrates is moved apart by the smallest
// displacement in the mass metric, which does not change velocities.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "complementarity/cone.h"
#include "complementarity/parts_of_problem.h"
#include "complementarity/rest_first.h"
#include "contact_geometry/contact_finder.h"
#include "dynamics/dynamics.h"
#include "nonsmooth/restitution.h"
#include "time_stepping/contact_state.h"
#include "time_stepping/delassus_operator.h"
#include "time_stepping/free_rotation.h"
#include "time_stepping/impulse_accuracy.h"
#include "time_stepping/joint_rows.h"
#include "time_stepping/load_iteration.h"
#include "time_stepping/position_correction.h"
#include "time_stepping/recorded_problem.h"

namespace gelenk {

class TimeStepper final : public ContactReadings {
 public:
  // All must outlive it. loads: with the laws of contacts.
  TimeStepper(const Mechanism& mechanism, Dynamics& dynamics, const Loads& loads, ImpulseAccuracy accuracy);
  ~TimeStepper();
  TimeStepper(const TimeStepper&) = delete;
  TimeStepper& operator=(const TimeStepper&) = delete;

  // Advances y by h; `dynamics` must have the targets of the middle of the step, of which u are the inputs. Returns
  // false if the result is not finite or the velocities do not converge; see failure().
  bool step(double h, const double* u, double* y) { return step_in_parts(h, u, y, 0); }
  const char* failure() const { return failure_; }

  // Forgets all impulses; or how points have moved in the last step, which was a trial.
  void forget();
  void forget_motion() { state_.step = 0; }
  // The forces of the last step, means over it.
  const ContactState& state() const { return state_; }
  // The accelerations by all other forces at the mean velocity of the last step.
  const std::vector<double>& smooth_accelerations() const { return vdot_; }
  // Memories of the last step, from which the next one starts: of a step that may be repeated, and of a second run.
  enum class Memory { kept, second };
  void copy_to(Memory memory) {
    (memory == Memory::kept ? kept_ : second_) = state_;
    has_second_ = has_second_ || memory == Memory::second;
  }
  void forget_second() { has_second_ = false; }
  void exchange_with(Memory memory) { std::swap(memory == Memory::kept ? kept_ : second_, state_); }
  // Of the last step; gap(): at the present position of `dynamics`, after set_root_poses().
  Eigen::Vector3d force(int contact) const override { return state_.sums[static_cast<std::size_t>(contact)].force; }
  int mode(int contact) const override { return state_.sums[static_cast<std::size_t>(contact)].mode; }
  double gap(int contact) override;
  // Of the points of the last step that are still near each other.
  std::vector<ContactForce> forces() override;

  // How the cone problems of the communication step have been solved.
  struct Solved {
    double residual = 0;  // the largest that was left [natural units of speed]
    int iterations = 0;   // the most for one problem
  };
  const Solved& solved() const { return solved_; }
  // What approaches although it touches, at the end of a step since the last begin_part(): its impulses have not been
  // found, as where a body rests on one of 1e-10 of its mass.
  struct Missed {
    int contact = -1;   // of the scene; -1: none
    double speed = 0;   // natural units
    double excess = 0;  // relative to the speed that is permitted
  };
  const Missed& missed() const { return missed_; }
  const JointRows& joints() const { return joints_; }
  // Where to append the problems that are solved; null: nowhere.
  void record(std::vector<RecordedProblem>* to) { recorded_ = to; }
  // At the start of each part of a communication step; continues: of a later one.
  void begin_part(bool continues) {
    missed_ = {};
    if (!continues) solved_ = {};
  }
  // Steps in which points have opened or closed, begun or ceased to slide.
  long changes() const { return changes_; }
  void serialize(Archive& archive);

 private:
  friend class SharedImpulses;
  void reserve();
  bool converge(double h, const double* u, bool last);
  bool attempt(double h, const double* u, double* y, bool last);
  double change() const;
  double small_change(double part) const;
  bool step_in_parts(double h, const double* u, double* y, int halvings);
  enum class Forces { as_before, changed, too_fast };
  Forces update_forces(double h, const double* u, double most_turned);
  bool respond(double h, const double* u, LoadIteration::Holding holding);
  bool respond_to_smooth_forces(double h);
  class LoadedStep;
  bool settle_loads(double h, const double* u, LoadIteration::Holding holding);
  void apply_mean_forces(double h, const double* u);
  Spatial::Force force_at(std::size_t i, double h) const;
  void add_wrench(const NearPoint& point, const Spatial::Force& on_b, std::vector<Spatial::Force>& out) const;
  void collect(double h);
  void add_contact(const NearPoint& point, double h);
  void add_passed_limits(double h);
  std::span<Cone> joint_cones() { return std::span<Cone>(cones_).subspan(points_.size()); }
  std::array<std::vector<double>*, 9> all_by_row() {
    return {&b_, &x_, &speeds_, &free_speeds_, &belts_, &compression_, &least_, &after_, &displacing_};
  }
  void set_friction(double h);
  bool stop_turning_points(double h);
  Eigen::Vector3d slip(std::size_t point, const std::vector<double>& speeds) const;
  double approach(std::size_t cone) const;
  void find_strikes(double h);
  bool remains_struck(std::size_t cone) const;
  void find_compression();
  void reduce_restitution(double h);
  double gained_energy(std::span<const std::pair<int, int>> part);
  void set_belts();
  double opening(double gap, const RememberedContact& before, double h) const;
  Restitution::Struck restitution_of(std::size_t cone) const;
  void set_velocities(double h);
  void add_gaps(double h);
  void guess(double h);
  double fastest() const;
  double velocity_tolerance() const;
  void solve_impulses();
  void solve(const std::vector<Cone>& cones, std::vector<double>& x);
  bool may_remain_at_rest() const;
  ConeResult solve_for(const std::vector<Cone>& cones, std::vector<double>& x, bool may_rest = false);
  bool misses(double residual) const;
  bool may_be_prestressed() const;
  void relieve();
  struct Gap {
    double gap = 0;  // m, rad
    int sign = 0;    // of its rate for a positive speed of the row; 0: the row has no gap
  };
  Gap gap_of(std::size_t cone) const;
  bool find_corrections(double h, JointRows::Hold hold);
  void correct_position(double h, double* dq);
  void remember(double h);
  void find_missed(double h);

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  const Loads& loads_;
  ImpulseAccuracy accuracy_;
  ContactRows& rows_;
  ContactFinder finder_;
  FreeRotation rotation_;
  DelassusOperator operator_;
  std::unique_ptr<ConeSolver> solver_;
  RestFirst rest_first_;
  ContactState state_, kept_, second_;
  bool has_second_ = false;
  std::vector<RememberedContact> last_contacts_;  // those before the last step
  long changes_ = 0;
  Solved solved_;
  Missed missed_;
  std::vector<RecordedProblem>* recorded_ = nullptr;

  std::vector<NearPoint> points_;        // of this step
  std::vector<Eigen::Matrix3d> frames_;  // by point: normal and tangential axes, in columns
  enum class Turning : char { no, may_be_held, turns };
  std::vector<Turning> turning_;  // by point
  std::vector<double> opens_;     // by point: by how much curvature opens its gap in a step, if it persists [m]
  JointRows joints_;              // their cones follow those of points
  std::vector<Cone> cones_;
  std::vector<double> b_, x_, speeds_, free_speeds_;
  std::vector<char> strikes_;  // by cone: it takes part in an impact within the step
  Restitution restitution_;    // of what takes part
  PartsOfProblem parts_;       // by which energy is judged
  bool strikes_any_ = false, has_compression_ = false;
  double last_residual_ = 0;                 // of the last cone problem
  std::vector<double> belts_;                // by row: their velocities
  std::vector<double> compression_, least_;  // by row: impulses of Poisson's law, where it applies
  std::vector<Cone> compression_cones_;
  std::vector<double> after_, relieved_;
  PositionCorrection correction_;
  std::vector<double> displacing_;  // by row: impulses of its displacement
  std::vector<double> v0_, v1_, vm_, vdot_, vdot_before_, dq_;
  std::vector<std::vector<double>> starts_;  // of a step and its halves
  // Friction that depends on loads: iterations for its limits, and the forces that act with it.
  LoadIteration loads_iteration_;
  std::vector<LoadIteration::Limit> limit_kinds_;
  std::vector<double> limits_, load_along_, load_x_, load_vdot_;
  std::vector<Spatial::Force> load_wrenches_;
  const char* failure_ = "";
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// An island whose states an integrator outside advances. The modes of its equations are held, and events found, as in
// the steps of the own methods (event/locator.h): StepCourse says what has changed since the step began. A step ends
// where the integrator declares it completed, and at events.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "event/step_course.h"
#include "formulation/dependent_coordinates.h"
#include "simulation/island.h"

namespace gelenk {

class ExchangedIsland {
 public:
  // Where a state x of the simulation is in y = (q, v, element states): y[entry] = x / size, size with the user's sign.
  // speed: the velocity of a coordinate that is not of a quaternion, of which the first one has that of three; or -1.
  struct Slot {
    std::size_t state = 0;
    int entry = 0;
    double size = 1;
    int speed = -1;
    bool begins_quaternion = false;
  };
  ExchangedIsland(Island& of, std::vector<Slot> slots, const Independent& independent);

  // Goes to these states x of the simulation at t [s], and closes the loops from where the step began. Returns false if
  // that fails, where these states do not determine the position; it is then nowhere.
  bool go_to(double t, const double* x);
  // After go_to() has failed: a state that the loops determine there; -1: unknown.
  int blocked_state();
  // After go_to() failed: the states are farther from where the step began than it looks for a way.
  bool is_too_far() const { return is_too_far_; }
  // Brings angles of joints that close loops to their turns, for outputs.
  void count_turns();
  // Writes the rates of the states in the mode that is held, by state of the simulation. Throws IntegrationError.
  void rates(double* xdot);
  int indicators() const { return static_cast<int>(course_.size()); }
  // With the signs of the mode that is held where they are zero within rounding.
  void indicator_values(double* z);

  // The step ends at the present state, where the next one begins. Returns whether an event must happen there first.
  bool complete_step();
  // The event at the present state: impacts, other modes. A step begins there. Writes the states that have jumped to x,
  // and returns whether there are any. Throws IntegrationError.
  bool pass_event(double* x);
  // The time of the next known break of a function of time [s]; infinite: none.
  double next_break() const { return stretch_end_; }

  // Beside the data of the island. Call continue_from_base() when both have been read.
  void serialize(Archive& archive);
  void continue_from_base();

 private:
  void set_target(const double* x);
  void put(double part, double* y) const;
  bool close(double* y);
  void find_change();
  void evaluate();
  void end_course();
  void accept();
  bool take_jump();
  void begin_step();
  bool write_jumps(bool normalizes, double* x);
  bool needs_normalization() const;

  Island& island_;
  std::vector<Slot> slots_;
  int nq_, nv_;
  std::unique_ptr<DependentCoordinates> dependent_;  // null: there are no loops
  StepCourse course_;
  std::vector<double> base_;                    // y where the step began
  std::vector<double> target_, before_, ydot_;  // target_: the states as they were set
  std::vector<char> modes_;
  Eigen::VectorXd change_;
  double base_time_ = 0, stretch_end_ = INFINITY;
  bool is_begun_ = false;    // the first event has passed
  bool has_jumped_ = false;  // where the last completed step ended, velocities have changed
  bool is_too_far_ = false;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Scene: what a scene file says, as plain data. Everything in SI units, angles in radians, until it is converted
// (unit_system.h).
//
// A scene that came out of read_scene (read.h) is valid: names resolve, numbers are finite, inertias
// are possible, every body is connected to the ground, arrays have the sizes their joint kind asks for.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "math/spatial.h"
#include "scene/unit_system.h"

namespace gelenk {

inline constexpr const char* ground = "ground";  // the body that stands still; its frame is the world W

// A frame fixed in a body.
struct BodyFrame {
  std::string body = ground;
  Pose3 X_BF;  // pose in the body's frame
};

struct Body {
  std::string name;
  double mass = 0;                                    // kg
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      // m, in the body's frame B
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // kg m2 about the centre of mass, along B's axes
  std::optional<Pose3> pose;                          // X_WB in the reference configuration (`at:` joints)
};

// Start values of a joint. Sizes are the kind's nq and nv; what the file does not give is a free guess.
struct JointStart {
  std::vector<double> q, v;
  std::vector<bool> q_given, v_given;  // named in the file
  std::vector<bool> q_fixed, v_fixed;  // to be kept exactly; only given values can be
  // Of guesses: how much a squared change counts in the sum that assembly makes small [1/rad2, 1/m2, (s/rad)2, (s/m)2].
  std::vector<double> q_weight, v_weight;
};

// Pushes back while the joint's coordinate q lies beyond a bound, and never pulls: with the depth beyond it,
// max(0, stiffness depth + damping d depth/dt). Units of a revolute (prismatic) joint.
struct Stop {
  double lower = -std::numeric_limits<double>::infinity();  // rad (m); infinite: no bound
  double upper = std::numeric_limits<double>::infinity();   // likewise
  double stiffness = 0;                                     // N m/rad (N/m), more than 0
  double damping = 0;                                       // N m s/rad (N s/m)
};

struct Joint {
  std::string name;
  std::string type;                   // a name in the joint registry
  std::vector<Eigen::Vector3d> axes;  // unit vectors in the joint frame; as many as the kind has
  BodyFrame parent, child;
  JointStart start;
  // Per speed, nv each, zeros where the file is silent: tau = -stiffness (q - spring_reference) - damping v.
  std::vector<double> damping, stiffness, spring_reference;
  std::optional<Stop> stop;  // of kinds with one freedom
};

// Applies torque (force) tau = gear_ratio * input to its joint and adds gear_ratio^2 * rotor_inertia to the
// joint's inertia. The rotor's gyroscopic effect on the bodies is neglected.
struct Motor {
  std::string name;
  std::string joint;
  double gear_ratio = 1;     // motor angle / joint angle (prismatic: motor travel / joint travel)
  double rotor_inertia = 0;  // kg m2 at the motor side (prismatic: kg)
};

enum class ForceType {
  spring_damper,  // between two points: tension stiffness (L - length) + damping dL/dt
  wrench,         // force and torque on a body at a point
};

struct Force {
  std::string name;
  ForceType type = ForceType::spring_damper;
  // spring_damper
  BodyFrame from, to;    // only positions matter
  double stiffness = 0;  // N/m
  double damping = 0;    // N s/m
  double length = 0;     // m, free length
  // wrench
  BodyFrame at;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // N m
  bool in_body = false;                              // components along the body's axes; else the world's
  bool input = false;                                // also an FMU input f[1..3], t[1..3], added to the constants above
};

// A coordinate of a joint as a function of time t [s], or its speed alone. In the user's sense; rad or m.
struct GivenMotion {
  enum class Source {
    function,     // polynomial and sine, one on the other
    table,        // a cubic spline; before its first and after its last point it goes on with the speed there
    speed,        // no more than the speed, which is constant
    input,        // an FMU input is the coordinate
    input_speed,  // an FMU input is the speed
  };
  Source source = Source::function;
  std::vector<double> polynomial;                  // c0 + c1 t + c2 t^2 + ...
  double amplitude = 0, frequency = 0, phase = 0;  // + amplitude sin(2 pi frequency t + phase); Hz, rad
  std::vector<double> times, values;               // of the table; times ascend
  bool periodic = false;                           // the table: last and first value are the same
  double speed = 0;

  bool is_input() const { return source == Source::input || source == Source::input_speed; }
  // Only the speed is given: where it starts is open.
  bool speed_only() const { return source == Source::speed || source == Source::input_speed; }
};

enum class ConstraintType {
  motion,      // a coordinate follows a given motion
  gear,        // phi_joint - phi_carrier = ratio (phi_other - phi_carrier) + offset
  rack,        // s_joint = ratio phi_other + offset, the ratio being the pinion's radius
  rolling,     // a wheel, a thin disc, rolls on a plane without slip
  knife_edge,  // a point does not slide along an axis of its body
};

// What has to hold beyond what joints do.
struct Constraint {
  std::string name;
  ConstraintType type = ConstraintType::motion;
  std::string joint;           // motion, gear; rack: the prismatic one
  std::string other, carrier;  // joints; carrier: of a gear, or empty
  std::string coordinate;      // motion: which of the joint's coordinates
  GivenMotion motion;
  double ratio = 1, offset = 0;  // gear: -, rad; rack: m, m
  // rolling: the wheel's centre, z any; knife_edge: the edge. Axis: of the wheel; along which the edge does not slide.
  BodyFrame at;
  BodyFrame on;                                     // the plane, z its normal; knife_edge: only its body counts
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  // unit vector in `at`
  double radius = 0;                                // m
};

enum class SensorType {
  reaction,  // wrench of a joint on its child body at M, resolved in F: f[1..3], t[1..3]
  frame,     // pose and velocity of a frame: r[1..3], Q[1..4], v[1..3] in the world, w[1..3] in the frame
  energy,    // kinetic, potential (gravity, springs and stops), total
};

struct Sensor {
  std::string name;
  SensorType type = SensorType::frame;
  std::string joint;  // reaction
  BodyFrame frame;    // frame
};

struct Experiment {
  double stop = 1;          // s
  double step = 1e-3;       // s
  double tolerance = 1e-6;  // relative; absolute per radian, metre, rad/s, m/s
};

// What makes the model smaller than the scene (mechanism/). Each can be switched off, to compare.
enum class Reduction {
  weld,            // bodies welded together become one
  fixed,           // "static": bodies that cannot move become part of the ground
  cut_choice,      // loops are cut where that leaves the fewest rows and quaternions
  planar,          // what moves in a plane is computed in the plane
  redundant_rows,  // rows that repeat others at every position are left out
  islands,         // parts without coupling are solved apart
  outputs,         // only what somebody reads is computed
  massless,        // rods without mass become a distance between their ends
};
inline constexpr int reduction_count = 8;

struct Solver {
  std::string formulation = "projection";
  std::string integrator = "auto";   // of words::integrators
  std::string start = "as_given";    // of words::starts
  double step = 0;                   // s, of fixed-step methods; 0: chosen from experiment.step
  int max_evaluations = 10'000'000;  // of the equations of motion of an island in one communication step
  int corrections = 0;               // of projection after each step: so many, no more and no less; 0: until closed
  double rho_inf = 0.8;              // of generalized-alpha and hht: spectral radius at infinite frequency
  // 1/s, of the formulation baumgarte: J vdot = gamma - 2 alpha J v - beta^2 Phi; 0: chosen from the step
  double baumgarte_alpha = 0;
  double baumgarte_beta = 0;
  std::array<bool, reduction_count> reductions = {true, true, true, true, true, true, true, true};

  bool reduces(Reduction pass) const { return reductions[static_cast<std::size_t>(pass)]; }
};

// Of what a scene has been freed of, since no wanted output depends on it: the sizes that natural units are chosen by
// (unit_system.h), so that what is left is solved in the units of the whole.
struct LeftOut {
  double length = 0;  // m: largest of its bodies
  double travel = 0;  // m: largest distance at which things stand
  double mass = 0;    // kg: of its heaviest body
};

// How far numbers may be off that were rounded, and how the loops are closed all the same.
struct AssemblySettings {
  // rad, and the unit of length that the scene is solved in: how far a frame may be moved so that loops with redundant
  // constraints close exactly; 0: none is moved by more than what loops may gape by.
  double tolerance = 0;
};

struct Scene {
  std::string file;  // for messages; empty if the scene was not read from a file
  std::string name = "Mechanism";
  UnitSystem units;                                   // of the numbers here
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s2
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Motor> motors;
  std::vector<Force> forces;
  std::vector<Constraint> constraints;
  std::vector<Sensor> sensors;
  std::vector<std::string> parameters;  // paths the FMU exposes, "crank.mass"
  std::vector<std::string> outputs;  // names and patterns of the outputs that are wanted (wanted_outputs.h); none: all
  std::optional<LeftOut> left_out;
  bool is_wanted_part = false;  // nothing more can be left out (mechanism/wanted_part.h); not in files
  AssemblySettings assembly;
  Experiment experiment;
  Solver solver;
};

// The inputs of motors and wrenches, behind which those of motions come.
int load_input_count(const Scene& scene);

// Everything that is wrong with a scene, one finished line each: "file: path: found ..., expected ...".
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<std::string> lines);
  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

}  // namespace gelenk

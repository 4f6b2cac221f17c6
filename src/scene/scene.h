// SPDX-License-Identifier: BSD-3-Clause
// Scene: what a scene file says, as plain data. Everything in SI units, angles in radians, until it is converted
// (unit_system.h).
//
// A scene that came out of read_scene (read.h) is valid: names resolve, numbers are finite, inertias
// are possible, every body is connected to the ground, arrays have the sizes their joint kind asks for.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "element/registry.h"
#include "joint/registry.h"
#include "math/spatial.h"
#include "scene/unit_system.h"

namespace gelenk {

struct Body {
  std::string name;
  double mass = 0;                                    // kg
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      // m, in the body's frame B
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // kg m2 about the centre of mass, along B's axes
  std::optional<Pose3> pose;                          // X_WB in the reference configuration (`at:` joints)

  // Its inertia is a matrix, and read apart.
  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Body::mass>({.name = "mass",
                            .unit = "kg",
                            .text = "mass",
                            .variable = "m",
                            .range = Range::not_negative,
                            .required = true}),
        field<&Body::com>({.name = "com", .unit = "m", .text = "centre of mass in the body's frame"})};
    return all;
  }
};

// Start values of a joint. Sizes are the kind's nq and nv; what the file does not give is a free guess.
struct JointStart {
  std::vector<double> q, v;
  std::vector<bool> q_given, v_given;  // named in the file
  std::vector<bool> q_fixed, v_fixed;  // to be kept exactly; only given values can be
  // Of guesses: how much a squared change counts in the sum that assembly makes small [1/rad2, 1/m2, (s/rad)2, (s/m)2].
  std::vector<double> q_weight, v_weight;
};

struct Joint {
  std::string name;
  std::string type;                   // a name in the joint registry
  std::vector<Eigen::Vector3d> axes;  // unit vectors in the joint frame; as many as the kind has
  BodyFrame parent, child;
  JointStart start;
  AnyJoint is;                     // of that type, with these axes and its own numbers
  std::vector<JointForces> along;  // by speed: what acts along it

  // Nothing acts along it.
  bool is_idle() const {
    for (const JointForces& forces : along) {
      if (!gelenk::is_idle(forces)) return false;
    }
    return true;
  }
};

// An element of a section: of one of its kinds, at frames and joints in the order of the kind's ports. A joint that is
// optional and not given is empty.
struct ElementPlace {
  std::string name;
  std::vector<BodyFrame> frames;
  std::vector<std::string> joints;
  std::string coordinate;  // of the first joint, where the element is about one
};
template <class Any>
struct Element : ElementPlace {
  Any is;
};
using Motor = Element<AnyMotor>;
using Force = Element<AnyForce>;
using Constraint = Element<AnyConstraint>;
using Sensor = Element<AnySensor>;

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
  int max_events = 10'000;           // likewise, before the step is given up
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

// The elements of all sections, in the order of the sections and the file: visit(section, element).
struct Section {
  std::string_view name;         // in scene files
  std::string_view description;  // for the schema
  std::string_view usual = {};   // the type of what names none; empty: it must
};
inline constexpr Section motors_section = {"motors", "Motors, each an input.", "drive"};
inline constexpr Section forces_section = {"forces", "Springs, dampers, loads."};
inline constexpr Section constraints_section = {
    "constraints", "What has to hold beyond what joints do: given motions, gears, rolling."};
inline constexpr Section sensors_section = {"sensors", "Outputs beyond the joints' states."};

// Their places in the order of each_section().
namespace sections {
inline constexpr int motors = 0, forces = 1, constraints = 2, sensors = 3;
}

template <class S, class Visit>
void each_section(S& scene, Visit&& visit) {
  visit(motors_section, scene.motors);
  visit(forces_section, scene.forces);
  visit(constraints_section, scene.constraints);
  visit(sensors_section, scene.sensors);
}

// Everything that is wrong with a scene, one finished line each: "file: path: found ..., expected ...".
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<std::string> lines);
  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

}  // namespace gelenk

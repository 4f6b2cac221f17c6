// SPDX-License-Identifier: BSD-3-Clause
// Scene: the contents of a scene file as plain data. Quantities are in SI units and radians until they are converted
// (unit_system.h).
//
// A scene returned by read_scene_json (read.h) is valid: names resolve, numbers are finite, inertias are physically
// possible, every body is connected to the ground, and arrays have the sizes that their joint kind requires.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "element/forces/gravity_force.h"
#include "element/joint_forces/coordinate_force.h"
#include "element/kinds.h"
#include "joint/kinds.h"
#include "math/spatial.h"
#include "scene/element_place.h"
#include "scene/metadata.h"
#include "scene/reduction.h"
#include "scene/unit_system.h"
#include "shape/kinds.h"
#include "util/stored.h"

namespace gelenk {

// A shape fixed in a body or in the ground, whose frame is the world frame then.
struct BodyShape {
  std::string name;
  Stored<AnyShape> is;
  Pose3 X_BS;           // of the shape's frame in the body's
  std::string surface;  // to which contacts refer; empty: it touches nothing
};

struct Body {
  std::string name;
  double mass = 0;                                    // kg
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      // m, in the body's frame B
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // kg m2, about the center of mass, along B's axes
  std::optional<Pose3> pose;                          // X_WB in the reference configuration (`at:` joints)
  std::vector<BodyShape> shapes;

  // All fields but the inertia matrix, which is read separately.
  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Body::mass>({.name = "mass",
                            .unit = "kg",
                            .text = "mass",
                            .variable = "m",
                            .range = Range::not_negative,
                            .required = true}),
        field<&Body::com>({.name = "com", .unit = "m", .text = "center of mass in the body's frame"})};
    return all;
  }
};

// Start values of a joint; the sizes are the kind's nq and nv. Values that the file does not give are free guesses.
struct JointStart {
  std::vector<double> q, v;
  std::vector<bool> q_given, v_given;  // given in the file
  std::vector<bool> q_set;             // set as parameters after the file was read; empty: none
  std::vector<bool> q_fixed, v_fixed;  // kept exactly by assembly; only given values can be fixed
  // Weights of guesses: factors of the squared changes in the sum that assembly minimizes [1/rad2, 1/m2, (s/rad)2,
  // (s/m)2].
  std::vector<double> q_weight, v_weight;
};

struct Joint {
  std::string name;
  std::string type;                   // name in the joint registry
  std::vector<Eigen::Vector3d> axes;  // unit vectors in the joint frame; their number is given by the kind
  BodyFrame parent, child;
  JointStart start;
  Stored<AnyJoint> is;                     // joint of that type, with these axes and its own parameters
  std::vector<Stored<JointForces>> along;  // forces along each velocity, such as springs, dampers and stops

  // The group of an element that can keep one of its coordinates at rest (element/locking.h); empty: there is none.
  std::string_view locking_element() const;
  // True if no force acts along any of its velocities.
  bool is_idle() const;
};

template <class Any>
struct Element : ElementPlace {
  Stored<Any> is;
  std::string component{};  // of which it is a part (component_parts.h); empty: none
};
using Motor = Element<AnyMotor>;
using Force = Element<AnyForce>;
using Constraint = Element<AnyConstraint>;
using Contact = Element<AnyContact>;
using Sensor = Element<AnySensor>;
using Component = Element<AnyComponent>;

// An input that expressions read, of no element.
struct SceneInput {
  std::string name, unit, text;  // unit: in FMI's spelling; empty: none
  std::string component;         // to which it belongs (component_parts.h); empty: none
  double start = 0;
};

// A jump of a state at the instants at which a condition becomes true.
struct StateReset {
  std::string condition;  // as in the file
  Formula when;           // 1 where it is true, 0 elsewhere
  Formula to;             // the state after the jump, from all values before it

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&StateReset::when>(
            {.name = "when", .text = "condition", .required = true, .reads = FormulaReads::signals}),
        field<&StateReset::to>({.name = "to",
                                .text = "state after the jump, in SI units",
                                .required = true,
                                .reads = FormulaReads::signals})};
    return all;
  }
};

// A quantity x with a rate of its own, x' = rate, such as a current, a pressure or the integral of a controller.
struct ElementState {
  std::string name, unit, text;  // unit: in FMI's spelling; empty: none
  std::string component;         // to which it belongs; empty: none
  Formula rate;                  // of x in SI units [unit/s]
  double start = 0;
  double nominal = 0;  // size of ordinary values, for tolerances; 0: 1 in natural units
  std::vector<StateReset> resets;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&ElementState::rate>(
        {.name = "rate", .text = "rate of the state", .required = true, .reads = FormulaReads::forces})};
    return all;
  }
};

// An expression with a name: an output, and what other expressions mean by the name.
struct NamedExpression {
  std::string name, unit, text;  // unit: in FMI's spelling; empty: none
  std::string component;         // to which it belongs; empty: none
  Formula value;                 // in SI units

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&NamedExpression::value>(
        {.name = "value", .text = "value of the expression", .required = true, .reads = FormulaReads::forces})};
    return all;
  }
};

// What a component exerts along the only coordinate of a joint.
struct JointEffort {
  std::string component, joint;
  Formula value;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&JointEffort::value>({.name = "effort",
                                                                .unit = "{f}",
                                                                .text = "{torque} along {coordinate}",
                                                                .variables = variables_along,
                                                                .reads = FormulaReads::signals})};
    return all;
  }
};

// A table that expressions look up.
struct SceneTable {
  std::string name, text;
  std::shared_ptr<const expression::Table> is;
};

struct Experiment {
  double stop = 1;          // s
  double step = 1e-3;       // s
  double tolerance = 1e-6;  // relative; absolute per radian, meter, rad/s, m/s
};

struct Solver {
  std::string formulation = "projection";
  std::string integrator = "auto";      // one of words::integrators
  std::string equations = "automatic";  // one of words::equations
  std::string start = "as_given";       // one of words::starts
  double step = 0;                      // step of fixed-step methods [s]; 0: chosen from experiment.step
  // Evaluations of an island's equations of motion in a communication step. The default counts for each second, or
  // thousand steps, of longer ones.
  int max_evaluations = default_evaluations;
  static constexpr int default_evaluations = 1'000'000;
  int max_events = 10'000;        // events of an island per communication step
  int corrections = 0;            // exact number of projection iterations after each step; 0: until convergence
  double cone_tolerance = 1e-11;  // residual of the velocities of contacts, relative to the largest one
  double rho_inf = 0.8;           // spectral radius of generalized-alpha and hht at infinite frequency
  // Gains [1/s] of the formulation baumgarte, J vdot = gamma - 2 alpha J v - beta^2 Phi; 0: chosen from the step.
  double baumgarte_alpha = 0;
  double baumgarte_beta = 0;
  std::array<bool, reduction_count> reductions = {true, true, true, true, true, true, true, true, true};

  bool reduces(Reduction pass) const { return reductions[static_cast<std::size_t>(pass)]; }
};

// Sizes of the parts that were removed because no wanted output depends on them. Natural units (unit_system.h) take
// them into account, so that the rest is solved in the same units as the whole scene.
struct OmittedSizes {
  double length = 0;  // m, largest length of the removed bodies
  double travel = 0;  // m, largest distance between removed parts
  double mass = 0;    // kg, mass of the heaviest removed body
};

// Permits loops to be closed although the dimensions in the scene were rounded.
struct AssemblySettings {
  // Largest displacement of a joint frame [rad, natural units of length] by which loops with redundant constraints may
  // be made to close exactly; 0: no more than the permitted closure error.
  double tolerance = 0;
};

struct Scene {
  std::string file;  // for messages; empty if the scene was not read from a file
  std::string name = "Mechanism";
  Metadata metadata;
  UnitSystem units;                                   // units of the numbers in this scene
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s2
  std::optional<GravityField> gravity_field;          // added to it
  std::vector<FormulaNames::Constant> constants;      // of expressions, in SI units
  std::vector<SceneTable> tables;
  std::vector<SceneInput> inputs;
  std::vector<ElementState> states;
  std::vector<NamedExpression> expressions;
  std::vector<Body> bodies;
  std::vector<BodyShape> ground_shapes;
  std::vector<Joint> joints;
  std::vector<Motor> motors;
  std::vector<Force> forces;
  std::vector<Constraint> constraints;
  std::vector<Contact> contacts;
  std::vector<Sensor> sensors;
  std::vector<Component> components;
  std::vector<JointEffort> efforts;     // of components
  std::vector<std::string> parameters;  // paths of the FMU's parameters, such as "crank.mass"
  std::vector<std::string> outputs;     // names and patterns of the wanted outputs (wanted_outputs.h); empty: all
  std::optional<OmittedSizes> left_out;
  bool is_wanted_part = false;  // no part can be removed any more (mechanism/wanted_part.h); not in files
  AssemblySettings assembly;
  Experiment experiment;
  Solver solver;
};

// A section of the scene file whose entries are elements.
struct Section {
  std::string_view name;               // in scene files
  std::string_view description;        // for the schema
  std::string_view default_type = {};  // type of entries that name none; empty: the type is required
};
inline constexpr Section motors_section = {"motors", "Motors, each an input.", "drive"};
inline constexpr Section forces_section = {"forces", "Springs, dampers, loads."};
inline constexpr Section constraints_section = {
    "constraints", "Constraints in addition to those of joints: prescribed motions, gears, rolling."};
inline constexpr Section contacts_section = {
    "contacts", "Contacts between shapes: friction and restitution by pairs of surfaces.", "contact"};
inline constexpr Section sensors_section = {"sensors", "Outputs in addition to the joints' states."};
inline constexpr Section components_section = {"components",
                                               "Components with states: motors, controllers, filters, chambers."};

// Indices of the sections in the order of each_section().
namespace sections {
inline constexpr int motors = 0, forces = 1, constraints = 2, contacts = 3, sensors = 4, components = 5;
inline constexpr int joints = 6, states = 7, expressions = 8;  // after them
}  // namespace sections

// Calls visit(section, elements) for each section of elements.
template <class S, class Visit>
void each_section(S& scene, Visit&& visit) {
  visit(motors_section, scene.motors);
  visit(forces_section, scene.forces);
  visit(constraints_section, scene.constraints);
  visit(contacts_section, scene.contacts);
  visit(sensors_section, scene.sensors);
  visit(components_section, scene.components);
}

// All errors in a scene, one complete line each: "file: path: found ..., expected ...".
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<std::string> lines);
  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

}  // namespace gelenk

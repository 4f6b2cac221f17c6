// SPDX-License-Identifier: BSD-3-Clause
// The equations of a scene as expressions, recorded from the kernels that simulate it:
//   M(q) vdot + h(q, v, u) + J(q)^T lambda = 0       J(q) vdot = gamma(q, v, u)       Phi(q, u) = 0       qdot = N(q) v
// in SI units and in the user's signs, for the coordinates of the joints on the spanning trees of all islands. h
// contains all forces, also those of motors and springs.
#pragma once

#include <string>
#include <vector>

#include "expression/graph.h"
#include "kinematics/loads.h"
#include "preparation/preparation.h"
#include "scene/scene.h"

namespace gelenk {

// What equations depend on: the k-th argument is the variable k of the graph.
struct EquationArgument {
  std::string name, unit, text;
  double start = 0;
};

struct RecordedIsland;

struct SceneEquations {
  expression::Graph graph;
  std::vector<EquationArgument> q, v, u;  // arguments in this order; u: inputs, time, element states, targets
  std::vector<std::string> rows;          // by constraint equation: what it belongs to
  std::vector<std::string> states;        // the element states, among u
  std::vector<expression::Term> M, J;     // nv x nv and rows x nv, row by row
  std::vector<expression::Term> h, gamma, Phi, rate, qdot;  // rate: J v - b, of Phi
  std::vector<expression::Term> rates;                      // of the element states
  expression::Term kinetic = -1, potential = -1;
  std::vector<std::string> notes;       // sentences on what the equations leave out
  std::vector<std::string> prescribed;  // constraints that prescribe motions
  int inputs = 0;                       // the first ones of u
  bool reads_time = false;              // whether the time follows them
  double length = 1;                    // m: of the longest mechanism, to which errors of its constraints are relative
  bool has_kinks = false;               // whether an expression has branches, at which the steps of a simulation end
};

// The same numbers by the kernels that simulations run.
struct EquationValues {
  std::vector<double> M, J, h, gamma, Phi, rate, qdot, rates, vdot, lambda;
  double kinetic = 0, potential = 0;
};

class TracedScene {
 public:
  // Throws SceneError with the names of the elements of which the laws cannot be written as expressions.
  explicit TracedScene(const Scene& scene);

  const SceneEquations& equations() const { return equations_; }
  // q, v, u: as many as there are arguments. Friction slides, and stops are not touched. Throws SingularMass.
  EquationValues values(const std::vector<double>& q, const std::vector<double>& v, const std::vector<double>& u) const;

 private:
  // The arguments of an island, with the signs of the user: value of the mechanism = sign * argument.
  struct IslandArguments {
    std::vector<double> q_sign, v_sign;
    int q = 0, v = 0, row = 0;  // its first ones
    int state = 0;              // index in u of its first element state
    std::vector<int> targets;   // index in u of s, s', s'' by coordinate row; -1: 0, or the constant
    std::vector<bool> slides;   // by force with modes: whether it is friction
  };

  void name_coordinates(std::size_t island, IslandArguments& of);
  void name_inputs();
  void name_targets(std::size_t island, IslandArguments& of);
  void note_size(std::size_t island);
  void note_modes(std::size_t island, IslandArguments& of, std::vector<std::string>& refused);
  void note_contents(std::size_t island, std::vector<std::string>& refused);
  void trace(std::size_t island);
  std::vector<std::string> hidden_branches(std::size_t island, const RecordedIsland& recorded) const;
  template <class T>
  std::vector<T> targets(std::size_t island, const T* u) const;
  template <class T>
  std::vector<T> signals(std::size_t island, const T* u) const;
  void add_values(std::size_t island, const double* q, const double* v, const double* u, EquationValues& out) const;
  std::string coordinate_name(int joint, int component) const;

  Scene scene_;  // in SI units, with closed loops
  PreparedScene prepared_;
  std::vector<Loads> loads_;
  std::vector<IslandArguments> arguments_;
  std::size_t signals_ = 0;  // inputs and time
  double immobile_energy_ = 0;
  SceneEquations equations_;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// The laws of forces along joints that have modes, by number; and the coordinates on which laws of friction and of
// bounds act, which can keep them at rest ("locks").
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "dynamics/locked_coordinates.h"
#include "dynamics/switching_forces.h"
#include "kinematics/friction_loads.h"
#include "kinematics/load_kernels.h"

namespace gelenk {

template <class A>
class JointLaws {
 public:
  // The state, as far as laws depend on it. All must outlive it.
  struct State {
    const Model<A>& model;
    const Loads& loads;
    Workspace<A>& ws;
    const std::vector<double>&q, &v, &cut_reference;
  };
  using Row = typename LockedCoordinates<A>::Row;

  explicit JointLaws(const State& state) : state_(state) {
    look_along(state_.loads.tree, -1);
    for (int c = 0; c < static_cast<int>(state_.loads.cuts.size()); ++c) look_along(state_.loads.cuts[c], c);
    find_latches();
    find_inputs();
  }

  int count() const { return static_cast<int>(lock_of_.size()); }
  int locks() const { return static_cast<int>(found_.size()); }
  // The force with modes that is the latch of its coordinate; -1: it has none.
  int latch_over(int lock) const { return latches_[static_cast<std::size_t>(lock)]; }
  // Of a latch, with its inputs: above 0, engaged; 0: the force is none.
  double engagement(int force) const {
    double out = 0;
    visit(force, [&](const auto& at) {
      if constexpr (HoldsJoint<std::decay_t<decltype(at.element)>>)
        out = at.element.engagement(all_inputs() + at.input);
    });
    return out;
  }
  int lock_of(int force) const { return lock_of_[force]; }  // -1: it cannot lock
  const SwitchingForces::Lock& lock(int lock) const { return found_[lock]; }
  // Of all locks: of their speeds.
  const std::vector<Row>& rows() const { return rows_; }
  std::vector<double> signs() const {
    std::vector<double> out;
    for (const SwitchingForces::Lock& lock : found_) out.push_back(lock.sign);
    return out;
  }

  // u: all inputs of the scene, of which those of the laws are kept.
  void set_inputs(const double* u) {
    for (const int input : input_numbers_) inputs_[static_cast<std::size_t>(input)] = u[input];
  }
  std::span<double> inputs() { return inputs_; }
  std::span<const double> inputs() const { return inputs_; }
  const double* all_inputs() const { return inputs_.data(); }

  // Calls visit(force, q, v) for all forces, with the coordinates and velocities to which they refer.
  template <class Visit>
  void each(Visit visit) const {
    kernels::each_switching(state_.model, state_.loads, state_.ws, state_.q.data(), state_.v.data(),
                            state_.cut_reference.data(), visit);
  }
  // Calls visit(force) for the one with this index; -1: for none.
  template <class Visit>
  void visit(int force, Visit visit) const {
    if (force < 0) return;
    const Place& at = places_[force];
    int number = 0;
    each_list((at.cut < 0 ? state_.loads.tree : state_.loads.cuts[at.cut]).lists, [&](const auto& list) {
      if constexpr (Switches<std::decay_t<decltype(list.front().element)>>) {
        if (number++ == at.list) visit(list[at.index]);
      }
    });
  }
  // Calls visit(law, q, u) if it is friction, with its inputs, and its position if it depends on it, otherwise NaN.
  template <class Visit>
  void visit_friction(int force, Visit visit) const {
    this->visit(force, [&](const auto& at) {
      using Law = std::decay_t<decltype(at.element)>;
      if constexpr (Sticks<Law>) {
        double q = NAN;
        std::array<double, Formula::max_signals> named;
        const double* u = all_inputs() + at.input;
        if (Law::depends_on_position || at.has_formula()) q = position(at, force);
        if (at.has_formula()) u = at.take_named(all_inputs(), named.data());
        visit(at.element, q, u);
      }
    });
  }

  // Calls visit(force, cut, q, v) for each expression that has branches, with the cut along which it is (-1: the tree),
  // its coordinates and velocities.
  template <class Visit>
  void each_branching(Visit visit) const {
    const auto look = [&](const JointLoads& along, int cut, const double* q, const double* v) {
      along.each_formula([&](const auto& force) {
        if (force.element.formula().branches() > 0) visit(force, cut, q, v);
      });
    };
    look(state_.loads.tree, -1, state_.q.data(), state_.v.data());
    for (int c = 0; c < static_cast<int>(state_.loads.cuts.size()); ++c) {
      if (!state_.loads.cuts[c].has_formulas()) continue;
      const auto at = cut_motion(c);
      look(state_.loads.cuts[c], c, at.q.data(), at.v.data());
    }
  }

  // Calls visit(formula, v) for each expression of the losses of meshes that has branches, with the index of the
  // velocity of the joint of which they are friction.
  template <class Visit>
  void each_branching_loss(Visit visit) const {
    for (std::size_t r = 0; r < state_.model.coordinate_rows.size(); ++r) {
      const CoordinateRow& row = state_.model.coordinate_rows[r];
      if (!row.has_losses()) continue;
      const int v = row.terms[static_cast<std::size_t>(row.lossy_term)].v;
      MeshLosses::each(state_.loads.losses[r], [&](const Formula& formula) {
        if (formula.branches() > 0 && !MeshLosses::names_load(formula)) visit(formula, v);
      });
    }
  }

  // Of the coordinate of the force with this index, in the user's sign.
  template <class Force>
  double position(const Force& force, int index) const {
    const int cut = places_[index].cut;
    return force.sign * (cut < 0 ? state_.q[force.q] : cut_motion(cut).q[force.q]);
  }
  // The same of a cut joint is that of the last set_acceleration().
  template <class Force>
  double acceleration(const Force& force, int index, const double* vdot) const {
    return acceleration_along(force, places_[index].cut, vdot);
  }
  // cut: -1: the tree.
  template <class Force>
  double acceleration_along(const Force& force, int cut, const double* vdot) const {
    if (cut < 0) return force.sign * vdot[force.v];
    const auto at = cut_motion(cut);
    double a[max_cut_nv] = {};
    kernels::cut_accelerations<A>(state_.model.cuts[cut], state_.ws, cut, at.q.data(), at.v.data(), a);
    return force.sign * a[force.v];
  }

 private:
  auto cut_motion(int cut) const {
    return kernels::counted_cut_motion(state_.model, state_.ws, cut, state_.cut_reference.data());
  }

  void look_along(const JointLoads& joints, int cut) {
    int number = 0;
    each_list(joints.lists, [&](const auto& list) {
      if constexpr (Switches<std::decay_t<decltype(list.front().element)>>) {
        for (std::size_t i = 0; i < list.size(); ++i) {
          places_.push_back({cut, number, i});
          look(list[i], cut);
        }
        ++number;
      }
    });
  }
  template <class Force>
  void look(const Force& force, int cut) {
    using Law = std::decay_t<decltype(force.element)>;
    const int index = count();
    lock_of_.push_back(-1);
    if constexpr (Sticks<Law> || Blocks<Law> || HoldsJoint<Law>) {
      const int lock = lock_for(force, cut, Blocks<Law>);
      lock_of_.back() = lock;
      if constexpr (HoldsJoint<Law>) {
        found_[lock].latch = index;
        found_[lock].latched_joint = force.joint;
        found_[lock].latched_q = cut < 0 ? force.q : -1;
        found_[lock].is_first_of_latch = force.component == 0;
      } else if constexpr (Sticks<Law>) {
        found_[lock].frictions.push_back(index);
        found_[lock].friction = found_[lock].frictions.front();
      } else {
        found_[lock].limit = index;
        found_[lock].poisson = force.element.is_poisson();
        found_[lock].one_way = BoundsSpeed<Law>;
      }
    }
  }
  // A law that bounds its coordinate beside another one, as a one-way clutch beside a limit, has a lock of its own: it
  // may hold the coordinate in one direction where the other holds it in the other.
  template <class Force>
  int lock_for(const Force& force, int cut, bool bounds) {
    for (int nth = 0;; ++nth) {
      const auto [at, is_new] = lock_at_.try_emplace({cut, force.v, nth}, locks());
      if (is_new) {
        found_.emplace_back().sign = force.sign;
        rows_.push_back(row_of(cut, force.v));
      }
      if (!bounds || found_[at->second].limit < 0) return at->second;
    }
  }
  void find_latches() {
    latches_.assign(found_.size(), -1);
    for (const auto& [place, lock] : lock_at_) {
      const auto [cut, v, nth] = place;  // a latch is of the first lock
      latches_[static_cast<std::size_t>(lock)] = found_[static_cast<std::size_t>(lock_at_.at({cut, v, 0}))].latch;
    }
  }
  // A cut joint with friction is a revolute joint in the plane (mechanism/tree.cpp cuts no other one).
  Row row_of(int cut, int velocity) const {
    if (cut < 0) return {{velocity, 1}};
    Row out;
    for (const auto& [v, factor] : turn_of_cut_joint(state_.model, cut, state_.ws)) out.push_back({v, factor});
    return out;
  }
  // Makes room for all inputs up to the last one that a force has, or would have.
  void find_inputs() {
    int end = 0;
    const auto add = [&](const auto& force) {
      const int own = count_of(own_inputs(force.element));
      for (int i = 0; i < own; ++i) input_numbers_.push_back(force.input + i);
      end = std::max(end, force.input + own);
    };
    const auto add_named = [&](const auto& force) {
      for (int k = 0; k < force.input_count(); ++k) {
        input_numbers_.push_back(force.input_at(k));
        end = std::max(end, force.input_at(k) + 1);
      }
    };
    const auto look = [&](const JointLoads& along) {
      along.each_switching(add);
      along.each_formula(add_named);
    };
    look(state_.loads.tree);
    for (const JointLoads& on : state_.loads.cuts) look(on);
    const auto add_all = [&](const Formula& formula) {
      for (const int input : formula.signals()) {
        if (input < 0) continue;  // a force
        input_numbers_.push_back(input);
        end = std::max(end, input + 1);
      }
    };
    each_formula(std::as_const(*state_.loads.forces), [&](const Formula& formula, int) { add_all(formula); });
    for (const Formula& rate : state_.loads.rates) add_all(rate);
    for (const PlacedReset& reset : state_.loads.resets) {
      add_all(reset.when);
      add_all(reset.to);
    }
    for (const auto& motion : state_.loads.motions) {
      for (const Formula& of : motion) {
        if (of.is_given()) add_all(of);
      }
    }
    for (const MeshLosses& of : state_.loads.losses) MeshLosses::each(of, add_all);
    inputs_.resize(static_cast<std::size_t>(end) + 1);
  }

  State state_;
  struct Place {
    int cut, list;  // -1: the tree; number among the lists of forces with modes
    std::size_t index;
  };
  std::vector<Place> places_;  // by force
  std::vector<int> lock_of_;   // by force
  std::vector<SwitchingForces::Lock> found_;
  std::vector<Row> rows_;                             // by lock
  std::vector<int> latches_;                          // by lock
  std::map<std::tuple<int, int, int>, int> lock_at_;  // by cut (-1: tree), velocity and number of its locks
  std::vector<int> input_numbers_;                    // of the inputs that the laws have
  std::vector<double> inputs_;                        // by number
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/sensitivity.h"
#include "event_driven/contact_modes.h"

#include <algorithm>
#include <utility>

namespace gelenk {

using Eigen::Index;
using Eigen::MatrixXd;

Sensitivity::Sensitivity(const ReducedScene& reduced, const Islands& islands, const Outputs& readings,
                         const std::vector<Signal>& outputs, const std::vector<int>& states,
                         const std::vector<Independent>& independent, const Inputs& u)
    : reduced_(reduced), islands_(islands), readings_(readings), signals_(outputs), states_(states), u_(u) {
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const Island& island = *islands[i];
    sensitivities_.push_back(std::make_unique<ConstrainedSensitivity>(island.prepared().mechanism, island.loads(),
                                                                      island.prepared().mobility, independent[i],
                                                                      island.formulation().drives().count()));
  }
}

Sensitivity::Place Sensitivity::place(std::size_t state) const {
  const int of = states_[state];
  const Signal& signal = signals_[of];
  if (signal.joint < 0) {
    const int island = readings_.island(of);
    const Mechanism& mechanism = reduced_.islands[island];
    return {.island = island,
            .component = readings_.entry(of).index - mechanism.nq - 2 * mechanism.nv,
            .of = Place::Of::elements};
  }
  const JointPlace& joint = reduced_.joints[signal.joint];
  const bool is_coordinate = signal.level == 0;
  return {.island = joint.island,
          .component = signal.component + (is_coordinate ? joint.iq : joint.iv),
          .sign = (is_coordinate ? joint.q_sign : joint.v_sign)[signal.component],
          .of = is_coordinate ? Place::Of::coordinates : Place::Of::velocities};
}

Sensitivity::Directions Sensitivity::directions_of(int island, const MatrixXd& directions) const {
  const Mechanism& mechanism = islands_[island]->prepared().mechanism;
  const Index n = directions.cols();
  Directions out{.dq = MatrixXd::Zero(mechanism.nq, n),
                 .dv = MatrixXd::Zero(mechanism.nv, n),
                 .du = MatrixXd::Zero(islands_[island]->formulation().drives().count(), n)};
  for (std::size_t s = 0; s < states_.size(); ++s) {
    const Place at = place(s);
    if (at.island != island) continue;
    const auto row = at.sign * directions.row(static_cast<Index>(s));
    switch (at.of) {
      case Place::Of::coordinates:
        out.dq.row(at.component) = row;
        break;
      case Place::Of::velocities:
        out.dv.row(at.component) = row;
        break;
      case Place::Of::elements:
        out.du.row(static_cast<Index>(u_.signals()) + at.component) = row;
    }
  }
  const auto inputs = static_cast<Index>(u_.count());
  out.du.topRows(inputs) = directions.bottomRows(inputs);
  return out;
}

Eigen::VectorXd Sensitivity::displacement(int island, const Eigen::VectorXd& dx) {
  friction_ = FrictionTreatment::off;
  holds_contacts_ = false;
  set_point(island);
  const Mechanism& mechanism = islands_[island]->prepared().mechanism;
  MatrixXd direction = MatrixXd::Zero(dx.size() + static_cast<Index>(u_.count()), 1);
  direction.topRows(dx.size()) = dx;
  const Directions along = directions_of(island, direction);
  const Eigen::VectorXd moved = sensitivities_[island]->state_derivative(along.dq, along.dv, along.du).y.col(0);
  const auto states = static_cast<Index>(mechanism.states.size());
  Eigen::VectorXd out(mechanism.nq + mechanism.nv + states);
  out << moved.head(mechanism.nq + mechanism.nv), moved.tail(states);
  return out;
}

ConstrainedSensitivity& Sensitivity::set_point(int island) {
  current_island_ = island;
  const Island& from = *islands_[island];
  const double* y = from.reading().q;
  const EventModes::Present modes = from.formulation().modes().present(from.time(), y, friction_);
  if (modes.boundary >= 0) throw NotDifferentiablePoint(NotDifferentiablePoint::What::mode, modes.boundary);
  if (modes.edge.contact >= 0 && holds_contacts_) throw NotDifferentiablePoint(modes.edge);
  sensitivities_[island]->hold(modes.sides, holds_contacts_ ? modes.contacts : ContactHold{});
  nearest_.clear();
  if (const Mechanism& mechanism = from.prepared().mechanism; mechanism.touches()) {
    Dynamics& dynamics = islands_[island]->dynamics();
    dynamics.set_position(y);
    dynamics.set_velocity(y + mechanism.nq);
    std::vector<bool> closed(from.loads().contacts.size());
    if (const ContactModes* located = from.formulation().contacts().located(); located != nullptr) {
      const ContactEquations& equations = located->equations();
      for (const int i : equations.closed()) closed[static_cast<std::size_t>(equations.candidates()[i].contact)] = true;
    }
    nearest_.find(mechanism, dynamics, closed);
  }
  Drives& drives = from.formulation().drives();
  drives.go_to(from.time(), y);
  sensitivities_[island]->set_point(y, y + from.prepared().mechanism.nq, drives.u().data(),
                                    from.formulation().revolutions().coordinates().data(), from.targets());
  return *sensitivities_[island];
}

// All of an island at a point, with the rates of its element states.
template <class T>
class Sensitivity::ReadIsland {
 public:
  ReadIsland(const Sensitivity& of, int i, CarriedState<T>& at)
      : values_(of.islands_[i]->prepared().mechanism.expressions.size()),
        gaps_(of.nearest_.gaps(of.islands_[i]->prepared().mechanism, *at.equations)),
        rates(of.islands_[i]->prepared().states.size()),
        reading{.dynamics = *at.equations,
                .q = at.q.data(),
                .v = at.v.data(),
                .vdot = at.vdot.data(),
                .cut_q = at.equations->cut_coordinates().data(),
                .states = at.u.data() + of.u_.signals(),
                .state_rates = rates.data(),
                .expressions = values_.data(),
                .signals = at.equations->all_signals(at.u.data()),
                .formulas = of.islands_[i]->loads().values.data(),
                .forces = at.forces.data(),
                .modes = at.modes,
                .contact_forces = at.contact_forces.empty() ? nullptr : at.contact_forces.data(),
                .contact_gaps = gaps_.empty() ? nullptr : gaps_.data()} {
    at.equations->state_rates(at.u.data(), rates.data());
    at.equations->expression_values(at.u.data(), values_.data());
    of.readings_.rates_of_forces(i, of.islands_[i]->loads().rates, reading, rates.data());
  }

 private:
  std::vector<T> values_, gaps_;

 public:
  std::vector<T> rates;
  const ReadingOf<T> reading;
};

// Calls take(output, value) for each output of the island, and with its contribution to the energies.
template <class T, class Take>
void Sensitivity::read(int i, const ReadIsland<T>& of, Take take) const {
  const EnergyOf<T> energy = of.reading.dynamics.energy();
  for (int k = 0; k < static_cast<int>(signals_.size()); ++k) {
    if (readings_.is_of_whole(k)) {
      take(k, readings_.of_energy(k, energy));
    } else if (readings_.island(k) == i) {
      take(k, readings_.value(k, of.reading));
    }
  }
}

void Sensitivity::add(int i, const MatrixXd& directions, DirectionalDerivative& out) {
  const Index n = directions.cols();
  const auto [dq, dv, du] = directions_of(i, directions);
  const MovedState moved = sensitivities_[i]->state_derivative(dq, dv, du);
  add_rates(i, moved, out);
  for (int k = 0; k < static_cast<int>(signals_.size()); ++k) {
    const Outputs::Entry entry = readings_.entry(k);
    if (entry.index != Outputs::none && readings_.island(k) == i) {
      out.outputs.row(k) += entry.sign * moved.y.row(entry.index);
    }
  }
  const bool has_rates_of_forces = islands_[i]->loads().rates_read_forces();
  if (!has_rates_of_forces && !has_computed_outputs(i)) return;
  for (Index first = 0; first < n; first += dual_directions) {
    const Index width = std::min<Index>(dual_directions, n - first);
    const auto some = [&](const MatrixXd& of) -> MatrixXd { return of.middleCols(first, width); };
    CarriedState<Dual>& at = sensitivities_[i]->directional_derivative(some(dq), some(dv), some(du));
    const ReadIsland<Dual> of(*this, i, at);
    read(i, of, [&](int k, const Dual& value) {
      if (readings_.entry(k).index != Outputs::none) return;
      out.outputs.row(k).segment(first, width) += value.derivatives().head(width).matrix().transpose();
    });
    if (has_rates_of_forces) add_rates_of_forces(i, of.rates, first, width, out);
  }
}

// Of the element states whose rates name forces, in these columns.
void Sensitivity::add_rates_of_forces(int i, const std::vector<Dual>& rates, Index first, Index width,
                                      DirectionalDerivative& out) const {
  for (std::size_t s = 0; s < states_.size(); ++s) {
    const Place at = place(s);
    if (at.island != i || at.of != Place::Of::elements) continue;
    const auto component = static_cast<std::size_t>(at.component);
    if (!islands_[i]->loads().rates[component].reads_forces()) continue;
    const auto row = static_cast<Index>(s);
    out.xdot[row] = rates[component].value();
    out.rates.row(row).segment(first, width) = rates[component].derivatives().head(width).matrix().transpose();
  }
}

bool Sensitivity::has_computed_outputs(int i) const {
  for (int k = 0; k < static_cast<int>(signals_.size()); ++k) {
    if (readings_.is_of_whole(k)) return true;
    if (readings_.island(k) == i && readings_.entry(k).index == Outputs::none) return true;
  }
  return false;
}

void Sensitivity::add_rates(int i, const MovedState& moved, DirectionalDerivative& out) const {
  const Mechanism& mechanism = islands_[i]->prepared().mechanism;
  const Eigen::VectorXd y = sensitivities_[i]->point();
  for (std::size_t s = 0; s < states_.size(); ++s) {
    const Place at = place(s);
    if (at.island != i) continue;
    const Signal& signal = signals_[states_[s]];
    const auto row = static_cast<Index>(s);
    if (at.of == Place::Of::elements) {
      out.xdot[row] = sensitivities_[i]->state_rates()[at.component];
      out.rates.row(row) = moved.state_rates.row(at.component);
    } else if (signal.derivative < 0) {
      out.xdot[row] = at.sign * sensitivities_[i]->qdot()[at.component];
      out.rates.row(row) = at.sign * moved.qdot.row(at.component);
    } else {
      // A coordinate and its velocity have the same index within q and v of the joint.
      const int level = at.of == Place::Of::coordinates ? 0 : mechanism.nv;
      const int entry = mechanism.nq + level + reduced_.joints[signal.joint].iv + signal.component;
      const double sign = at.sign;
      out.xdot[row] = sign * y[entry];
      out.rates.row(row) = sign * moved.y.row(entry);
    }
  }
}

namespace {

// Of the motion, in natural units, that velocities among the states cause where friction and limits permit none.
constexpr double locked_rounding = 1e-10;

DirectionalDerivative zero_derivative(std::size_t outputs, std::size_t states, Index columns) {
  const auto ny = static_cast<Index>(outputs);
  const auto nx = static_cast<Index>(states);
  return {MatrixXd::Zero(ny, columns), MatrixXd::Zero(nx, columns), Eigen::VectorXd::Zero(nx)};
}

}  // namespace

DirectionalDerivative Sensitivity::along(const std::vector<double>& dx, const std::vector<double>& du) {
  friction_ = FrictionTreatment::present;
  holds_contacts_ = true;
  DirectionalDerivative out = zero_derivative(signals_.size(), states_.size(), 1);
  MatrixXd direction(static_cast<Index>(dx.size() + du.size()), 1);
  std::copy(du.begin(), du.end(), std::copy(dx.begin(), dx.end(), direction.data()));
  for (int i = 0; i < static_cast<int>(islands_.size()); ++i) {
    set_point(i);
    add(i, direction, out);
  }
  return out;
}

// The indices in (states; inputs) of those that act on an island.
std::vector<int> Sensitivity::columns_of(int island) const {
  std::vector<int> out;
  for (std::size_t s = 0; s < states_.size(); ++s) {
    if (place(s).island == island) out.push_back(static_cast<int>(s));
  }
  for (const int input : islands_[island]->loads().inputs) {
    if (input < static_cast<int>(u_.count())) out.push_back(static_cast<int>(states_.size()) + input);
  }
  return out;
}

Linearization Sensitivity::linearize(FrictionTreatment friction) {
  friction_ = friction;
  holds_contacts_ = true;
  const auto nx = static_cast<Index>(states_.size());
  const auto nu = static_cast<Index>(u_.count());
  DirectionalDerivative all = zero_derivative(signals_.size(), states_.size(), nx + nu);
  Linearization out;
  for (int i = 0; i < static_cast<int>(islands_.size()); ++i) {
    const std::vector<int> columns = columns_of(i);
    set_point(i);
    const auto width = static_cast<Index>(columns.size());
    if (width == nx + nu) {  // the only island with states and inputs
      add(i, MatrixXd::Identity(width, width), all);
      continue;
    }
    MatrixXd directions = MatrixXd::Zero(nx + nu, width);
    for (Index k = 0; k < width; ++k) directions(columns[k], k) = 1;
    DirectionalDerivative part = zero_derivative(signals_.size(), states_.size(), width);
    add(i, directions, part);
    all.xdot += part.xdot;
    for (Index k = 0; k < width; ++k) {
      all.outputs.col(columns[k]) += part.outputs.col(k);
      all.rates.col(columns[k]) += part.rates.col(k);
    }
  }
  const Index coordinates = std::ranges::count(states_, 0, [this](int state) { return signals_[state].level; });
  for (Index s = 0; s < coordinates; ++s) {
    if (std::ranges::find(states_, signals_[states_[s]].derivative) == states_.end()) continue;
    // What rolls may move with its heading, which is a coordinate.
    if (all.rates.row(s).head(nx).cwiseAbs().maxCoeff() <= locked_rounding) out.locked.push_back(states_[s]);
  }
  out.xdot = all.xdot;
  out.A = all.rates.leftCols(nx);
  out.B = all.rates.rightCols(nu);
  out.C = all.outputs.leftCols(nx);
  out.D = all.outputs.rightCols(nu);
  return out;
}

Eigen::MatrixX2d Sensitivity::in_time(const std::vector<double>& udot, const std::vector<double>& uddot) {
  friction_ = FrictionTreatment::present;
  holds_contacts_ = true;
  Eigen::MatrixX2d out = Eigen::MatrixX2d::Zero(static_cast<Index>(signals_.size()), 2);
  for (int i = 0; i < static_cast<int>(islands_.size()); ++i) {
    ConstrainedSensitivity& at = set_point(i);
    if (islands_[i]->loads().rates_read_forces())
      at.set_rates_of_forces(
          [this, i](CarriedState<Series>& here) { return ReadIsland<Series>(*this, i, here).rates; });
    const ReadIsland<Series> path(*this, i, at.time_derivatives(udot.data(), uddot.data()));
    read(i, path, [&](int k, const Series& value) {
      out(k, 0) += value[1];
      out(k, 1) += 2 * value[2];
    });
  }
  return out;
}

}  // namespace gelenk

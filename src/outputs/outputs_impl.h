// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdlib>

#include "element/constraints/registry.h"
#include "element/contacts/registry.h"
#include "element/forces/registry.h"
#include "element/sensors/registry.h"
#include "math/pose_in.h"
#include "outputs/outputs.h"

namespace gelenk {

template <class T>
T Outputs::value(int output, const ReadingOf<T>& reading) const {
  return value_of(sources_[output], reading);
}

template <class T>
inline T Outputs::value_of(const Source& s, const ReadingOf<T>& reading) const {
  const auto component = [&s](auto&& read) {
    T joint[max_cut_nv] = {};
    read(joint);
    return T(s.sign) * joint[s.component];
  };
  switch (s.kind) {
    case Kind::tree_q:
      return T(s.sign) * reading.q[s.index];
    case Kind::tree_v:
      return T(s.sign) * reading.v[s.index];
    case Kind::tree_a:
      return T(s.sign) * reading.vdot[s.index];
    case Kind::state:
      return reading.states[s.index];
    case Kind::state_rate:
      return reading.state_rates[s.index];
    case Kind::expression:
      return reading.expressions[s.index];
    case Kind::expression_of_forces:
      return value_of_forces<T>(reading.formulas[s.index], named_forces_[static_cast<std::size_t>(s.group)], reading);
    case Kind::cut_q:
      return T(s.sign) * reading.cut_q[s.index];
    case Kind::cut_v:
      if (reading.cut_v != nullptr)
        return T(s.sign) * reading.cut_v[reduced_.islands[s.island].cuts[s.index].iv + s.component];
      return component([&](T* joint) { reading.dynamics.cut_speeds(s.index, joint); });
    case Kind::cut_a:
      return component([&](T* joint) { reading.dynamics.cut_accelerations(s.index, joint); });
    case Kind::joint_force:
      return reading.forces[s.index];
    case Kind::joint_mode:
      return T(std::abs(reading.modes[s.index]) == 1 ? reading.modes[s.index] : 0);
    case Kind::sensor:
      return sensor_value<T>(s, &reading);
    case Kind::force:
      return force_value<T>(s, &reading.dynamics);
    case Kind::constraint:
      return constraint_value<T>(s, reading.dynamics);
    case Kind::contact:
      return contact_value<T>(s, reading);
    case Kind::constant:
    case Kind::whole:
      break;
  }
  return T(0);
}

// On the child: a moment along the axes of M, a force along those of F.
template <class T>
T Outputs::friction_value(const Source& s, const LinkFriction& of, const ReadingOf<T>& reading) const {
  Vector3<T> on_parent = Vector3<T>::Zero();  // in the root frame
  if constexpr (std::is_same_v<T, double>) {
    if (reading.contacts == nullptr) return 0;
    if (s.group == 1) return reading.contacts->mode(s.index) == 2 ? 1 : 0;
    on_parent =
        reduced_.islands[static_cast<std::size_t>(s.island)].X_W0.R.transpose() * reading.contacts->force(s.index);
  } else {
    if (reading.contact_forces == nullptr || s.group == 1) return T(0);
    on_parent = reading.contact_forces[s.index];
  }
  const int link = of.turns ? of.link_b : of.link_a;
  const Vector3<T> axis = (of.turns ? of.R_b : of.R_a).col(s.component).template cast<T>();
  return -on_parent.dot(link == 0 ? axis : Vector3<T>(reading.dynamics.link_pose(link).R * axis));
}

template <class T>
T Outputs::contact_value(const Source& s, const ReadingOf<T>& reading) const {
  const bool is_of_joint = static_cast<std::size_t>(s.index) >= scene_.contacts.size();
  if (is_of_joint) {
    const std::vector<LinkFriction>& frictions = reduced_.islands[static_cast<std::size_t>(s.island)].frictions;
    const auto friction = std::ranges::find(frictions, s.index, &LinkFriction::contact);
    if (friction != frictions.end()) return friction_value<T>(s, *friction, reading);
  }
  if constexpr (!std::is_same_v<T, double>) {
    if (!is_of_joint && s.group == 1 && reading.contact_gaps != nullptr) return reading.contact_gaps[s.index];
    if (reading.contact_forces == nullptr || s.group != 0) return T(0);
    const Vector3<T> force = reduced_.islands[static_cast<std::size_t>(s.island)].X_W0.R.template cast<T>() *
                             reading.contact_forces[s.index];
    if (!is_of_joint) return force[s.component];
    const T square = force.squaredNorm();
    using std::sqrt;
    return square > T(0) ? T(sqrt(square)) : T(0);
  }
  if (reading.contacts == nullptr) return T(0);
  if (is_of_joint)
    return s.group == 0 ? T(reading.contacts->force(s.index).norm()) : T(reading.contacts->mode(s.index) == 0 ? 0 : 1);
  return T(std::visit(
      [&](const auto& contact) {
        return contact.output(SeenContact{*reading.contacts, s.index}, s.group, s.component);
      },
      *scene_.contacts[static_cast<std::size_t>(s.index)].is));
}

template <class T>
T Outputs::value_of_forces(const Formula& formula, const std::vector<Source>& sources,
                           const ReadingOf<T>& reading) const {
  std::array<T, Formula::max_signals> named;
  for (std::size_t k = 0; k < sources.size(); ++k) {
    const int signal = formula.signals()[k];
    const bool is_fixed = sources[k].island == none;
    named[k] = signal >= 0 ? reading.signals[signal]
               : is_fixed  ? T(constant(sources[k]))
                           : value_of<T>(sources[k], reading);
  }
  return formula.value<T>(nullptr, named.data());
}

template <class T>
void Outputs::rates_of_forces(int island, const std::vector<Formula>& rates, const ReadingOf<T>& reading,
                              T* out) const {
  for (const RateOfForces& of : rates_of_forces_[static_cast<std::size_t>(island)])
    out[of.state] = value_of_forces<T>(rates[static_cast<std::size_t>(of.state)], of.named, reading);
}

// Of the laws that are contacts to the equations and belong to the joint whose reaction a sensor reads.
template <class T>
SeenWrench<T> Outputs::wrench_of_laws(const Source& sensor, const ReadingOf<T>& reading) const {
  SeenWrench<T> out{Vector3<T>::Zero(), Vector3<T>::Zero()};
  for (const LawOfSensor& law : laws_of_sensors_[static_cast<std::size_t>(sensor.index)]) {
    Vector3<T>& on = law.turns ? out.n : out.f;
    if constexpr (std::is_same_v<T, double>) {
      if (reading.contacts == nullptr) continue;
      const Eigen::Matrix3d& R_W0 = reduced_.islands[static_cast<std::size_t>(sensor.island)].X_W0.R;
      on -= R_W0.transpose() * reading.contacts->force(law.contact);
    } else {
      if (reading.contact_forces != nullptr) on -= reading.contact_forces[law.contact];
    }
  }
  return out;
}

template <class T>
T Outputs::sensor_value(const Source& source, const ReadingOf<T>* reading) const {
  const auto i = static_cast<std::size_t>(source.index);
  SeenPorts<T> seen(ports_[i], reduced_, reading == nullptr ? nullptr : &reading->dynamics);
  if (reading != nullptr && !laws_of_sensors_[i].empty()) seen.add_to_reaction(wrench_of_laws<T>(source, *reading));
  return std::visit(
      [&](const auto& sensor) -> T {
        if constexpr (OfWhole<std::decay_t<decltype(sensor)>>)
          return T(0);
        else
          return sensor.output(seen, source.group, source.component);
      },
      *scene_.sensors[i].is);
}

template <class T>
T Outputs::force_value(const Source& source, const Readings<T>* dynamics) const {
  const auto i = static_cast<std::size_t>(source.index);
  return std::visit(
      [&](const auto& force) -> T {
        using F = std::decay_t<decltype(force)>;
        if constexpr (requires { F::outputs; }) {
          const SeenPorts<T> seen(force_ports_[i], reduced_, dynamics);
          std::array<RecordingPort<T>, std::size(F::ports)> at;
          for (std::size_t k = 0; k < at.size(); ++k) at[k] = seen.port(static_cast<int>(k));
          return force.template output<T>(at.data(), source.group);
        }
        return T(0);
      },
      *scene_.forces[i].is);
}

template <class T>
T Outputs::constraint_value(const Source& source, const Readings<T>& dynamics) const {
  const auto i = static_cast<std::size_t>(source.index);
  const SeenConstraint<T> seen(reduced_.constraints[i], reduced_, dynamics);
  return std::visit([&](const auto& c) { return T(c.output(seen, source.group, source.component)); },
                    *scene_.constraints[i].is);
}

template <class T>
T Outputs::of_energy(int output, const EnergyOf<T>& energy) const {
  const Source& s = sources_[output];
  const SeenEnergy<T> seen{energy};
  return std::visit(
      [&](const auto& sensor) -> T {
        if constexpr (OfWhole<std::decay_t<decltype(sensor)>>) return sensor.output(seen, s.group, s.component);
        return T(0);
      },
      *scene_.sensors[static_cast<std::size_t>(s.index)].is);
}

}  // namespace gelenk

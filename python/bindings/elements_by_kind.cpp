// SPDX-License-Identifier: BSD-3-Clause
// The elements of src/element, kind by kind, for the tests of the laws that every one must obey. The kinds are those of
// the registry.
#include "elements.h"

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "algebras.h"
#include "bindings.h"
#include "element/registry.h"
#include "kinematics/coordinate_derivatives.h"
#include "kinematics/force_ports.h"

namespace nb = nanobind;

namespace gelenk {
namespace {

template <class E>
std::string name_of() {
  if constexpr (requires { E::kind; }) {
    return std::string(E::kind);
  } else {
    return name_along(E::group, E::fields());
  }
}

// An element of this kind, among the alternatives of a variant, with these numbers.
template <class Any, class... E>
Any made(const std::variant<E...>*, const std::string& kind, const ElementNumbers& numbers) {
  Any out;
  const auto take = [&]<class One>(const One& plain) {
    if (name_of<One>() != kind) return false;
    One& element = out.template emplace<One>(plain);
    for (const auto& [name, value] : numbers) put_number(One::fields(), &element, name, value);
    return true;
  };
  if (!(take(E()) || ...)) throw std::invalid_argument("unknown kind: " + kind);
  return out;
}

void check_size(const Vector& values, Eigen::Index size, const char* name) {
  if (values.size() != size)
    throw std::invalid_argument(std::string(name) + " must have length " + std::to_string(size));
}

nb::dict shown_jacobians(const PortJacobians& jacobians) {
  nb::dict out;
  out["f_p"] = jacobians.f_p;
  out["f_a"] = jacobians.f_a;
  out["n_p"] = jacobians.n_p;
  out["n_a"] = jacobians.n_a;
  out["f_v"] = jacobians.f_v;
  out["f_w"] = jacobians.f_w;
  out["n_v"] = jacobians.n_v;
  out["n_w"] = jacobians.n_w;
  out["of_points"] = jacobians.of_points;
  out["damped"] = jacobians.damped;
  return out;
}

// A force whose ports are at given poses.
class ForceAtPorts {
  using Poses = std::vector<Eigen::Matrix4d>;
  using Velocities = std::vector<Vector6>;

  template <std::size_t n>
  struct Here {
    Attachment at;  // the frame of each body coincides with its port
    Loads loads;
    std::array<Spatial::Pose, n> X;
    std::array<Spatial::Motion, n> V;
    std::array<detail::PortAt<Spatial>, n> ports;
  };

  template <class Function>
  auto at(const Poses& poses, const Velocities& velocities, const Vector& u, const Eigen::Matrix3d& R_0W,
          const Function& function) const {
    if (poses.size() != ports() || velocities.size() != ports())
      throw std::invalid_argument("expected poses and velocities of " + std::to_string(ports()) + " ports");
    check_size(u, input_count(force_), "inputs");
    return std::visit(
        [&]<class F>(const F& force) {
          Here<std::size(F::ports)> here;
          here.at.p.setZero();
          here.at.R.setIdentity();
          here.loads.R_0W = R_0W;
          for (std::size_t k = 0; k < here.ports.size(); ++k) {
            here.X[k] = pose<Spatial>(poses[k]);
            here.V[k] = {velocities[k].head<3>(), velocities[k].tail<3>() - velocities[k].head<3>().cross(here.X[k].p)};
            here.ports[k].at = &here.at;
            here.ports[k].loads = &here.loads;
            here.ports[k].X = &here.X[k];
            here.ports[k].V = &here.V[k];
          }
          return function(force, here);
        },
        force_);
  }

 public:
  ForceAtPorts(const std::string& kind, const ElementNumbers& numbers)
      : force_(made<AnyForce>(static_cast<const AnyForce*>(nullptr), kind, numbers)) {}

  nb::list inputs() const { return shown_signals(inputs_of(force_)); }
  std::size_t ports() const { return kind_of(force_).ports.size(); }

  std::vector<Vector6> act(const Poses& poses, const Velocities& velocities, const Vector& u,
                           const Eigen::Matrix3d& R_0W) const {
    return at(poses, velocities, u, R_0W, [&](const auto& force, auto& here) {
      force.act(here.ports.data(), u.data());
      std::vector<Vector6> out;
      for (const auto& port : here.ports) out.push_back((Vector6() << port.n, port.f).finished());
      return out;
    });
  }
  double energy(const Poses& poses) const {
    const Velocities still(poses.size(), Vector6::Zero());
    const Vector none = Vector::Zero(input_count(force_));
    return at(poses, still, none, Eigen::Matrix3d::Identity(), [](const auto& force, auto& here) -> double {
      if constexpr (requires { force.template energy<double>(here.ports.data()); }) {
        return force.template energy<double>(here.ports.data());
      }
      return 0;
    });
  }
  bool undefined(const Poses& poses) const {
    const Velocities still(poses.size(), Vector6::Zero());
    const Vector none = Vector::Zero(input_count(force_));
    return at(poses, still, none, Eigen::Matrix3d::Identity(), [](const auto& force, auto& here) {
      if constexpr (requires { force.undefined(here.ports.data()); }) return bool(force.undefined(here.ports.data()));
      return false;
    });
  }
  // Whether the numbers are mutually consistent.
  bool is_sound() const { return !fault_of(force_, {}); }
  // None if the element does not supply its own.
  std::optional<nb::dict> jacobians(const Poses& poses, const Velocities& velocities, const Vector& u,
                                    const Eigen::Matrix3d& R_0W) const {
    return at(poses, velocities, u, R_0W, [&](const auto& force, auto& here) -> std::optional<nb::dict> {
      if constexpr (gelenk::HasPortJacobians<std::decay_t<decltype(force)>, std::decay_t<decltype(here.ports[0])>>) {
        return shown_jacobians(force.jacobians(here.ports.data(), u.data()));
      }
      return std::nullopt;
    });
  }
  nb::dict derivatives_by_duals(const Poses& poses, const Velocities& velocities, const Vector& u,
                                const Eigen::Matrix3d& R_0W) const {
    return at(poses, velocities, u, R_0W, [&](const auto& force, auto& here) {
      const auto moved = detail::constant_ports(here.ports, here.loads);
      Spatial::Motion U = here.V.back();
      if (moved.size() > 1) U = U - here.V.front();
      const Eigen::Vector3d v = detail::velocity(U, here.X.back().p);
      const auto input = detail::constants(force, u.data());
      return shown_jacobians(detail::derivatives_by_duals(force, moved, input.data(), U.w, v));
    });
  }

 private:
  AnyForce force_;
};

// A force along a joint coordinate: a motor, or an element that belongs to the joint.
template <class Any, class Tuple>
struct AlongAny;
template <class... Motor, class... Force>
struct AlongAny<std::variant<Motor...>, std::tuple<Force...>> {
  using type = std::variant<Motor..., typename detail::Plain<Force>::type...>;
};

using AnyAlong = AlongAny<AnyMotor::variant, JointForces::tuple>::type;

class AlongOne {
 public:
  AlongOne(const std::string& kind, const ElementNumbers& numbers)
      : force_(made<AnyAlong>(static_cast<const AnyAlong*>(nullptr), kind, numbers)) {}

  nb::list inputs() const {
    return std::visit([](const auto& force) { return shown_signals(own_inputs(force)); }, force_);
  }
  double effort(double q, double v, const Vector& u) const {
    return std::visit(
        [&](const auto& force) {
          check_size(u, count_of(own_inputs(force)), "inputs");
          return force.effort(q, v, u.data());
        },
        force_);
  }
  double energy(double q) const {
    return std::visit(
        [&](const auto& force) -> double {
          if constexpr (requires { force.energy(q); }) return force.energy(q);
          return 0;
        },
        force_);
  }
  double inertia() const {
    return std::visit(
        [](const auto& force) -> double {
          if constexpr (requires { force.inertia(); }) return force.inertia();
          return 0;
        },
        force_);
  }
  bool is_sound() const {
    return std::visit(
        [](const auto& force) {
          if constexpr (requires { force.fault(Coordinate()); }) return !force.fault(Coordinate());
          return true;
        },
        force_);
  }
  std::optional<std::vector<double>> jacobians(double q, double v) const {
    return std::visit(
        [&](const auto& force) -> std::optional<std::vector<double>> {
          if constexpr (gelenk::HasJacobians<std::decay_t<decltype(force)>>) {
            const auto jacobians = force.jacobians(q, v);
            return std::vector<double>(jacobians.begin(), jacobians.end());
          }
          return std::nullopt;
        },
        force_);
  }
  // Derivatives with respect to q, v and the inputs.
  std::vector<double> derivatives_by_duals(double q, double v, const Vector& u) const {
    return std::visit(
        [&]<class F>(const F& force) {
          const int n = count_of(own_inputs(force));
          check_size(u, n, "inputs");
          AlongCoordinate<F> placed;
          placed.element = force;
          gelenk::DerivativesAlong found = gelenk::derivatives_by_duals(placed, &q, &v, u.data(), n);
          if constexpr (requires { force.excess(); }) {
            if (const auto part = force.excess()) {
              placed.element = *part;
              const auto other = gelenk::derivatives_by_duals(placed, &q, &v, u.data(), n);
              for (std::size_t i = 0; i < found.size(); ++i) found[i] += other[i];
            }
          }
          return std::vector<double>(found.data(), found.data() + 2 + n);
        },
        force_);
  }

 private:
  AnyAlong force_;
};

}  // namespace

void bind_elements(nb::module_& module) {
  nb::module_ m =
      module.def_submodule("elements", "The functions of all kinds of elements, see src/element/element.h.");
  m.def("kinds", &shown_kinds,
        "All kinds of motors, forces, constraints, sensors, and forces along joint coordinates: names, ports, fields, "
        "outputs, with units in FMI spelling.");
  nb::class_<ForceAtPorts>(
      m, "Force",
      "A force with numbers by the names of its fields. The poses of its ports are 4x4 matrices in a "
      "frame 0 at rest. Velocities (w, v of the port's origin) [rad/s, m/s] and wrenches (torque, "
      "force) [N m, N] at the ports' origins are written in frame 0. R_0W: the rotation of the "
      "world frame in frame 0.")
      .def(nb::init<const std::string&, const ElementNumbers&>(), nb::arg("kind"), nb::arg("numbers"))
      .def_prop_ro("inputs", &ForceAtPorts::inputs)
      .def_prop_ro("ports", &ForceAtPorts::ports)
      .def("act", &ForceAtPorts::act, nb::arg("poses"), nb::arg("velocities"), nb::arg("inputs"), nb::arg("R_0W"))
      .def_prop_ro("is_sound", &ForceAtPorts::is_sound)
      .def("energy", &ForceAtPorts::energy, nb::arg("poses"))
      .def("undefined", &ForceAtPorts::undefined, nb::arg("poses"))
      .def("jacobians", &ForceAtPorts::jacobians, nb::arg("poses"), nb::arg("velocities"), nb::arg("inputs"),
           nb::arg("R_0W"))
      .def("derivatives_by_duals", &ForceAtPorts::derivatives_by_duals, nb::arg("poses"), nb::arg("velocities"),
           nb::arg("inputs"), nb::arg("R_0W"));
  nb::class_<AlongOne>(m, "Along", "A force along a joint coordinate, with numbers by the names of its fields.")
      .def(nb::init<const std::string&, const ElementNumbers&>(), nb::arg("kind"), nb::arg("numbers"))
      .def_prop_ro("inputs", &AlongOne::inputs)
      .def_prop_ro("inertia", &AlongOne::inertia)
      .def("effort", &AlongOne::effort, nb::arg("q"), nb::arg("v"), nb::arg("inputs"))
      .def_prop_ro("is_sound", &AlongOne::is_sound)
      .def("energy", &AlongOne::energy, nb::arg("q"))
      .def("jacobians", &AlongOne::jacobians, nb::arg("q"), nb::arg("v"))
      .def("derivatives_by_duals", &AlongOne::derivatives_by_duals, nb::arg("q"), nb::arg("v"), nb::arg("inputs"));
}

}  // namespace gelenk

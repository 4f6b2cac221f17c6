// SPDX-License-Identifier: BSD-3-Clause
// The functions of src/joint/rod.h, for the tests of the laws that rods, like joints, must obey.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "algebras.h"
#include "bindings.h"
#include "joint/rod.h"
#include "math/dual.h"

namespace nb = nanobind;

namespace gelenk {
namespace {

// A rod in one algebra.
class RodInAlgebra {
  template <class Function>
  auto in_algebra(const Function& function) const {
    return planar_ ? function.template operator()<Planar>() : function.template operator()<Spatial>();
  }

 public:
  RodInAlgebra(const std::string& first, const std::vector<Eigen::Vector3d>& first_axes, bool first_reversed,
               const std::string& second, bool second_reversed, const Eigen::Matrix4d& X_12, bool planar)
      : planar_(planar) {
    const auto found = make_rod(*make_joint(first, first_axes), first_reversed, *make_joint(second, {}),
                                second_reversed, pose<Spatial>(X_12), planar);
    if (!found) throw std::invalid_argument("a rod cannot be formed from these joints and this length");
    rod_ = *found;
  }

  Eigen::Matrix4d X_FM(const Vector& q) const {
    return in_algebra([&]<class A> { return shown(rod_.X_FM<A>(q.data())); });
  }
  Eigen::Matrix4d rod_pose(const Vector& q) const {
    return in_algebra([&]<class A> { return shown(rod_.rod_pose<A>(q.data())); });
  }
  Vector6 V_FM(const Vector& q, const Vector& v) const {
    return in_algebra([&]<class A> { return shown(rod_.V_FM<A>(q.data(), v.data())); });
  }
  Vector6 rod_velocity(const Vector& q, const Vector& v) const {
    return in_algebra([&]<class A> { return shown(rod_.rod_velocity<A>(q.data(), v.data())); });
  }
  Vector6 bias(const Vector& q, const Vector& v) const {
    return in_algebra([&]<class A> { return shown(rod_.bias<A>(q.data(), v.data())); });
  }
  Vector6 wrench_from_tau(const Vector& q, const Vector& tau) const {
    return in_algebra([&]<class A> { return shown(rod_.wrench_from_tau<A>(q.data(), tau.data())); });
  }
  Vector speeds(const Vector& q, const Vector6& V) const {
    Vector v(rod_.nv());
    in_algebra([&]<class A> {
      rod_.speeds<A>(q.data(), pair_of<A, typename A::Motion>(V), v.data());
      return 0;
    });
    return v;
  }
  Vector coordinates(const Eigen::Matrix4d& X, Vector q) const {
    in_algebra([&]<class A> {
      rod_.coordinates<A>(pose<A>(X), q.data());
      return 0;
    });
    return q;
  }
  // dq/dt for a given dX/dt, by dual numbers.
  Vector coordinate_rates(const Eigen::Matrix4d& X, const Eigen::Matrix4d& Xdot, const Vector& q) const {
    const auto dual = [&](int i, int j) {
      Dual x = X(i, j);
      x.derivatives()[0] = Xdot(i, j);
      return x;
    };
    std::vector<Dual> found(q.begin(), q.end());
    if (planar_) {
      rod_.coordinates<PlanarAlgebra<Dual>>({dual(0, 0), dual(1, 0), dual(0, 3), dual(1, 3)}, found.data());
    } else {
      SpatialAlgebra<Dual>::Pose pose;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) pose.R(i, j) = dual(i, j);
        pose.p[i] = dual(i, 3);
      }
      rod_.coordinates<SpatialAlgebra<Dual>>(pose, found.data());
    }
    Vector out(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) out[i] = found[static_cast<std::size_t>(i)].derivatives()[0];
    return out;
  }
  std::pair<Vector6, double> row(const Eigen::Matrix4d& X) const {
    return in_algebra([&]<class A> {
      Row<A> found;
      rod_.rows<A>(pose<A>(X), &found);
      return std::pair<Vector6, double>(shown(found.w), found.Phi);
    });
  }
  double row_bias(const Eigen::Matrix4d& X, const Vector6& V) const {
    return in_algebra([&]<class A> {
      double out = 0;
      rod_.rows_bias<A>(pose<A>(X), pair_of<A, typename A::Motion>(V), &out);
      return out;
    });
  }
  int nq() const { return rod_.nq(); }
  int nv() const { return rod_.nv(); }

 private:
  Rod rod_;
  bool planar_;
};

}  // namespace

void bind_rods(nb::module_& joints) {
  nb::class_<RodInAlgebra>(joints, "Rod")
      .def(nb::init<const std::string&, const std::vector<Eigen::Vector3d>&, bool, const std::string&, bool,
                    const Eigen::Matrix4d&, bool>(),
           nb::arg("first"), nb::arg("first_axes"), nb::arg("first_reversed"), nb::arg("second"),
           nb::arg("second_reversed"), nb::arg("X_12"), nb::arg("planar") = false)
      .def_prop_ro("nq", &RodInAlgebra::nq)
      .def_prop_ro("nv", &RodInAlgebra::nv)
      .def("X_FM", &RodInAlgebra::X_FM, nb::arg("q"))
      .def("rod_pose", &RodInAlgebra::rod_pose, nb::arg("q"))
      .def("V_FM", &RodInAlgebra::V_FM, nb::arg("q"), nb::arg("v"))
      .def("rod_velocity", &RodInAlgebra::rod_velocity, nb::arg("q"), nb::arg("v"))
      .def("bias", &RodInAlgebra::bias, nb::arg("q"), nb::arg("v"))
      .def("wrench_from_tau", &RodInAlgebra::wrench_from_tau, nb::arg("q"), nb::arg("tau"))
      .def("speeds", &RodInAlgebra::speeds, nb::arg("q"), nb::arg("V"))
      .def("coordinates", &RodInAlgebra::coordinates, nb::arg("X_FM"), nb::arg("q"))
      .def("coordinate_rates", &RodInAlgebra::coordinate_rates, nb::arg("X_FM"), nb::arg("rate"), nb::arg("q"))
      .def("row", &RodInAlgebra::row, nb::arg("X_FM"))
      .def("row_bias", &RodInAlgebra::row_bias, nb::arg("X_FM"), nb::arg("V"));
}

}  // namespace gelenk

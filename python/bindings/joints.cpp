// SPDX-License-Identifier: BSD-3-Clause
// The joint functions of src/joint, kind by kind, for the tests of the laws that every joint must obey.
// Poses are 4x4 matrices, motions and forces 6-vectors (angular part first); planar quantities are converted to
// spatial ones, with the plane's normal along z.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "algebras.h"
#include "bindings.h"
#include "elements.h"
#include "joint/registry.h"

namespace nb = nanobind;

namespace gelenk {
namespace {

// A joint in one algebra.
class JointInAlgebra {
  // Calls function.operator()<A>(joint) with the algebra of this object and the type of the joint.
  template <class Function>
  auto in_algebra(const Function& function) const {
    return std::visit(
        [&](const auto& j) {
          if constexpr (supports_algebra<Planar, std::decay_t<decltype(j)>>) {
            if (planar_) return function.template operator()<Planar>(j);
          }
          return function.template operator()<Spatial>(j);
        },
        joint_);
  }

 public:
  JointInAlgebra(const std::string& kind, std::vector<Eigen::Vector3d> axes, bool planar, const ElementNumbers& numbers)
      : axes_(std::move(axes)), joint_(make(kind, axes_)), planar_(planar) {
    for (const auto& [name, value] : numbers) put_number(kind_of(joint_).fields, data_of(joint_), name, value);
    if (planar && kind_of(joint_).planar == PlanarRole::never)
      throw std::invalid_argument(kind + " joints are not planar and do not exist in planar algebra");
  }

  Eigen::Matrix4d X_FM(const Vector& q) const {
    check(q, nq(), "q");
    return in_algebra([&]<class A>(const auto& j) { return shown(j.template X_FM<A>(q.data())); });
  }
  Vector6 V_FM(const Vector& q, const Vector& v) const {
    check(q, v);
    return in_algebra([&]<class A>(const auto& j) { return shown(j.template V_FM<A>(q.data(), v.data())); });
  }
  Vector6 bias(const Vector& q, const Vector& v) const {
    check(q, v);
    return in_algebra([&]<class A>(const auto& j) { return shown(j.template bias<A>(q.data(), v.data())); });
  }
  Vector project(const Vector& q, const Vector6& F) const {
    check(q, nq(), "q");
    Vector tau(nv());
    in_algebra([&]<class A>(const auto& j) {
      j.template project<A>(q.data(), pair_of<A, typename A::Force>(F), tau.data());
      return 0;
    });
    return tau;
  }
  Vector speeds(const Vector& q, const Vector6& V) const {
    check(q, nq(), "q");
    Vector v(nv());
    in_algebra([&]<class A>(const auto& j) {
      j.template speeds<A>(q.data(), pair_of<A, typename A::Motion>(V), v.data());
      return 0;
    });
    return v;
  }
  Vector qdot_from_v(const Vector& q, const Vector& v) const {
    check(q, v);
    Vector qdot(nq());
    std::visit([&](const auto& j) { j.qdot_from_v(q.data(), v.data(), qdot.data()); }, joint_);
    return qdot;
  }
  Vector v_from_qdot(const Vector& q, const Vector& qdot) const {
    check(q, nq(), "q");
    check(qdot, nq(), "qdot");
    Vector v(nv());
    std::visit([&](const auto& j) { j.v_from_qdot(q.data(), qdot.data(), v.data()); }, joint_);
    return v;
  }
  Vector normalize(Vector q) const {
    check(q, nq(), "q");
    std::visit([&](const auto& j) { j.normalize(q.data()); }, joint_);
    return q;
  }
  Vector coordinates(const Eigen::Matrix4d& X, Vector q) const {
    check(q, nq(), "q");
    in_algebra([&]<class A>(const auto& j) {
      j.template coordinates<A>(pose<A>(X), q.data());
      return 0;
    });
    return q;
  }
  // (W, Phi): each row of W is a wrench, torque first, written in F.
  std::pair<Eigen::MatrixXd, Vector> rows(const Eigen::Matrix4d& X) const {
    return in_algebra([&]<class A>(const auto& j) {
      Row<A> found[6];
      const int n = j.template rows<A>(pose<A>(X), found);
      std::pair<Eigen::MatrixXd, Vector> out{Eigen::MatrixXd(n, 6), Vector(n)};
      for (int i = 0; i < n; ++i) {
        out.first.row(i) = shown(found[i].w).transpose();
        out.second[i] = found[i].Phi;
      }
      return out;
    });
  }
  Vector rows_bias(const Eigen::Matrix4d& X, const Vector6& V) const {
    return in_algebra([&]<class A>(const auto& j) {
      Row<A> found[6];
      Vector out = Vector::Zero(6);
      const int n = j.template rows<A>(pose<A>(X), found);
      j.template rows_bias<A>(pose<A>(X), pair_of<A, typename A::Motion>(V), out.data());
      return Vector(out.head(n));
    });
  }
  Eigen::Matrix3d canonical() const { return canonical_rotation(joint_, axes_); }
  Vector flip() const {
    const auto signs = flip_signs(joint_);
    return Eigen::Map<const Vector>(signs.data(), static_cast<Eigen::Index>(signs.size()));
  }
  int nq() const { return kind_of(joint_).nq; }
  int nv() const { return kind_of(joint_).nv; }

 private:
  static AnyJoint make(const std::string& kind, const std::vector<Eigen::Vector3d>& axes) {
    const JointKind* found = find_joint_kind(kind);
    if (found == nullptr) throw std::invalid_argument("unknown kind of joint: " + kind);
    if (static_cast<int>(axes.size()) != found->axes)
      throw std::invalid_argument(kind + " joints have " + std::to_string(found->axes) + " axes");
    return *make_joint(kind, axes);
  }
  static void check(const Vector& values, int size, const char* name) {
    if (values.size() != size)
      throw std::invalid_argument(std::string(name) + " must have length " + std::to_string(size));
  }
  void check(const Vector& q, const Vector& v) const {
    check(q, nq(), "q");
    check(v, nv(), "v");
  }
  std::vector<Eigen::Vector3d> axes_;
  AnyJoint joint_;
  bool planar_;
};

const char* role_name(PlanarRole role) {
  if (role == PlanarRole::normal) return "normal";
  return role == PlanarRole::in_plane ? "in_plane" : "never";
}

nb::list kinds() {
  nb::list out;
  for (const JointKind& kind : joint_kinds()) {
    nb::dict entry;
    entry["name"] = std::string(kind.name);
    entry["nq"] = kind.nq;
    entry["nv"] = kind.nv;
    entry["axes"] = kind.axes;
    entry["planar"] = role_name(kind.planar);
    entry["quaternion"] = kind.has_quaternion();
    entry["q_zero"] = std::vector<double>(kind.q_zero.begin(), kind.q_zero.end());
    for (const auto& [key, quantities] : {std::pair{"q", kind.q}, std::pair{"v", kind.v}, std::pair{"a", kind.a}}) {
      nb::list names, units;
      for (const Quantity& quantity : quantities) {
        names.append(std::string(quantity.name));
        units.append(std::string(quantity.unit));
      }
      entry[key] = names;
      entry[(std::string(key) + "_units").c_str()] = units;
    }
    const Stored<AnyJoint> plain = make_joint(kind.name, default_axes(kind));
    entry["fields"] = shown_fields(kind.fields, data_of(*plain));
    out.append(entry);
  }
  return out;
}

}  // namespace

void bind_joints(nb::module_& module) {
  nb::module_ m = module.def_submodule("joints", "The functions of all kinds of joints, see src/joint/base.h.");
  m.def("kinds", &kinds, "All kinds of joints: name, sizes, names of coordinates, velocities and accelerations.");
  nb::class_<JointInAlgebra>(m, "Joint")
      .def(nb::init<const std::string&, std::vector<Eigen::Vector3d>, bool, const ElementNumbers&>(), nb::arg("kind"),
           nb::arg("axes") = std::vector<Eigen::Vector3d>{}, nb::arg("planar") = false,
           nb::arg("numbers") = ElementNumbers{})
      .def_prop_ro("nq", &JointInAlgebra::nq)
      .def_prop_ro("nv", &JointInAlgebra::nv)
      .def("X_FM", &JointInAlgebra::X_FM, nb::arg("q"))
      .def("V_FM", &JointInAlgebra::V_FM, nb::arg("q"), nb::arg("v"))
      .def("bias", &JointInAlgebra::bias, nb::arg("q"), nb::arg("v"))
      .def("project", &JointInAlgebra::project, nb::arg("q"), nb::arg("F"))
      .def("speeds", &JointInAlgebra::speeds, nb::arg("q"), nb::arg("V"))
      .def("qdot_from_v", &JointInAlgebra::qdot_from_v, nb::arg("q"), nb::arg("v"))
      .def("v_from_qdot", &JointInAlgebra::v_from_qdot, nb::arg("q"), nb::arg("qdot"))
      .def("normalize", &JointInAlgebra::normalize, nb::arg("q"))
      .def("coordinates", &JointInAlgebra::coordinates, nb::arg("X_FM"), nb::arg("q"))
      .def("rows", &JointInAlgebra::rows, nb::arg("X_FM"))
      .def("rows_bias", &JointInAlgebra::rows_bias, nb::arg("X_FM"), nb::arg("V"))
      .def("canonical", &JointInAlgebra::canonical)
      .def("flip", &JointInAlgebra::flip);
  bind_rods(m);
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// A tree in Pinocchio with the constraint equations of its loops: Pinocchio has no integrator and no projection.
// Written for these measurements as a careful user would.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>
#include <vector>

#include "tree_file.h"

namespace pin = pinocchio;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class PinocchioModel {
 public:
  // proximal: loops by constraintDynamics; otherwise crba, a dense Cholesky factor and the constraint equations.
  PinocchioModel(TreeFile tree, bool proximal) : tree_(std::move(tree)), proximal_(proximal && has_loops()) {
    add_bodies();
    data_ = std::make_unique<pin::Data>(model_);
    for (const TreeClosure& c : tree_.closures) rows_ += static_cast<int>(c.rows.size());
    const int n = model_.nv;
    tau_.setZero(n);
    held_.setZero(n);
    zero_.setZero(n);
    forces_.assign(static_cast<std::size_t>(model_.njoints), pin::Force::Zero());
    J_.setZero(rows_, n);
    Phi_.setZero(rows_);
    rate_.setZero(rows_);
    gamma_.setZero(rows_);
    if (proximal_) add_constraints();
  }

  int size() const { return model_.nv; }
  bool has_loops() const { return !tree_.closures.empty(); }
  const TreeFile& tree() const { return tree_; }
  long evaluations() const { return evaluations_; }
  VectorXd q0() const { return start(&TreeBody::q); }
  VectorXd v0() const { return start(&TreeBody::v); }

  // Replaces the torques as functions of time by these constants.
  void hold(const VectorXd& torque) {
    held_ = torque;
    holds_ = true;
  }

  void acceleration(double t, const VectorXd& q, const VectorXd& v, VectorXd& vdot) {
    ++evaluations_;
    for (int i = 0; i < size(); ++i) {
      const TreeBody& b = tree_.bodies[static_cast<std::size_t>(i)];
      tau_[i] = (holds_ ? held_[i] : b.torque(t)) + b.passive(q[i], v[i]);
    }
    if (!tree_.springs.empty()) pull(q, v);
    if (!has_loops()) {
      vdot =
          tree_.springs.empty() ? pin::aba(model_, *data_, q, v, tau_) : pin::aba(model_, *data_, q, v, tau_, forces_);
    } else if (proximal_) {
      vdot = pin::constraintDynamics(model_, *data_, q, v, tau_, constraints_, constraint_data_, settings_);
    } else {
      solve_with_rows(q, v, vdot);
    }
  }

  // Projects by the least change; returns false if it does not converge.
  bool project(VectorXd& q, VectorXd& v) {
    for (int k = 0; k < 8; ++k) {
      look(q, v);
      const bool closed = Phi_.cwiseAbs().maxCoeff() < 1e-12;
      if (closed) {
        v -= least(rate_);
        return true;
      }
      q -= least(Phi_);
    }
    return false;
  }

 private:
  static Vector3d vector(const double* x) { return {x[0], x[1], x[2]}; }
  static Matrix3d matrix(const double* x) { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(x); }
  VectorXd start(double TreeBody::* of) const {
    VectorXd out(size());
    for (int i = 0; i < size(); ++i) out[i] = tree_.bodies[static_cast<std::size_t>(i)].*of;
    return out;
  }
  static pin::JointModel joint_of(const TreeBody& b) {
    const Vector3d axis = vector(b.axis);
    if (b.slides) {
      if (axis == Vector3d::UnitX()) return pin::JointModelPX();
      if (axis == Vector3d::UnitY()) return pin::JointModelPY();
      return axis == Vector3d::UnitZ() ? pin::JointModel(pin::JointModelPZ()) : pin::JointModelPrismaticUnaligned(axis);
    }
    if (axis == Vector3d::UnitX()) return pin::JointModelRX();
    if (axis == Vector3d::UnitY()) return pin::JointModelRY();
    return axis == Vector3d::UnitZ() ? pin::JointModel(pin::JointModelRZ()) : pin::JointModelRevoluteUnaligned(axis);
  }
  void add_bodies() {
    model_.gravity.linear() = vector(tree_.gravity);
    for (const TreeBody& b : tree_.bodies) {
      const pin::SE3 place(matrix(b.R), vector(b.position));
      const pin::JointIndex joint = model_.addJoint(joint_number(b.parent), joint_of(b), place, b.name);
      // Otherwise the columns of J are not in the order of the bodies.
      if (joint != static_cast<pin::JointIndex>(&b - tree_.bodies.data()) + 1)
        throw std::logic_error("order of joints");
      model_.appendBodyToJoint(joint, pin::Inertia(b.mass, vector(b.com), matrix(b.inertia)));
    }
  }
  static pin::JointIndex joint_number(int body) { return static_cast<pin::JointIndex>(body + 1); }

  void add_constraints() {
    for (const TreeClosure& c : tree_.closures) {
      constraints_.emplace_back(pin::CONTACT_3D, model_, joint_number(c.first),
                                pin::SE3(Matrix3d::Identity(), vector(c.at_first)), joint_number(c.second),
                                pin::SE3(Matrix3d::Identity(), vector(c.at_second)), pin::LOCAL);
    }
    for (const auto& c : constraints_) constraint_data_.emplace_back(c.createData());
    pin::initConstraintDynamics(model_, *data_, constraints_, constraint_data_);
  }

  // A point of a body after forwardKinematics(q, v, 0), in the world frame.
  struct Place {
    Vector3d x, rate, bias, w, w_bias;
    Matrix3d R;
  };
  Place place(int body, const double* at) const {
    const Vector3d p = vector(at);
    if (body < 0)
      return {p, Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Matrix3d::Identity()};
    const auto j = joint_number(body);
    const pin::SE3& X = data_->oMi[j];
    const Vector3d w = data_->v[j].angular(), dw = data_->a[j].angular();
    const Vector3d rate = data_->v[j].linear() + w.cross(p);
    const Vector3d bias = data_->a[j].linear() + dw.cross(p) + w.cross(rate);
    const Matrix3d& R = X.rotation();
    return {X.act(p), R * rate, R * bias, R * w, R * dw, R};
  }

  void pull(const VectorXd& q, const VectorXd& v) {
    pin::forwardKinematics(model_, *data_, q, v, zero_);
    for (auto& f : forces_) f.setZero();
    for (const TreeSpring& s : tree_.springs) {
      const Place a = place(s.first, s.at_first), b = place(s.second, s.at_second);
      const Vector3d span = a.x - b.x;
      const double length = span.norm();
      const Vector3d along = span / length;
      const Vector3d F = -(s.stiffness * (length - s.length) + s.damping * along.dot(a.rate - b.rate)) * along;
      add_force(s.first, s.at_first, a.R.transpose() * F);
      if (s.second >= 0) add_force(s.second, s.at_second, -(b.R.transpose() * F));
    }
  }
  void add_force(int body, const double* at, const Vector3d& F) {
    forces_[joint_number(body)] += pin::Force(F, vector(at).cross(F));
  }

  // Phi, J, the rates of all constraints, and gamma.
  void look(const VectorXd& q, const VectorXd& v) {
    pin::forwardKinematics(model_, *data_, q, v, zero_);
    pin::computeJointJacobians(model_, *data_);
    int row = 0;
    for (const TreeClosure& c : tree_.closures) {
      const Place a = place(c.first, c.at_first), b = place(c.second, c.at_second);
      const Vector3d e = a.x - b.x, rate = a.rate - b.rate, turned = rate - b.w.cross(e);
      const Vector3d bias = a.bias - b.bias - b.w_bias.cross(e) - b.w.cross(rate) - b.w.cross(turned);
      const int n = static_cast<int>(c.rows.size());
      for (int k = 0; k < n; ++k) {
        const Vector3d axis = b.R.col(c.rows[static_cast<std::size_t>(k)] - 'x');
        Phi_[row + k] = axis.dot(e);
        rate_[row + k] = axis.dot(turned);
        gamma_[row + k] = -axis.dot(bias);
        add_path(row + k, c.first, axis, a.x, 1);
        add_path(row + k, c.second, axis, a.x, -1);  // the point of b rotates with e: a.x
      }
      row += n;
    }
  }
  void add_path(int row, int body, const Vector3d& axis, const Vector3d& x, double sign) {
    if (sign > 0) J_.row(row).setZero();
    for (int i = body; i >= 0; i = tree_.bodies[static_cast<std::size_t>(i)].parent) {
      const auto S = data_->J.col(i);
      J_(row, i) += sign * axis.dot(S.head<3>() + S.tail<3>().cross(x));
    }
  }

  void solve_with_rows(const VectorXd& q, const VectorXd& v, VectorXd& vdot) {
    pin::crba(model_, *data_, q, pin::Convention::WORLD);
    pin::nonLinearEffects(model_, *data_, q, v);
    look(q, v);
    M_.compute(data_->M.selfadjointView<Eigen::Upper>());
    f_ = tau_ - data_->nle;
    for (std::size_t j = 1; !tree_.springs.empty() && j < forces_.size(); ++j) add_load(j);
    Y_ = J_.transpose();
    M_.matrixL().solveInPlace(Y_);
    M_.matrixL().solveInPlace(f_);
    G_.noalias() = Y_.transpose() * Y_;
    residual_ = gamma_ - Y_.transpose() * f_;
    f_ += Y_ * solve_symmetric(residual_);
    M_.matrixU().solveInPlace(f_);
    vdot = f_;
  }
  void add_load(std::size_t j) {
    if (forces_[j].toVector().isZero(0)) return;
    const pin::Force at_origin = data_->oMi[j].act(forces_[j]);
    for (int i = static_cast<int>(j) - 1; i >= 0; i = tree_.bodies[static_cast<std::size_t>(i)].parent) {
      f_[i] += data_->J.col(i).dot(at_origin.toVector());
    }
  }
  // Solves G_ x = b; the least-norm x if constraints are redundant.
  const VectorXd& solve_symmetric(const VectorXd& b) {
    factor_.compute(G_);
    const auto d = factor_.vectorD().cwiseAbs();
    if (d.minCoeff() > 1e-11 * d.maxCoeff()) {
      x_ = factor_.solve(b);
    } else {
      any_rank_.setThreshold(1e-9);
      x_ = any_rank_.compute(G_).solve(b);
    }
    return x_;
  }
  VectorXd least(const VectorXd& residual) {
    G_.noalias() = J_ * J_.transpose();
    return J_.transpose() * solve_symmetric(residual);
  }

  TreeFile tree_;
  bool proximal_;
  bool holds_ = false;
  int rows_ = 0;
  long evaluations_ = 0;
  pin::Model model_;
  std::unique_ptr<pin::Data> data_;
  std::vector<pin::RigidConstraintModel> constraints_;
  std::vector<pin::RigidConstraintData> constraint_data_;
  pin::ProximalSettings settings_{1e-12, 1e-10, 10};
  std::vector<pin::Force> forces_;
  VectorXd tau_, held_, zero_, Phi_, rate_, gamma_, f_, residual_, x_;
  MatrixXd J_, Y_, G_;
  Eigen::LLT<MatrixXd> M_;
  Eigen::LDLT<MatrixXd> factor_;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> any_rank_;
};

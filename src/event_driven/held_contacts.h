// SPDX-License-Identifier: BSD-3-Clause
// Closed contacts where derivatives are taken, in modes that are held: the rows of what they keep are constraint
// equations like any other, and their forces loads. With the rows R and B of contact_equations.h, of which x are the
// multipliers, the derivatives of
//
//   r(q, v, vdot, lambda, u) - B(q, v)^T x = 0,   c(q, v, vdot) = 0,   R(q) vdot + (rates of R) v = 0
//
// give those of vdot, lambda and x. The gaps remain closed: displacements are along them. At rest what sticks has no
// displacement either, to first order (the constraint R v = 0 is then integrable).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "derivatives/residual_evaluator.h"
#include "event_driven/contact_equations.h"
#include "event_driven/friction_treatment.h"
#include "event_driven/law_edge.h"
#include "math/dual.h"

namespace gelenk {

class HeldContacts {
 public:
  // All must outlive it. loads: with the laws of contacts.
  HeldContacts(const Mechanism& mechanism, Dynamics& dynamics, const Loads& loads);

  void hold(const ContactHold& how);
  // Whether a contact is closed; all that follows is for closed contacts.
  bool any() const { return !equations_.closed().empty(); }

  // Adds their effect to the vdot of the last solve(u) of `dynamics` at velocities v, and solves once more with their
  // forces as loads, which remain loads until withdraw().
  void set_point(const double* v, const double* u, double* vdot);
  void withdraw();

  // --- at that point; directions are columns ---
  // Changes displacements by the least amounts in the mass metric along which contacts remain closed.
  void close(Eigen::MatrixXd& displacements) const;
  // The derivatives of the velocities that are kept, where those of q and v are set in `of`; and changes velocities by
  // the least amounts that remove them.
  Eigen::MatrixXd kept_speeds(const ResidualEvaluator<Dual>& of, Eigen::Index directions);
  void stop(const Eigen::MatrixXd& kept, Eigen::MatrixXd& dv) const;
  // Applies the forces to `of`, with the derivatives dx of their multipliers. shows_redundant: those of forces on links
  // that are redundant are not a number, nor are those of reactions, then.
  void apply(ResidualEvaluator<Dual>& of, const Eigen::MatrixXd& dx, bool shows_redundant);
  // The derivatives of the accelerations that are kept, after set_acceleration().
  Eigen::MatrixXd kept_accelerations(const ResidualEvaluator<Dual>& of, Eigen::Index directions);
  // a: derivatives of vdot without the change of the forces, kept: those of kept accelerations with none of vdot. dx <-
  // the change of the multipliers that keep them zero, of least norm.
  Eigen::VectorXd change_of_forces(const Eigen::VectorXd& a, const Eigen::VectorXd& kept);
  // The generalized forces of multipliers.
  Eigen::VectorXd generalized(const Eigen::VectorXd& x) const { return B_.transpose() * x; }
  Eigen::Index rows() const { return R_.rows(); }
  // Multipliers without effect on what is kept, in columns: those of the solution may have any amount of them.
  const Eigen::MatrixXd& redundant() const { return redundant_; }
  // Those that apply() applies.
  const Eigen::VectorXd& multipliers() const { return x_; }
  void set_multipliers(const Eigen::VectorXd& x) { x_ = x; }
  // The largest acceleration by one of them of size 1, were nothing kept.
  double largest_response() const { return equations_.last_solution().responses.cwiseAbs().maxCoeff(); }
  // A contact of which such multipliers, a column of redundant(), contain forces.
  int contact_of(const Eigen::VectorXd& redundant) const;

  // A contact of which the friction depends on redundant normal forces, so that their changes matter; -1: none.
  int ambiguous_contact() const;
  // The forces on the bodies with the first surface, by contact of the scene, along the axes of the root frame, with
  // the changes of the last apply(); undetermined where they are redundant.
  const std::vector<Vector3<Dual>>& forces() const { return forces_; }

 private:
  template <class T>
  struct Placed;
  template <class T>
  Placed<T> placed(const ResidualEvaluator<T>& of, const ContactEquations::Entry& entry, bool accelerates) const;
  // On the tip, at the point of contact.
  template <class T>
  struct Exerted {
    Vector3<T> force, moment;
  };
  Exerted<Dual> exerted(const ContactEquations::Entry& entry, const Placed<Dual>& here,
                        const Eigen::MatrixXd& dx) const;
  Exerted<double> exerted(const ContactEquations::Entry& entry, const Eigen::VectorXd& x) const;
  void find_redundant_forces();

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  const Loads& loads_;
  std::vector<ContactLaw> laws_;  // that are held
  ContactEquations equations_;
  ContactEquations::RowMatrix R_, B_, closing_, closing_responses_, stopping_responses_;
  Eigen::MatrixXd closing_inverse_, stopping_inverse_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd redundant_;
  std::vector<bool> redundant_links_, redundant_contacts_;  // that these act on, and of the scene
  std::vector<Spatial::Force> wrenches_;
  std::vector<typename SpatialAlgebra<Dual>::Force> dual_wrenches_;
  std::vector<Vector3<Dual>> forces_;
  LeastNormSolver least_norm_;
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/impact_equations.h"

#include <utility>

#include "element/contacts/contact.h"
#include "kinematics/loads.h"
#include "math/bounds.h"

namespace gelenk {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Cone cone_of(const ContactEquations::Entry& entry, const std::array<double, contact_groups>& coefficients) {
  Cone cone;
  cone.first = entry.first;
  cone.tangential = entry.rows[0] < 0 ? 0 : 2;
  cone.spin = entry.rows[1] < 0 ? 0 : 1;
  cone.roll = entry.rows[2] < 0 ? 0 : 2;
  cone.friction = coefficients[0];
  cone.spinning = coefficients[1];
  cone.rolling = coefficients[2];
  return cone;
}

ImpactEquations::ImpactEquations(ContactEquations& contact_equations, SwitchingForces& forces,
                                 const std::vector<int>& candidates, const std::vector<JointImpacts::Struck>& joints,
                                 const double* v, double slow)
    : forces_(forces) {
  Index contacts = 0;
  if (!candidates.empty()) {
    contact_equations.build(candidates, contact_equations.modes(), false, rows_);
    contact_equations.respond(rows_.R, Z_);
    contacts = rows_.R.rows();
  }
  for (const JointImpacts::Struck& at : joints) locks_.push_back(at.lock);
  const auto bounds = static_cast<Index>(joints.size());
  MatrixXd G(contacts + bounds, contacts + bounds);
  VectorXd speeds(G.rows());
  if (contacts > 0) {
    const MatrixXd of_contacts = rows_.R * Z_;
    G.topLeftCorner(contacts, contacts) = (of_contacts + of_contacts.transpose()) / 2;
    speeds.head(contacts) = rows_.R * Eigen::Map<const VectorXd>(v, rows_.R.cols()) + rows_.demanded;
  }
  MatrixXd W;
  VectorXd scale;
  if (bounds > 0) forces.compliance(locks_, W, scale);
  G.bottomRightCorner(bounds, bounds) = W;
  for (Index i = 0; i < bounds; ++i) {
    const JointImpacts::Struck& at = joints[static_cast<std::size_t>(i)];
    const Index row = contacts + i;
    speeds[row] = forces.speed(at.lock, v);
    for (Index k = 0; k < contacts; ++k) {
      const VectorXd response = Z_.col(k);
      // What constraint equations determine moves by no impulse; else it would, by rounding.
      G(row, k) = G(k, row) = W(i, i) > 0 ? forces.speed(at.lock, response.data()) : 0;
    }
  }
  std::vector<Impact::Struck> struck;
  for (const ContactEquations::Entry& entry : rows_.entries) struck.push_back(contact(contact_equations, entry, slow));
  for (std::size_t i = 0; i < struck.size(); ++i) {
    Impact::Struck& at = struck[i];
    if (speeds[at.cone.first] < -slow) at.restitution = contact_equations.law(candidates[i]).restitution;
  }
  for (std::size_t i = 0; i < joints.size(); ++i) struck.push_back(joint(joints[i], contacts + static_cast<Index>(i)));
  law_.emplace(std::move(G), std::move(speeds), std::move(struck));
}

Impact::Struck ImpactEquations::contact(const ContactEquations& contact_equations, const ContactEquations::Entry& entry,
                                        double slow) const {
  std::array<double, contact_groups> coefficients{};
  for (int g = 0; g < contact_groups; ++g) {
    const bool slips = entry.slip[static_cast<std::size_t>(g)].norm() > slow;
    coefficients[static_cast<std::size_t>(g)] = contact_equations.coefficient(entry.candidate, g, slips);
  }
  return {.cone = cone_of(entry, coefficients)};
}

Impact::Struck ImpactEquations::joint(const JointImpacts::Struck& at, Index row) const {
  const double lower = at.side > 0 || at.stops ? -unlimited : 0;
  const double upper = at.side < 0 || at.stops ? unlimited : 0;
  return {.cone = Cone::within(static_cast<int>(row), lower, upper),
          .sign = at.side > 0 ? -1.0 : 1.0,
          .restitution = at.restitution,
          .poisson = at.poisson};
}

VectorXd ImpactEquations::accelerations(const double* vdot) const {
  VectorXd out(static_cast<Index>(rows_.entries.size() + locks_.size()));
  Index i = 0;
  for (const ContactEquations::Entry& entry : rows_.entries) {
    const Eigen::Map<const VectorXd> a(vdot, rows_.R.cols());
    out[i++] = rows_.R.row(entry.first).dot(a) + rows_.rates[entry.first];
  }
  for (const int lock : locks_) {
    out[i] = law_->sign(static_cast<std::size_t>(i)) * forces_.speed(lock, vdot);
    ++i;
  }
  return out;
}

void ImpactEquations::apply(double* v) const {
  const VectorXd& x = law_->impulses();
  const Index contacts = rows_.entries.empty() ? 0 : rows_.R.rows();
  if (contacts > 0) Eigen::Map<VectorXd>(v, Z_.rows()) += Z_ * x.head(contacts);
  if (!locks_.empty()) forces_.strike(locks_, x.tail(static_cast<Index>(locks_.size())), v);
}

}  // namespace gelenk

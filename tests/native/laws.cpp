// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "nonsmooth/law_audit.h"
#include "nonsmooth/stop_audit.h"
#include "units.h"

namespace nb = nanobind;

namespace native {
namespace {

using gelenk::BrokenLaw;
using gelenk::SwitchingForces;

// One coordinate with friction (force 0) and a limit (force 1), of which only what the auditor asks is known.
class OneCoordinate final : public SwitchingForces {
 public:
  Lock of;
  double sticking = 0, sliding = 0;
  Depth upper{-INFINITY, 0}, lower{-INFINITY, 0};
  double rounding = 0, largest = 0;

  int locks() const override { return 1; }
  const Lock& lock(int) const override { return of; }
  bool hold_coordinate(int) const override { return false; }
  double engagement(int) const override { return 0; }
  Depth depth(int, int side) const override { return side > 0 ? upper : lower; }
  double speed(int, const double* v) const override { return v[0]; }
  double slack(int) const override { return rounding; }
  double largest_force(int) const override { return largest; }
  int count() const override { return 2; }

  void sides(int*) const override { never(); }
  void indicators(const std::vector<double>&, const double*, double*, double*) const override { never(); }
  bool needs_accelerations() const override { never(); }
  void hold(const int*) override { never(); }
  const int* held_modes() const override { never(); }
  std::span<double> inputs() override { never(); }
  double part_of_friction(int, int) const override { never(); }
  gelenk::DirectedLimit sticking_limit(int) const override { return {sticking, sticking}; }
  gelenk::DirectedLimit slipping_limit(int) const override { never(); }
  gelenk::DirectedLimit sliding_limit(int, double) const override { return {sliding, sliding}; }
  gelenk::LoadDependence& loads() override { never(); }
  gelenk::ContactRows& contact_rows() override { never(); }
  gelenk::HoldingForces& holding_forces() override { never(); }
  bool is_redundant() const override { never(); }
  void distribute_loads(const std::vector<double>&) override { never(); }
  void compliance(const std::vector<int>&, Eigen::MatrixXd&, Eigen::VectorXd&) override { never(); }
  void strike(const std::vector<int>&, const Eigen::VectorXd&, double*) override { never(); }
  void clear(double*) override { never(); }
  bool stop(double*) override { never(); }

 private:
  [[noreturn]] static void never() { throw std::logic_error("not asked for"); }
};

std::string name_of(BrokenLaw::Kind kind) {
  switch (kind) {
    case BrokenLaw::Kind::friction_exceeded:
      return "friction exceeded";
    case BrokenLaw::Kind::friction_along_motion:
      return "friction along motion";
    case BrokenLaw::Kind::limit_pulls:
      return "limit pulls";
    case BrokenLaw::Kind::limit_not_reached:
      return "limit not reached";
    case BrokenLaw::Kind::limit_passed:
      return "limit passed";
    default:
      return "contact";
  }
}

}  // namespace

// The law that a coordinate breaks, or an empty string, and the excess. upper, lower: depth beyond the limits, whose
// tolerance is 1e-12; sticking, sliding: the largest friction at rest and in motion; forces: friction and that of the
// limit.
void bind_laws(nb::module_& m) {
  m.def(
      "broken_law",
      [](const Numbers& forces, double speed, double sticking, double sliding, double upper, double lower, bool one_way,
         double rounding, double largest) {
        OneCoordinate switching_forces;
        switching_forces.of.friction = 0;
        switching_forces.of.frictions = {0};
        switching_forces.of.limit = 1;
        switching_forces.sticking = sticking;
        switching_forces.sliding = sliding;
        switching_forces.of.one_way = one_way;
        switching_forces.upper = {upper, 1e-12};
        switching_forces.lower = {lower, 1e-12};
        switching_forces.rounding = rounding;
        switching_forces.largest = largest;
        const gelenk::LawAudit audit = gelenk::audit_locks(switching_forces, forces, &speed, 1);
        const auto broken = audit.broken();
        return std::pair(broken ? name_of(broken->kind) : std::string(), audit.excess());
      },
      nb::arg("forces"), nb::arg("speed"), nb::arg("sticking"), nb::arg("sliding"), nb::arg("upper"), nb::arg("lower"),
      nb::arg("one_way"), nb::arg("rounding"), nb::arg("largest"));
  // Of velocities before and after what events do to them without impulses.
  m.def(
      "excess_of_stop",
      [](const Numbers& before, const Numbers& after, double rebound) {
        return gelenk::excess_of_stop(before, after, rebound);
      },
      nb::arg("before"), nb::arg("after"), nb::arg("rebound") = 0.0);
}

}  // namespace native

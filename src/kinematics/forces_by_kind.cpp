// SPDX-License-Identifier: BSD-3-Clause
// What depends on the kinds of forces on links; the kernels for double. Those for dual numbers and series are in
// derivatives/forces_by_kind.cpp: in one file, the two prevent each other from being inlined.
#include <algorithm>
#include <array>
#include <span>
#include <variant>
#include <vector>

#include "kinematics/force_kernels_by_kind.h"
#include "kinematics/forces.h"
#include "kinematics/placed_forces.h"
#include "util/stored_impl.h"

namespace gelenk {
namespace {

// A port of which no more is known than its position: of other forces undefined() looks at axes, which are checked
// by what has them.
struct PortPlace {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  const Eigen::Vector3d& p() const { return at; }
};

// Forces: PlacedForces, or const.
template <class Forces, class Visit>
void each_of_lists(Forces& forces, const Visit& visit) {
  each_list(forces.lists, [&](auto& list) {
    using F = std::decay_t<decltype(list.front().element)>;
    if constexpr (HasFormulas<F>) {
      for (auto& force : list) {
        F::each_formula(force.element, [&](auto& formula) {
          if (formula.is_given()) visit(formula, force.force);
        });
      }
    }
  });
}

}  // namespace

template class Stored<PlacedForces>;

void clear_forces(PlacedForces& forces) {
  each_list(forces.lists, [](auto& list) { list.clear(); });
}

void add_force(PlacedForces& forces, const AnyForce& force, std::span<const Attachment> at, int input, int index) {
  std::visit(
      [&]<class F>(const F& element) {
        PlacedForce<F> placed{.element = element, .at = {}, .input = input, .force = index};
        std::ranges::copy(at.first(placed.at.size()), placed.at.begin());
        std::get<std::vector<PlacedForce<F>>>(forces.lists).push_back(placed);
      },
      force);
}

void add_gravity(PlacedForces& forces, const GravityField& field, double mass, const Attachment& at) {
  PlacedForce<GravityForce> placed{.element = {field, mass}, .at = {at}, .input = 0, .force = -1};
  std::get<std::vector<PlacedForce<GravityForce>>>(forces.lists).push_back(placed);
}

void each_formula(PlacedForces& forces, const VisitFormula& visit) { each_of_lists(forces, visit); }

void each_formula(const PlacedForces& forces, const std::function<void(const Formula&, int force)>& visit) {
  each_of_lists(forces, visit);
}

bool is_empty(const PlacedForces& forces) { return all_empty(forces.lists); }

void mark_links(const PlacedForces& forces, std::vector<bool>& marked) {
  each_list(forces.lists, [&](const auto& list) {
    for (const auto& force : list) {
      if constexpr (requires { force.element.is_local(); }) {
        if (force.element.is_local()) continue;
      }
      for (const Attachment& at : force.at) marked[at.link] = true;
    }
  });
}

std::vector<LinksOfForce> links_of(const PlacedForces& forces) {
  std::vector<LinksOfForce> out;
  each_list(forces.lists, [&](const auto& list) {
    for (const auto& force : list) {
      out.push_back({force.at.size() == 1 ? 0 : force.at.front().link, force.at.back().link});
    }
  });
  return out;
}

int undefined_force(const PlacedForces& forces, const Readings<double>& at) {
  int found = -1;
  each_list(forces.lists, [&](const auto& list) {
    for (const auto& force : list) {
      std::array<PortPlace, std::decay_t<decltype(force)>::ports> ports;
      for (std::size_t k = 0; k < ports.size(); ++k) {
        ports[k].at = at.link_pose(force.at[k].link).point(force.at[k].p);
      }
      if constexpr (requires { force.element.undefined(ports.data()); }) {
        if (found < 0 && force.element.undefined(ports.data())) found = force.force;
      }
    }
  });
  return found;
}

double energy_at(const AnyForce& force, std::span<const Pose3> X_WP) {
  std::array<RecordingPort<double>, max_force_ports> at;
  for (std::size_t k = 0; k < X_WP.size(); ++k) {
    at[k].at = X_WP[k].p;
    at[k].R = X_WP[k].R;
    at[k].R_0W.setIdentity();
  }
  return std::visit(
      [&](const auto& element) -> double {
        if constexpr (requires { element.template energy<double>(at.data()); }) {
          return element.template energy<double>(at.data());
        }
        return 0;
      },
      force);
}

namespace kernels {

template void link_loads(const Model<Planar>&, const Loads&, const double*, Workspace<Planar>&);
template void link_loads(const Model<Spatial>&, const Loads&, const double*, Workspace<Spatial>&);
template void force_branches(const Loads&, const double*, const double*, const Workspace<Planar>&, Dual*);
template void force_branches(const Loads&, const double*, const double*, const Workspace<Spatial>&, Dual*);
template void force_branches(const Loads&, const double*, const double*, const Workspace<Planar>&, double*);
template void force_branches(const Loads&, const double*, const double*, const Workspace<Spatial>&, double*);
template double force_energy(const Loads&, const Workspace<Planar>&);
template double force_energy(const Loads&, const Workspace<Spatial>&);

}  // namespace kernels
}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/articulated_factor.h"

#include "kinematics/revolute_kernels.h"

namespace gelenk {

template <class A>
int ArticulatedFactor<A>::factorize(const std::vector<double>& added, std::span<const char> held) {
  const int n = static_cast<int>(model_.links.size());
  for (int i = 1; i < n; ++i) G_[i] = typename A::ArticulatedInertia(model_.links[i].G);
  for (int i = n - 1; i >= 1; --i) {
    const auto& link = model_.links[i];
    for (int k = link.iv + link.nv - 1; k >= link.iv; --k) {
      U_[k] = kernels::times<A>(link.is_revolute_about_z, G_[i], ws_.S[k]);
      if (!held.empty() && held[k] != 0) continue;
      const double D = kernels::along<A>(link.is_revolute_about_z, ws_.S[k], U_[k]) + added[k];
      if (D <= 0) return k;  // NaN passes and shows up in the accelerations
      root_[k] = 1 / std::sqrt(D);
      inverse_[k] = 1 / D;
      G_[i].subtract(U_[k], inverse_[k]);
    }
    if (link.parent > 0) G_[link.parent].add_moved(G_[i], ws_.X_PL[i]);
  }
  return -1;
}

// Takes velocity k of link i into account in the forces on that link.
template <class A>
inline void ArticulatedFactor<A>::carry_inwards(int i, int k, double* x) const {
  const double left = x[k] - kernels::along<A>(model_.links[i].is_revolute_about_z, ws_.S[k], p_[i]);
  p_[i] += (left * inverse_[k]) * U_[k];
  x[k] = left * root_[k];
}

template <class A>
void ArticulatedFactor<A>::solve_transposed(double* x) const {
  const int n = static_cast<int>(model_.links.size());
  for (int i = 1; i < n; ++i) p_[i] = {};
  for (int i = n - 1; i >= 1; --i) {
    const auto& link = model_.links[i];
    for (int k = link.iv + link.nv - 1; k >= link.iv; --k) carry_inwards(i, k, x);
    if (link.parent > 0) p_[link.parent] += ws_.X_PL[i].to_parent(p_[i]);
  }
}

template <class A>
void ArticulatedFactor<A>::solve_transposed(double* x, std::span<const int> nonzeros) const {
  for (const int k : nonzeros) p_[link_of_[k]] = {};
  for (auto k = nonzeros.rbegin(); k != nonzeros.rend();) {
    const int i = link_of_[*k];
    for (; k != nonzeros.rend() && link_of_[*k] == i; ++k) carry_inwards(i, *k, x);
    Force p = p_[i];
    int inner = i;
    do {  // across links without velocities, which nonzeros do not name
      p = ws_.X_PL[inner].to_parent(p);
      inner = model_.links[inner].parent;
    } while (inner > 0 && model_.links[inner].nv == 0);
    if (inner > 0) p_[inner] += p;
  }
}

template <class A>
void ArticulatedFactor<A>::solve(double* x) const {
  const int n = static_cast<int>(model_.links.size());
  for (int i = 1; i < n; ++i) {
    const auto& link = model_.links[i];
    Motion a = ws_.X_PL[i].to_child(a_[link.parent]);
    for (int k = link.iv; k < link.iv + link.nv; ++k) {
      x[k] = x[k] * root_[k] - A::dot(a, U_[k]) * inverse_[k];
      kernels::add_motion<A>(link.is_revolute_about_z, x[k], ws_.S[k], a);
    }
    a_[i] = a;
  }
}

template <class A>
template <class Solve>
void ArticulatedFactor<A>::by_columns(double* x, int columns, Solve solve) const {
  for (int c = 0; c < columns; ++c) {
    for (int k = 0; k < model_.nv; ++k) column_[k] = x[static_cast<std::size_t>(k) * columns + c];
    solve(column_.data());
    for (int k = 0; k < model_.nv; ++k) x[static_cast<std::size_t>(k) * columns + c] = column_[k];
  }
}

template <class A>
void ArticulatedFactor<A>::solve_transposed(double* x, int columns) const {
  by_columns(x, columns, [this](double* column) { solve_transposed(column); });
}

template <class A>
void ArticulatedFactor<A>::solve(double* x, int columns) const {
  by_columns(x, columns, [this](double* column) { solve(column); });
}

template <class A>
void ArticulatedFactor<A>::multiply(const double* x, double* y) const {
  const int n = static_cast<int>(model_.links.size());
  for (int i = 1; i < n; ++i) {
    const auto& link = model_.links[i];
    Motion a = ws_.X_PL[i].to_child(a_[link.parent]);
    for (int k = link.iv; k < link.iv + link.nv; ++k) {
      y[k] = (x[k] + A::dot(a, U_[k]) * inverse_[k]) / root_[k];
      kernels::add_motion<A>(link.is_revolute_about_z, x[k], ws_.S[k], a);
    }
    a_[i] = a;
  }
}

template <class A>
void ArticulatedFactor<A>::solve_held(std::span<const char> held, double* f) const {
  const int n = static_cast<int>(model_.links.size());
  for (int i = 1; i < n; ++i) p_[i] = {};
  for (int i = n - 1; i >= 1; --i) {
    const auto& link = model_.links[i];
    for (int k = link.iv + link.nv - 1; k >= link.iv; --k) {
      f[k] -= kernels::along<A>(link.is_revolute_about_z, ws_.S[k], p_[i]);
      if (held[k] == 0) p_[i] += (f[k] * inverse_[k]) * U_[k];
    }
    if (link.parent > 0) p_[link.parent] += ws_.X_PL[i].to_parent(p_[i]);
  }
  for (int i = 1; i < n; ++i) {
    const auto& link = model_.links[i];
    Motion a = ws_.X_PL[i].to_child(a_[link.parent]);
    for (int k = link.iv; k < link.iv + link.nv; ++k) {
      const auto needed = A::dot(a, U_[k]) - f[k];
      f[k] = held[k] != 0 ? needed : -needed * inverse_[k];
      if (held[k] == 0) kernels::add_motion<A>(link.is_revolute_about_z, f[k], ws_.S[k], a);
    }
    a_[i] = a;
  }
}

template class ArticulatedFactor<Planar>;
template class ArticulatedFactor<Spatial>;

}  // namespace gelenk

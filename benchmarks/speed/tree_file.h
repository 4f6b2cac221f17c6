// SPDX-License-Identifier: BSD-3-Clause
// Reader of mechanisms in plain numbers, as `to_text` of tree.py writes them.
#pragma once

#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

struct TreeBody {
  std::string name;
  int parent;  // -1: the ground
  bool slides;
  double axis[3], position[3], R[9], mass, com[3], inertia[9];  // R, inertia: row by row
  double q, v, tau, amplitude, omega, phase, damping, stiffness, reference;

  double torque(double t) const { return amplitude == 0 ? tau : tau + amplitude * std::sin(omega * t + phase); }
  double passive(double q_now, double v_now) const { return -damping * v_now - stiffness * (q_now - reference); }
};

struct TreeClosure {
  int first, second;  // bodies; -1: the ground
  std::string rows;   // directions out of "xyz", in the axes of the second body
  double at_first[3], at_second[3];
};

struct TreeSpring {
  int first, second;
  double at_first[3], at_second[3], stiffness, damping, length;
};

struct TreeFile {
  std::string name;
  double stop, sample, gravity[3];
  std::vector<TreeBody> bodies;
  std::vector<TreeClosure> closures;
  std::vector<TreeSpring> springs;

  int samples() const { return static_cast<int>(std::lround(stop / sample)); }
};

inline TreeFile read_tree(const std::string& path) {
  std::ifstream in(path);
  TreeFile tree;
  std::size_t bodies = 0, closures = 0, springs = 0;
  in >> tree.name >> bodies >> closures >> springs >> tree.stop >> tree.sample;
  const auto take = [&](double* out, int n) {
    for (int i = 0; i < n; ++i) in >> out[i];
  };
  take(tree.gravity, 3);
  tree.bodies.resize(bodies);
  tree.closures.resize(closures);
  tree.springs.resize(springs);
  for (TreeBody& b : tree.bodies) {
    in >> b.name >> b.parent >> b.slides;
    take(b.axis, 3);
    take(b.position, 3);
    take(b.R, 9);
    in >> b.mass;
    take(b.com, 3);
    take(b.inertia, 9);
    for (double* x : {&b.q, &b.v, &b.tau, &b.amplitude, &b.omega, &b.phase, &b.damping, &b.stiffness, &b.reference}) {
      in >> *x;
    }
  }
  for (TreeClosure& c : tree.closures) {
    in >> c.first >> c.second >> c.rows;
    take(c.at_first, 3);
    take(c.at_second, 3);
  }
  for (TreeSpring& s : tree.springs) {
    in >> s.first >> s.second;
    take(s.at_first, 3);
    take(s.at_second, 3);
    in >> s.stiffness >> s.damping >> s.length;
  }
  if (!in) throw std::runtime_error(path + ": not a valid file of a mechanism");
  return tree;
}

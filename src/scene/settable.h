// SPDX-License-Identifier: BSD-3-Clause
// Numbers of a scene that parameters can set, identified by their path in the file: "crank.mass", "crank.com[2]".
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// Location of a settable number; valid for every scene with the same elements.
class SettableNumber {
 public:
  enum class Of { constant, body, inertia, joint, along, parent, child, element };

  SettableNumber(Of of, std::size_t owner) : of_(of), owner_(owner) {}
  // A number that is described by a field.
  SettableNumber(Of of, std::size_t owner, const Field* group, const Field& field, int i, int size)
      : of_(of), owner_(owner), i_(i), size_(size), group_(group), field_(&field) {}
  SettableNumber at(int i, int size) const;
  SettableNumber in_section(int section) const;
  SettableNumber along(const JointForceKind& force, int coordinate, const JointKind& joint) const;

  const std::string& owner(const Scene& scene) const;
  std::string path(const Scene& scene) const;         // "crank.com": the same for all components
  std::string index() const;                          // "[2]"; empty for a scalar
  std::string variable(const Scene& scene) const;     // name of the FMU variable: "crank.m", "crank.com[2]"
  std::string unit(const Scene& scene) const;         // spelled as in FMI
  std::string description(const Scene& scene) const;  // completes "crank: ..."
  double min() const;                                 // lower bound; -infinity if there is none
  bool tunable() const { return field_ != nullptr && field_->tunable; }
  // Whether it is a number of a body, or a tunable one of a joint, motor or force.
  bool keeps_positions() const;

  // Reads and writes the number in the scene; a product of inertia is written symmetrically.
  double get(const Scene& scene) const;
  void put(Scene& scene, double value) const;

 private:
  std::string key() const;
  double& place(Scene& scene) const;
  Coordinate coordinate(const Scene& scene) const;

  Of of_;
  std::size_t owner_;
  int i_ = 0, size_ = 1;
  const Field* group_ = nullptr;
  const Field* field_ = nullptr;
  int section_ = -1;
  const JointForceKind* force_ = nullptr;
  const JointKind* joint_ = nullptr;  // of force_
  int coordinate_ = 0;
};

// Returns all settable numbers in the order of the file: bodies, joints, elements.
std::vector<SettableNumber> settable_numbers(const Scene& scene);

// A path that can be a parameter, and the size of its value: "crank.mass" 1, "crank.com" 3.
struct Settable {
  std::string path;
  int size;
};
std::vector<Settable> settables(const Scene& scene);

// Copies gravity and all tunable numbers from another scene with the same elements.
void take_tunables(Scene& scene, const Scene& from);

}  // namespace gelenk

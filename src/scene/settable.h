// SPDX-License-Identifier: BSD-3-Clause
// The numbers of a scene that parameters can set, by the path in the file: "crank.mass", "A.damping", "crank.com[2]".
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// One of them. It fits every scene with the same elements.
class SettableNumber {
 public:
  enum class Of { body, inertia, joint, along, parent, child, element };

  SettableNumber(Of of, std::size_t owner) : of_(of), owner_(owner) {}
  // With a field: of an element of the n-th section, or of what acts along a joint's coordinate.
  SettableNumber(Of of, std::size_t owner, const Field* group, const Field& field, int i, int size)
      : of_(of), owner_(owner), i_(i), size_(size), group_(group), field_(&field) {}
  SettableNumber at(int i, int size) const;
  SettableNumber in_section(int section) const;
  SettableNumber along(const JointForceKind& force, int coordinate, int coordinates) const;

  const std::string& owner(const Scene& scene) const;
  std::string path(const Scene& scene) const;         // "crank.com": the same for all of an array
  std::string index() const;                          // "[2]"; empty: a number alone
  std::string variable(const Scene& scene) const;     // as the FMU calls it: "crank.m", "crank.com[2]"
  std::string unit(const Scene& scene) const;         // FMI's spelling
  std::string description(const Scene& scene) const;  // completes "crank: ..."
  double least() const;                               // that is allowed
  bool tunable() const { return field_ != nullptr && field_->tunable; }

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
  int coordinate_ = 0;
};

// In the order of the file: bodies, joints, elements.
std::vector<SettableNumber> settable_numbers(const Scene& scene);

// What a scene can give parameters for: "crank.mass" 1, "crank.com" 3.
struct Settable {
  std::string path;
  int size;
};
std::vector<Settable> settables(const Scene& scene);

// Gravity, and what tunable parameters set. Both scenes have the same elements.
void take_tunables(Scene& scene, const Scene& from);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "joint/kinds.h"
#include "math/rotations.h"
#include "scene/quantity_groups.h"
#include "scene_file/reader.h"

namespace gelenk {
namespace {

constexpr const char* quaternion_name = "Q";

// One group of start values and the arrays of the joint in which they are stored.
struct Slot {
  QuantityGroup group;
  std::vector<double>& values;
  std::vector<bool>& given;
  std::vector<bool>& fixed;
  std::vector<double>& weight;
};

std::vector<Slot> slots(const JointKind& kind, JointStart& start) {
  std::vector<Slot> out;
  for (const QuantityGroup& g : groups(kind.q))
    out.push_back({g, start.q, start.q_given, start.q_fixed, start.q_weight});
  for (const QuantityGroup& g : groups(kind.v))
    out.push_back({g, start.v, start.v_given, start.v_fixed, start.v_weight});
  return out;
}

void set_flags(std::vector<bool>& flags, const QuantityGroup& group) {
  std::fill_n(flags.begin() + static_cast<std::ptrdiff_t>(group.first), group.size, true);
}

void store(Slot& slot, const double* values) {
  std::copy_n(values, slot.group.size, slot.values.begin() + static_cast<std::ptrdiff_t>(slot.group.first));
  set_flags(slot.given, slot.group);
}

void read_slot(const Json& value, const std::string& path, Faults& faults, Slot& slot) {
  const QuantityGroup& group = slot.group;
  if (!group.array) {
    const auto x = read_number(value, path, faults, group.unit);
    if (x) store(slot, &*x);
    return;
  }
  const auto x = read_list(value, path, faults, group.size, group.unit);
  if (!x) return;
  if (group.name != quaternion_name) return store(slot, x->data());
  const Eigen::Vector4d Q(x->data());
  if (Q.isZero(0)) return faults.add(path, "[0, 0, 0, 0]", "a quaternion [x, y, z, w] other than zero");
  // No rotation, if it were written as [w, x, y, z], as `quaternion` of rotations is.
  if (Q.tail<3>().isZero(0)) {
    faults.warn(
        path, "[" + text::number(Q[0]) + ", 0, 0, 0], half a turn about x",
        "a quaternion [x, y, z, w]; [0, 0, 0, 1] is no rotation, and so is rotation: {quaternion: [1, 0, 0, 0]}");
  }
  store(slot, Eigen::VectorXd(unit(Q)).data());
}

// Reads `rotation`, an alternative to the quaternion.
void read_start_rotation(Fields& fields, std::vector<Slot>& all) {
  const auto slot = std::ranges::find_if(all, [](const Slot& s) { return s.group.name == quaternion_name; });
  if (slot == all.end()) return;
  const Json* rotation = fields.find("rotation");
  if (rotation == nullptr) return;
  const std::string path = fields.path("rotation");
  if (fields.find(quaternion_name) != nullptr) {
    fields.faults().add(path, "a rotation in addition to 'Q'", "one of the two");
    return;
  }
  const auto R = read_rotation(*rotation, path, fields.faults());
  if (!R) return;
  const Eigen::Quaterniond Q(*R);
  store(*slot, Eigen::VectorXd(unit(Q.coeffs())).data());  // the same order as in Eigen: x, y, z, w
}

bool is_given(const Slot& slot) { return slot.given[slot.group.first]; }

// Returns the start value with this name; nullptr, and an error, if it does not exist or is not given.
Slot* given_slot(const std::string& name, const std::string& where, Faults& faults, std::vector<Slot>& all) {
  const std::string base = name == "rotation" ? quaternion_name : name;
  const auto slot = std::ranges::find_if(all, [&](const Slot& s) { return s.group.name == base; });
  if (slot == all.end()) {
    std::vector<std::string> known;
    for (const Slot& s : all) known.push_back(s.group.name);
    faults.add(where, text::quoted(name), text::one_of(name, known, "start values"));
  } else if (!is_given(*slot)) {
    faults.add(where, text::quoted(name) + ", which has no start value", "only values given in 'start'");
  } else {
    return &*slot;
  }
  return nullptr;
}

// Reads fixed: true, false or [names].
void read_fixed(const Json& fixed, const std::string& path, Faults& faults, std::vector<Slot>& all) {
  if (fixed.is_boolean()) {
    for (Slot& slot : all) {
      if (fixed.get<bool>() && is_given(slot)) set_flags(slot.fixed, slot.group);
    }
    return;
  }
  if (!fixed.is_array()) return faults.add(path, shown(fixed), "true, false or a list of names");
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    const std::string where = path + "[" + std::to_string(i + 1) + "]";
    const auto name = read_text(fixed[i], where, faults, "the name of a start value");
    if (!name) continue;
    if (Slot* slot = given_slot(*name, where, faults, all)) set_flags(slot->fixed, slot->group);
  }
}

void set_weight(Slot& slot, double weight) {
  std::fill_n(slot.weight.begin() + static_cast<std::ptrdiff_t>(slot.group.first), slot.group.size, weight);
}

// Reads weight: number or {name: number}.
void read_weight(const Json& weight, const std::string& path, Faults& faults, std::vector<Slot>& all) {
  if (weight.is_number()) {
    const auto x = read_number(weight, path, faults, {}, Range::not_negative);
    if (!x) return;
    for (Slot& slot : all) {
      if (is_given(slot)) set_weight(slot, *x);
    }
    return;
  }
  if (!weight.is_object()) return faults.add(path, shown(weight), "a number, or a mapping from names to numbers");
  for (const auto& [name, value] : weight.items()) {
    const std::string where = path + "." + text::printable(name);
    const auto x = read_number(value, where, faults, {}, Range::not_negative);
    Slot* slot = given_slot(name, where, faults, all);
    if (x && slot != nullptr) set_weight(*slot, *x);
  }
}

}  // namespace

void read_start(const Json& value, const std::string& path, Faults& faults, Joint& joint) {
  const JointKind& kind = *find_joint_kind(joint.type);
  std::vector<Slot> all = slots(kind, joint.start);
  std::vector<std::string> names;
  for (const Slot& slot : all) names.push_back(slot.group.name);
  Fields fields(value, path, faults,
                "a mapping with " + text::list(names) + (names.empty() ? "" : ", ") + "fixed, weight");
  for (Slot& slot : all) {
    const Json* given = fields.find(slot.group.name);
    if (given != nullptr) read_slot(*given, fields.path(slot.group.name), faults, slot);
  }
  read_start_rotation(fields, all);
  const Json* fixed = fields.find("fixed");
  const Json* weight = fields.find("weight");
  fields.done();
  if (fixed != nullptr) read_fixed(*fixed, fields.path("fixed"), faults, all);
  if (weight != nullptr) read_weight(*weight, fields.path("weight"), faults, all);
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "element/constraints/constraint.h"
#include "element/constraints/mesh_losses.h"

namespace gelenk {

// phi_joint - phi_carrier = ratio (phi_with - phi_carrier) + offset. A phi_carrier is omitted if there is no carrier or
// if the joint in question is on the carrier, since its angle is then relative to the carrier already. Losses are
// friction of `joint`.
struct Gear {
  static constexpr std::string_view kind = "gear";
  static constexpr std::string_view summary =
      "two joints rotate at a fixed ratio, relative to a carrier if there is one";
  static constexpr auto is_rotary = [](const JointKind& kind) {
    return kind.nq == 1 && kind.nv == 1 && kind.q[0].unit == "rad";
  };
  static constexpr Port ports[] = {
      {.kind = Port::Kind::joint, .name = "joint", .text = "Joint that rotates", .fits = is_rotary},
      {.kind = Port::Kind::joint, .name = "with", .text = "Joint that it meshes with", .fits = is_rotary},
      {.kind = Port::Kind::joint,
       .name = "carrier",
       .text = "Joint of the carrier, relative to which both rotate; none if not given",
       .optional = true,
       .fits = is_rotary}};

  double ratio = 1;                 // dimensionless
  double offset = 0;                // rad
  Formula efficiency, backdriving;  // see MeshLosses

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Gear::ratio>({.name = "ratio",
                             .unit = "1",
                             .text = "turns of `joint` per turn of `with`",
                             .range = Range::not_zero,
                             .required = true}),
        field<&Gear::offset>({.name = "offset", .unit = "rad", .text = "angle of `joint` when `with` is at 0"}),
        field<&Gear::efficiency>(
            MeshLosses::efficiency_info("part of the power that leaves the mesh if `joint` drives `with`, 1 if not "
                                        "given; may be an expression of the speed w and the torque tau")),
        field<&Gear::backdriving>(
            MeshLosses::backdriving_info("part of the power that leaves the mesh if `with` drives `joint`; 0 or less: "
                                         "it cannot; may be an expression of the speed w and the torque tau"))};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"tau", 0, "N.m", "torque of the gear on joint {joint}"}};

  template <class OnBase>
  double factor(int i, const OnBase& on_base) const {
    if (i == 0) return 1;
    if (i == 1) return -ratio;
    return (on_base(1) ? ratio : 0) - (on_base(0) ? 1 : 0);
  }
  double constant() const { return offset; }
  static constexpr int lossy_joint = 0;
  MeshLosses losses() const { return {efficiency, backdriving}; }
  std::optional<ElementFault> fault(const Coordinate&) const { return losses().fault(); }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }
};

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/contact_state.h"

#include <algorithm>

namespace gelenk {
namespace {

void serialize_vector(Archive& archive, Eigen::Vector3d& x) { archive.serialize(x.x(), x.y(), x.z()); }

}  // namespace

const RememberedContact* ContactState::find(const NearPoint& point) const {
  const auto found = std::ranges::lower_bound(contacts, point.key(), {}, &RememberedContact::key);
  return found != contacts.end() && found->key() == point.key() ? &*found : nullptr;
}

void ContactState::serialize(Archive& archive, int shapes) {
  constexpr int most = 1 << 27;
  int count = static_cast<int>(contacts.size());
  archive.serialize_in_range(count, 0, most);
  if (archive.reading()) contacts.clear();
  for (int i = 0; i < count; ++i) {
    if (archive.reading()) contacts.emplace_back();
    RememberedContact& contact = contacts[static_cast<std::size_t>(i)];
    archive.serialize_in_range(contact.a, 0, shapes - 1);
    archive.serialize_in_range(contact.b, 0, shapes - 1);
    archive.serialize(contact.feature);
    archive.serialize(contact.slides);
    serialize_vector(archive, contact.force);
    serialize_vector(archive, contact.moment);
    archive.serialize(contact.gap, contact.gap_rate);
  }
  for (LockForces& at : locks) {
    archive.serialize(at.friction, at.limit);
    archive.serialize_in_range(at.motion, -1, 1);
    archive.serialize_in_range(at.contact, -1, 1);
    if (any_latch) archive.serialize(at.latch, at.is_latched);
  }
  archive.serialize(along);
  archive.serialize(step);
  for (Spatial::Force& wrench : wrenches) {
    serialize_vector(archive, wrench.n);
    serialize_vector(archive, wrench.f);
  }
  for (ContactSum& contact : sums) {
    serialize_vector(archive, contact.force);
    archive.serialize_in_range(contact.mode, 0, 2);
  }
}

}  // namespace gelenk

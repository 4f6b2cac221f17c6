// SPDX-License-Identifier: BSD-3-Clause
#include "contact/contact_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {

ContactFinder::ContactFinder(const Mechanism& mechanism, std::size_t contacts)
    : mechanism_(mechanism),
      poses_(mechanism.shapes.size()),
      reach_(mechanism.shapes.size()),
      boxes_(mechanism.shapes.size()),
      gaps_(contacts) {}

int ContactFinder::contact_of(int a, int b) const {
  const LinkShape& of_a = mechanism_.shapes[static_cast<std::size_t>(a)];
  const LinkShape& of_b = mechanism_.shapes[static_cast<std::size_t>(b)];
  if (of_a.link == of_b.link) return -1;
  const ContactTable& table = mechanism_.contact_table;
  const int contact = table.contact(of_a.surface, of_b.surface);
  if (contact < 0 || table.touches_joined[static_cast<std::size_t>(contact)]) return contact;
  const std::pair pair(std::min(of_a.scene_body, of_b.scene_body), std::max(of_a.scene_body, of_b.scene_body));
  return std::ranges::binary_search(table.joined, pair) ? -1 : contact;
}

void ContactFinder::place(const Readings<double>& readings) {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const LinkShape& shape = mechanism_.shapes[i];
    poses_[i] = shape.link == 0 ? shape.X_LS : readings.link_pose(shape.link) * shape.X_LS;
  }
}

void ContactFinder::add_points(int a, int b) {
  const int contact = contact_of(a, b);
  if (contact < 0) return;
  const auto& shapes = mechanism_.shapes;
  if (!mechanism_.contact_table.is_first(contact, shapes[static_cast<std::size_t>(a)].surface)) std::swap(a, b);
  const auto i = static_cast<std::size_t>(a);
  const auto j = static_cast<std::size_t>(b);
  ContactPoint found[max_contact_points];
  const int count = find_contacts(shapes[i].is, poses_[i], shapes[j].is, poses_[j], reach_[i] + reach_[j], found);
  for (int k = 0; k < count; ++k) {
    points_.push_back({a, b, contact, found[k].p, found[k].normal, found[k].gap, found[k].feature});
  }
}

const std::vector<TouchPoint>& ContactFinder::find(const Readings<double>& readings, double time, double speed,
                                                   double distance) {
  place(readings);
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const LinkShape& shape = mechanism_.shapes[i];
    reach_[i] = distance;
    if (shape.link != 0) {
      const Spatial::Motion V = readings.link_velocity(shape.link);
      const double arm = shape.X_LS.p.norm() + size_of(shape.is);
      reach_[i] += time * (speed + V.v.norm() + V.w.norm() * arm);
    }
    boxes_[i] = bounds(shape.is, poses_[i]).grown(reach_[i]);
  }
  points_.clear();
  for (const SweepAndPrune::Pair& pair : broad_phase_.pairs(boxes_)) add_points(pair.i, pair.j);
  std::ranges::sort(points_, {}, &TouchPoint::key);
  return points_;
}

const std::vector<double>& ContactFinder::smallest_gaps(const Readings<double>& readings) {
  place(readings);
  const auto same = [](const Pose3& a, const Pose3& b) { return a.R == b.R && a.p == b.p; };
  if (std::ranges::equal(poses_, gap_poses_, same)) return gaps_;
  gap_poses_ = poses_;
  std::ranges::fill(gaps_, std::numeric_limits<double>::infinity());
  std::ranges::fill(reach_, std::numeric_limits<double>::infinity());
  points_.clear();
  for (int a = 0; a < static_cast<int>(poses_.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(poses_.size()); ++b) add_points(a, b);
  }
  for (const TouchPoint& point : points_) {
    double& gap = gaps_[static_cast<std::size_t>(point.contact)];
    gap = std::min(gap, point.gap);
  }
  return gaps_;
}

int closed_contact(const Mechanism& mechanism, const Readings<double>& readings, std::size_t contacts) {
  if (mechanism.shapes.empty()) return -1;
  ContactFinder finder(mechanism, contacts);
  const std::vector<double>& gaps = finder.smallest_gaps(readings);
  const auto closed = std::ranges::find_if(gaps, [](double gap) { return gap <= touch_tolerance; });
  return closed == gaps.end() ? -1 : static_cast<int>(closed - gaps.begin());
}

}  // namespace gelenk

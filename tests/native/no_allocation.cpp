// SPDX-License-Identifier: BSD-3-Clause
// Prints the number of heap allocations of contact detection, after a first call, over all pairs of shapes.
#include <cstdio>
#include <cstdlib>
#include <new>
#include <random>

#include "collision/contacts.h"
#include "collision/sweep_and_prune.h"
#include "shape/registry.h"

namespace {

long calls = 0;

}  // namespace

void* operator new(std::size_t n) {
  ++calls;
  if (void* p = std::malloc(n)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

int main() {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Eigen::Vector3d(normal(generator), normal(generator), normal(generator)); };
  const auto pose = [&] {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(normal(generator), normal(generator), normal(generator), 1).normalized();
    return gelenk::Pose3{q.toRotationMatrix(), 0.3 * vector()};
  };
  std::vector<gelenk::AnyShape> shapes;
  for (std::size_t n = 0; n < gelenk::shape_kinds().size(); ++n) shapes.push_back(*gelenk::make_shape(n));
  std::array<gelenk::ContactPoint, gelenk::max_contact_points> out;
  std::vector<gelenk::Aabb> boxes(200);
  gelenk::SweepAndPrune search;
  long points = 0;
  for (int round = 0; round < 100; ++round) {
    if (round == 1) calls = 0;
    for (const auto& A : shapes)
      for (const auto& B : shapes) points += gelenk::find_contacts(A, pose(), B, pose(), 0.1, out.data());
    // The same number of pairs each time: translated boxes.
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Eigen::Vector3d p(static_cast<double>(i % 10 + round), static_cast<double>(i / 10), 0);
      boxes[i] = {p.array() - 0.6, p.array() + 0.6};
    }
    points += static_cast<long>(search.pairs(boxes).size());
  }
  std::printf("%ld %ld\n", calls, points);
}

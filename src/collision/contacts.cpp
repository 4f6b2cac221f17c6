// SPDX-License-Identifier: BSD-3-Clause
#include "collision/contacts.h"

#include "collision/contact_set.h"
#include "collision/pairs.h"
#include "shape/registry.h"

namespace gelenk {
namespace {

template <class A, class B>
concept Analytic = requires(const A& a, const B& b, const Pose3& X, ContactSet& out) { contacts(a, X, b, X, out); };

struct Pair {
  const AnyShape& A;
  const AnyShape& B;
  Pose3 X_A, X_B;
  ContactSet& out;

  template <class a, class b>
  void operator()(const a& shape_A, const b& shape_B) const {
    if constexpr (Analytic<a, b>) {
      contacts(shape_A, X_A, shape_B, X_B, out);
    } else if constexpr (!a::bounded && b::bounded) {
      plane_contacts(X_A, shape_B, X_B, out);
    } else if constexpr (a::bounded && !b::bounded) {
      plane_contacts(X_B, shape_A, X_A, out);
    } else if constexpr (a::bounded && b::bounded) {
      convex_contacts(A, X_A, B, X_B, out);
    }
  }
};

}  // namespace

int find_contacts(const AnyShape& A, const Pose3& X_WA, const AnyShape& B, const Pose3& X_WB, double margin,
                  ContactPoint* out) {
  // The order of AnyShape, with half-spaces first since their routines have the normal from the half-space to the
  // shape.
  const auto rank = [](const AnyShape& shape) { return kind_of(shape).bounded ? static_cast<int>(shape.index()) : -1; };
  const bool exchange = rank(A) > rank(B);
  const AnyShape& first = exchange ? B : A;
  const AnyShape& second = exchange ? A : B;
  const Pose3& X_first = exchange ? X_WB : X_WA;
  const Pose3& X_second = exchange ? X_WA : X_WB;
  const Eigen::Vector3d origin = X_second.p;
  // Squares of larger distances are not finite: what has diverged touches nothing.
  constexpr double farthest = 1e100;
  if (!((X_first.p - origin).norm() < farthest) || !X_WA.R.allFinite() || !X_WB.R.allFinite()) return 0;
  ContactSet found(margin);
  std::visit(Pair{first, second, {X_first.R, X_first.p - origin}, {X_second.R, Eigen::Vector3d::Zero()}, found}, first,
             second);
  return found.write(origin, exchange, out);
}

}  // namespace gelenk

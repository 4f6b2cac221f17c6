// SPDX-License-Identifier: BSD-3-Clause
// Relations and surfaces for numbers that record.
#include "element/constraints/relation_law_impl.h"
#include "element/constraints/surface_law_impl.h"
#include "recorded/recorded_algebra.h"

namespace gelenk {

template Recorded RelationLaw::value(const Recorded*, const Recorded*, Recorded*) const;
template Recorded RelationLaw::bias(const Recorded*, const Recorded*) const;
template SurfaceLaw::Place<Recorded> SurfaceLaw::place(const Vector3<Recorded>&) const;
template Vector3<Recorded> SurfaceLaw::normal_rate(const Vector3<Recorded>&, const Vector3<Recorded>&) const;

}  // namespace gelenk

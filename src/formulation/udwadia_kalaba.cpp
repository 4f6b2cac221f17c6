// SPDX-License-Identifier: BSD-3-Clause
// `udwadia-kalaba`: with a = M^-1 (tau - h),
//   vdot = a + M^-1/2 (J M^-1/2)^+ (gamma - J a)     (Udwadia & Kalaba 1992),
// with M^1/2 replaced by the factor L of M = L^T L, which gives the same vdot; the pseudo-inverse is that of
// dynamics/row_factor.h. Nothing stabilizes q and v: position errors grow with the square of time.
#include "formulation/formulation.h"

namespace gelenk {
namespace {

class UdwadiaKalaba final : public Formulation {
 public:
  using Formulation::Formulation;
};

}  // namespace

std::unique_ptr<Formulation> make_udwadia_kalaba(const FormulationContext& context) {
  return std::make_unique<UdwadiaKalaba>(context);
}

}  // namespace gelenk

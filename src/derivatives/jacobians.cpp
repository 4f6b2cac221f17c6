// SPDX-License-Identifier: BSD-3-Clause
#include "derivatives/jacobians.h"

namespace gelenk {

void Jacobians::clear(int nq, int nv, int rows, int inputs, int states) {
  r.setZero(nv, nq + nv);
  c.setZero(rows, nq + nv);
  qdot_q.setZero(nq, nq);
  qdot_v.setZero(nq, nv);
  if (of_rows) Phi_q.setZero(rows, nq);
  if (of_rows) rate_q.setZero(rows, nq);
  if (of_inputs || states > 0) r_u.setZero(nv, inputs);
  if (states == 0) return;
  rates.setZero(states, nq + nv);
  rates_u.setZero(states, inputs);
}

}  // namespace gelenk

# SPDX-License-Identifier: BSD-3-Clause
"""Parts of C texts that are the same for all scenes: solving for accelerations, steps. NAME: prefix."""

from __future__ import annotations

SOLVE_TREE = """
/* Solves M x = f by M = L D L^T. Returns 0 if M is singular. */
static int NAME_solve(double M[], const double f[], double x[]) {
  const int n = NAME_nv;
  for (int i = 0; i < n; ++i) {
    const double diagonal = M[i * n + i];
    x[i] = f[i];
    for (int j = 0; j < i; ++j) {
      for (int k = 0; k < j; ++k) M[i * n + j] -= M[i * n + k] * M[j * n + k] * M[k * n + k];
      M[i * n + j] /= M[j * n + j];
      M[i * n + i] -= M[i * n + j] * M[i * n + j] * M[j * n + j];
      x[i] -= M[i * n + j] * x[j];
    }
    if (!(M[i * n + i] > 1e-14 * diagonal)) return 0;
  }
  for (int i = n - 1; i >= 0; --i) {
    x[i] /= M[i * n + i];
    for (int j = i + 1; j < n; ++j) x[i] -= M[j * n + i] * x[j];
  }
  return 1;
}
"""

# The matrix is indefinite: complete pivoting is stable, and leaves redundant equations to the end. Scaled,
# its entries are of order 1; pivots below 1e-11 are rounding errors of those. A constraint equation with
# tiny coefficients, which may be rounding errors, must not be scaled to 1.
SOLVE_CONSTRAINED = """
/* Solves [M J^T; J 0] [x; lambda] = [f; c]; multipliers of redundant equations are 0.
   Returns 0 if x is not determined. */
static int NAME_solve(const double M[], const double J[], const double f[], const double c[],
                      double x[], double lambda[]) {
  enum { n = NAME_nv, N = NAME_nv + NAME_rows };
  double A[N][N], B[N][N], b[N], scale[N], y[N], z[N] = {0}, largest = 0;
  int row_of[N], place[N], rank = 0;
  for (int i = 0; i < N; ++i) {
    double size = 0;
    for (int k = 0; i >= n && k < n; ++k) size = fmax(size, fabs(J[(i - n) * n + k] * scale[k]));
    if (i < n) size = sqrt(fabs(M[i * n + i]));
    else largest = fmax(largest, size);
    scale[i] = i >= n ? size : size > 0 ? 1 / size : 1;
  }
  for (int i = n; i < N; ++i) {
    const double size = scale[i] > 1e-6 * largest ? scale[i] : largest;
    scale[i] = size > 0 ? 1 / size : 1;
  }
  for (int i = 0; i < N; ++i) {
    row_of[i] = place[i] = i;
    for (int k = 0; k <= i; ++k) {
      const double entry = i < n ? M[i * n + k] : k < n ? J[(i - n) * n + k] : 0;
      A[i][k] = A[k][i] = B[i][k] = B[k][i] = entry * scale[i] * scale[k];
    }
    b[i] = (i < n ? f[i] : c[i - n]) * scale[i];
  }
  for (; rank < N; ++rank) {
    int row = rank, column = rank;
    for (int i = rank; i < N; ++i)
      for (int k = rank; k < N; ++k)
        if (fabs(A[i][k]) > fabs(A[row][column])) row = i, column = k;
    if (!(fabs(A[row][column]) > 1e-11)) break;
    for (int k = 0; k < N; ++k) { const double a = A[row][k]; A[row][k] = A[rank][k]; A[rank][k] = a; }
    for (int i = 0; i < N; ++i) { const double a = A[i][column]; A[i][column] = A[i][rank]; A[i][rank] = a; }
    { const int k = row_of[row]; row_of[row] = row_of[rank]; row_of[rank] = k; }
    { const int k = place[column]; place[column] = place[rank]; place[rank] = k; }
    for (int i = rank + 1; i < N; ++i) {
      A[i][rank] /= A[rank][rank];
      for (int k = rank + 1; k < N; ++k) A[i][k] -= A[i][rank] * A[rank][k];
    }
  }
  for (int i = rank; i < N; ++i) if (place[i] < n) return 0;
  /* The second time corrects rounding errors. */
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0; i < rank; ++i) {
      y[i] = b[row_of[i]];
      for (int k = 0; k < N; ++k) y[i] -= B[row_of[i]][k] * z[k];
      for (int k = 0; k < i; ++k) y[i] -= A[i][k] * y[k];
    }
    for (int i = rank - 1; i >= 0; --i) {
      for (int k = i + 1; k < rank; ++k) y[i] -= A[i][k] * y[k];
      y[i] /= A[i][i];
    }
    for (int i = 0; i < rank; ++i) z[place[i]] += y[i];
  }
  for (int i = 0; i < N; ++i) *(i < n ? &x[i] : &lambda[i - n]) = z[i] * scale[i];
  return 1;
}
"""


def accelerations(is_constrained: bool) -> str:
    """Return the function that computes accelerations and multipliers."""
    if not is_constrained:
        return """
/* Accelerations. Returns 0 if the mass matrix is singular. */
int NAME_accelerations(const double q[], const double v[], const double u[], double vdot[]) {
  double M[NAME_nv * NAME_nv], h[NAME_nv];
  NAME_equations(q, v, u, M, h);
  for (int k = 0; k < NAME_nv; ++k) h[k] = -h[k];
  return NAME_solve(M, h, vdot);
}
"""
    return """
/* Accelerations and multipliers. Returns 0 if they are not determined. */
int NAME_accelerations(const double q[], const double v[], const double u[], double vdot[],
                       double lambda[]) {
  double M[NAME_nv * NAME_nv], h[NAME_nv], J[NAME_rows * NAME_nv], gamma[NAME_rows];
  NAME_equations(q, v, u, M, h, J, gamma);
  for (int k = 0; k < NAME_nv; ++k) h[k] = -h[k];
  return NAME_solve(M, J, h, gamma, vdot, lambda);
}
"""


STEP = """
/* Advances q and v by dt under constant u: the Runge-Kutta method of order 4PROJECTION
   Returns 0 if the accelerations are not determined. */
int NAME_step(double q[], double v[], const double u[], double dt) {
  static const double at[] = {0, 0.5, 0.5, 1}, weight[] = {1, 2, 2, 1};
  double q1[NAME_nq], v1[NAME_nv], qdot[NAME_nq] = {0}, vdot[NAME_nv] = {0};
  double dq[NAME_nq] = {0}, dv[NAME_nv] = {0};
  for (int stage = 0; stage < 4; ++stage) {
    for (int k = 0; k < NAME_nq; ++k) q1[k] = q[k] + at[stage] * dt * qdot[k];
    for (int k = 0; k < NAME_nv; ++k) v1[k] = v[k] + at[stage] * dt * vdot[k];
    NAME_qdot(q1, v1, qdot);
    if (!NAME_accelerations(q1, v1, u, vdot)) return 0;
    for (int k = 0; k < NAME_nq; ++k) dq[k] += weight[stage] * dt / 6 * qdot[k];
    for (int k = 0; k < NAME_nv; ++k) dv[k] += weight[stage] * dt / 6 * vdot[k];
  }
  for (int k = 0; k < NAME_nq; ++k) q[k] += dq[k];
  for (int k = 0; k < NAME_nv; ++k) v[k] += dv[k];
  return 1;
}
"""

# Positions are projected three times, each of which squares the error of the step, then velocities.
PROJECT = """\
  double M[NAME_nv * NAME_nv], h[NAME_nv], J[NAME_rows * NAME_nv], gamma[NAME_rows], gap[NAME_rows];
  for (int pass = 0; pass < 4; ++pass) {
    if (pass < 3) NAME_constraints(q, u, gap);
    else NAME_rates(q, v, u, gap);
    NAME_equations(q, v, u, M, h, J, gamma);
    for (int k = 0; k < NAME_nv; ++k) h[k] = 0;
    for (int r = 0; r < NAME_rows; ++r) gap[r] = -gap[r];
    if (!NAME_solve(M, J, h, gap, dv, lambda)) return 0;
    NAME_qdot(q, dv, dq);
    for (int k = 0; pass < 3 && k < NAME_nq; ++k) q[k] += dq[k];
    for (int k = 0; pass == 3 && k < NAME_nv; ++k) v[k] += dv[k];
  }
"""


def step(is_constrained: bool) -> str:
    """Return the function that makes a step."""
    if not is_constrained:
        return STEP.replace("PROJECTION", ".")
    return (
        STEP.replace("PROJECTION", ",\n   then projection onto the constraints.")
        .replace("dv[NAME_nv] = {0};", "dv[NAME_nv] = {0}, lambda[NAME_rows];")
        .replace("u, vdot)", "u, vdot, lambda)")
        .replace("  return 1;\n", f"{PROJECT}  return 1;\n")
    )

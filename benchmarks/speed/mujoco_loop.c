/* SPDX-License-Identifier: BSD-3-Clause
 * Loops around MuJoCo in C, so that the time of Python loops is not measured. Loaded next to the wheel's library. */
#include <math.h>
#include <mujoco/mujoco.h>

#include "ref_kernel.h"

/* By joint of the model: tau, amplitude, omega, phase, stiffness, reference. Damping is part of the model's joints. */
static double* motors;
static int joints;

static void drive(const mjModel* m, mjData* d) {
  (void)m;
  for (int i = 0; i < joints; ++i) {
    const double* p = motors + 6 * i;
    double force = p[0];
    if (p[1] != 0) force += p[1] * sin(p[2] * d->time + p[3]);
    if (p[4] != 0) force -= p[4] * (d->qpos[i] - p[5]);
    d->qfrc_applied[i] = force;
  }
}

/* The pointer is kept, the numbers are not copied; n = 0: no motors. */
void set_motors(int n, double* numbers) {
  joints = n;
  motors = numbers;
  mjcb_control = n > 0 ? drive : 0;
}

/* Time of one mj_forward [s]. */
double time_forward(const mjModel* m, mjData* d, int calls) {
  const double q = d->qpos[0], begin = cpu_seconds();
  for (int i = 0; i < calls; ++i) {
    d->qpos[0] = q + 1e-9 * (i % 8);
    mj_forward(m, d);
  }
  d->qpos[0] = q;
  return (cpu_seconds() - begin) / calls;
}

/* Time of `steps` calls of mj_step [s]. */
double time_steps(const mjModel* m, mjData* d, int steps) {
  const double begin = cpu_seconds();
  for (int i = 0; i < steps; ++i) mj_step(m, d);
  return cpu_seconds() - begin;
}

/* Time of one mj_step [s] with new forces from the rows of the table; the springs of the motors remain. */
double time_driven_steps(const mjModel* m, mjData* d, int steps, const double* forces) {
  const int n = m->nv;
  const double begin = cpu_seconds();
  for (int i = 0; i < steps; ++i) {
    for (int k = 0; k < n; ++k) *(joints > 0 ? motors + 6 * k : d->qfrc_applied + k) = forces[i * n + k];
    mj_step(m, d);
  }
  return (cpu_seconds() - begin) / steps;
}

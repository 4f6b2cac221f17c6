/* SPDX-License-Identifier: BSD-3-Clause
 * A control loop around an FMU: sets a torque, makes a step of 1 ms, reads the outputs, and times each round by the
 * thread's clock, including its reading. Additional argument: number of rounds. Prints the median, the 99.9 % and
 * 99.999 % quantiles and the maximum in microseconds. */
#define _GNU_SOURCE
#include <time.h>

#include "c_host.h"

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

static int ascending(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

int main(int argc, char** argv) {
  double values[512];
  take_arguments(argc, argv);
  if (argc != 8) return 2;
  const long rounds = atol(argv[7]);
  double* took = malloc((size_t)rounds * sizeof *took);
  fmi2Component c = instantiate();
  if (took == NULL || c == NULL || initialize(c, 0) != fmi2OK) return 4;
  fmi2SetRealTYPE* set_real = CALL(fmi2SetReal);
  fmi2GetRealTYPE* get_real = CALL(fmi2GetReal);
  fmi2DoStepTYPE* do_step = CALL(fmi2DoStep);
  for (long k = 0; k < rounds; ++k) {
    const double torque = (double)(k * 7919 % 200 - 100) * 0.02; /* a new value in every step, 2 N.m at most */
    const double begin = now();
    int bad = set_real(c, &input, 1, &torque);
    bad |= do_step(c, 1e-3 * (double)k, 1e-3, fmi2True);
    bad |= get_real(c, outputs, n_outputs, values);
    took[k] = now() - begin;
    if (bad) return 5;
  }
  qsort(took, (size_t)rounds, sizeof *took, ascending);
#define SHARE(x) took[(long)((double)(rounds - 1) * (x))]
  printf("%g %g %g %g\n", SHARE(0.5), SHARE(0.999), SHARE(0.99999), took[rounds - 1]);
  CALL(fmi2FreeInstance)(c);
  return 0;
}

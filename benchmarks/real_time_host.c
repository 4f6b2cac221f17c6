/* SPDX-License-Identifier: BSD-3-Clause
 * A control loop around an FMU: sets an input, makes a step of 1 ms, reads the outputs, and times each round by the
 * thread's clock, including its reading. Additional arguments: number of rounds; then, if a run is to end before,
 * the number of steps after which it is reset, the largest value of the input (0: none is set), and the reference of
 * solver.worst_step_evaluations. Prints the median, the 99.9 % and 99.999 % quantiles and the maximum in microseconds
 * and, with those arguments, the most evaluations in a step. */
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

static int start(fmi2Component c, int sets_input) {
  if (sets_input) return initialize(c, 0) != fmi2OK;
  int bad = CALL(fmi2SetupExperiment)(c, fmi2False, 0, 0, fmi2False, 0);
  bad |= CALL(fmi2EnterInitializationMode)(c);
  return bad | CALL(fmi2ExitInitializationMode)(c);
}

int main(int argc, char** argv) {
  double values[512];
  take_arguments(argc, argv);
  if (argc != 8 && argc != 11) return 2;
  const long rounds = atol(argv[7]);
  const int repeats = argc == 11;
  const long period = repeats ? atol(argv[8]) : rounds;
  const double largest = repeats ? atof(argv[9]) : 2;
  double worst = 0;
  double* took = malloc((size_t)rounds * sizeof *took);
  fmi2Component c = instantiate();
  if (took == NULL || c == NULL || start(c, largest != 0)) return 4;
  fmi2SetRealTYPE* set_real = CALL(fmi2SetReal);
  fmi2GetRealTYPE* get_real = CALL(fmi2GetReal);
  fmi2DoStepTYPE* do_step = CALL(fmi2DoStep);
  for (long k = 0; k < rounds; ++k) {
    if (k > 0 && k % period == 0) {
      if (CALL(fmi2Reset)(c) != fmi2OK || start(c, largest != 0)) return 4;
    }
    const double torque = (double)(k * 7919 % 200 - 100) / 100 * largest; /* a new value in every step */
    const double begin = now();
    int bad = largest != 0 ? set_real(c, &input, 1, &torque) : 0;
    bad |= do_step(c, 1e-3 * (double)(k % period), 1e-3, fmi2True);
    bad |= get_real(c, outputs, n_outputs, values);
    took[k] = now() - begin;
    if (bad) {
      printf("%g\n", 1e-3 * (double)(k % period)); /* the time of the step that is refused */
      return 5;
    }
    if (repeats && (k % period == period - 1 || k == rounds - 1)) {
      const fmi2ValueReference counted = (fmi2ValueReference)atoi(argv[10]);
      double evaluations = 0;
      get_real(c, &counted, 1, &evaluations);
      if (evaluations > worst) worst = evaluations;
    }
  }
  qsort(took, (size_t)rounds, sizeof *took, ascending);
#define SHARE(x) took[(long)((double)(rounds - 1) * (x))]
  printf("%g %g %g %g", SHARE(0.5), SHARE(0.999), SHARE(0.99999), took[rounds - 1]);
  repeats ? printf(" %g\n", worst) : printf("\n");
  CALL(fmi2FreeInstance)(c);
  return 0;
}

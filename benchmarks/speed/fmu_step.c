/* SPDX-License-Identifier: BSD-3-Clause
 * Communication steps through the C interface of an FMU: sets torques, makes a step of 1 ms, reads all outputs.
 * Additional arguments: TORQUES INPUTS ROUNDS; TORQUES is a file of numbers, a line for each step. Prints the time of a
 * step, its share of reading outputs, and the outputs at the end, as JSON. */
#define _GNU_SOURCE
#include "c_host.h"
#include "ref_kernel.h"

static double values[512];

static double* read_torques(const char* path, long count) {
  double* out = malloc((size_t)count * sizeof *out);
  FILE* file = fopen(path, "r");
  if (out == NULL || file == NULL) exit(2);
  for (long i = 0; i < count; ++i) {
    if (fscanf(file, "%lf", out + i) != 1) exit(2);
  }
  fclose(file);
  return out;
}

/* Mean time [us] of a step, over `rounds` steps of a new instance. */
static double run(const double* torques, size_t inputs, long rounds) {
  fmi2ValueReference driven[16];
  for (size_t i = 0; i < inputs; ++i) driven[i] = input + (fmi2ValueReference)i;
  fmi2SetRealTYPE* set_real = CALL(fmi2SetReal);
  fmi2GetRealTYPE* get_real = CALL(fmi2GetReal);
  fmi2DoStepTYPE* do_step = CALL(fmi2DoStep);
  fmi2Component c = instantiate();
  if (c == NULL || initialize(c, torques[0]) != fmi2OK) exit(4);
  int bad = 0;
  const double begin = cpu_seconds();
  for (long k = 0; k < rounds; ++k) {
    bad |= set_real(c, driven, inputs, torques + (size_t)k * inputs);
    bad |= do_step(c, 1e-3 * (double)k, 1e-3, fmi2True);
    bad |= get_real(c, outputs, n_outputs, values);
  }
  const double spent = cpu_seconds() - begin;
  CALL(fmi2FreeInstance)(c);
  if (bad) exit(5);
  return 1e6 * spent / (double)rounds;
}

int main(int argc, char** argv) {
  take_arguments(argc, argv);
  if (argc != 10) return 2;
  const size_t driven = (size_t)atoi(argv[8]);
  const long rounds = atol(argv[9]);
  if (driven > 16) return 2;
  double* torques = read_torques(argv[7], rounds * (long)driven);
  double least = 1e30;
  for (int turn = 0; turn < 9; ++turn) {
    const double found = run(torques, driven, rounds);
    if (found < least) least = found;
  }
  printf("{\"us\": %.6g, \"ref_us\": %.6g, \"end\": [", least, 1e6 * ref_kernel(1000));
  for (size_t i = 0; i < n_outputs; ++i) printf(i == 0 ? "%.17g" : ", %.17g", values[i]);
  printf("]}\n");
  free(torques);
  return 0;
}

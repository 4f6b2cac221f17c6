/* SPDX-License-Identifier: BSD-3-Clause
 * A controller's loop whose costs are counted from outside (callgrind): sets another torque, makes a step, reads the
 * outputs. Own arguments: how many rounds, the step [s], and the references of what is told at the end, one a line. */
#include "c_host.h"

int main(int argc, char** argv) {
  double values[512];
  take_arguments(argc, argv);
  if (argc < 9) return 2;
  const long rounds = atol(argv[7]);
  const double step = atof(argv[8]);
  fmi2Component c = instantiate();
  if (c == NULL || initialize(c, 0) != fmi2OK) return 4;
  fmi2SetRealTYPE* set_real = CALL(fmi2SetReal);
  fmi2GetRealTYPE* get_real = CALL(fmi2GetReal);
  fmi2DoStepTYPE* do_step = CALL(fmi2DoStep);
  for (long k = 0; k < rounds; ++k) {
    const double torque = 0.1 + 1e-3 * (double)(k % 7);
    int bad = set_real(c, &input, 1, &torque);
    bad |= do_step(c, step * (double)k, step, fmi2True);
    bad |= get_real(c, outputs, n_outputs, values);
    if (bad) return 5;
  }
  for (int i = 9; i < argc; ++i) {
    const fmi2ValueReference reference = (fmi2ValueReference)atoi(argv[i]);
    double count = 0;
    if (get_real(c, &reference, 1, &count) != fmi2OK) return 6;
    printf("%.0f\n", count);
  }
  CALL(fmi2FreeInstance)(c);
  return 0;
}

/* SPDX-License-Identifier: BSD-3-Clause
 * A whole life of an FMU: life_host LIBRARY GUID RESOURCES INPUT FIRST_OUTPUT OUTPUTS TOLERANCE STEP STEPS MIDDLE
 *                                   (save | restore) STATE_FILE
 * Prints the outputs after each step, one line for each step; saves the serialized state after MIDDLE steps to the file,
 * or begins there with the state from it. INPUT -1: none; otherwise a torque or force changes every ten steps. */
#include "c_host.h"

static fmi2Component c;
static double step_size;

static _Noreturn void fail(const char* what, int which) {
  fprintf(stderr, "%s: %d\n", what, which);
  exit(4);
}

static double push(int k) { return 0.1 * (k / 10 % 3 - 1); }

static void set_input(int k) {
  const double value = push(k);
  if (input != (fmi2ValueReference)-1 && CALL(fmi2SetReal)(c, &input, 1, &value) != fmi2OK) fail("input", k);
}

static void start(double tolerance) {
  c = instantiate();
  if (c == NULL || CALL(fmi2SetupExperiment)(c, fmi2True, tolerance, 0, fmi2False, 0) != fmi2OK ||
      CALL(fmi2EnterInitializationMode)(c) != fmi2OK) {
    fail("not initialized", 0);
  }
  set_input(0);
  if (CALL(fmi2ExitInitializationMode)(c) != fmi2OK) fail("not initialized", 1);
}

static void step(int k) {
  double values[sizeof outputs / sizeof outputs[0]];
  set_input(k);
  if (CALL(fmi2DoStep)(c, k * step_size, step_size, fmi2True) != fmi2OK) fail("step", k);
  if (CALL(fmi2GetReal)(c, outputs, n_outputs, values) != fmi2OK) fail("outputs", k);
  for (size_t i = 0; i < n_outputs; ++i) printf("%.17g%c", values[i], i + 1 < n_outputs ? ' ' : '\n');
}

static void save(const char* path) {
  fmi2FMUstate state = NULL;
  size_t size = 0;
  if (CALL(fmi2GetFMUstate)(c, &state) != fmi2OK) fail("state", 0);
  if (CALL(fmi2SerializedFMUstateSize)(c, state, &size) != fmi2OK) fail("size", 0);
  char* bytes = malloc(size);
  if (bytes == NULL || CALL(fmi2SerializeFMUstate)(c, state, bytes, size) != fmi2OK) fail("bytes", 0);
  FILE* file = fopen(path, "wb");
  if (file == NULL || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) fail("file", 0);
  free(bytes);
  if (CALL(fmi2FreeFMUstate)(c, &state) != fmi2OK) fail("free", 0);
}

static void restore(const char* path) {
  static char bytes[1 << 22];
  fmi2FMUstate state = NULL;
  FILE* file = fopen(path, "rb");
  if (file == NULL) fail("file", 1);
  const size_t size = fread(bytes, 1, sizeof bytes, file);
  fclose(file);
  if (CALL(fmi2DeSerializeFMUstate)(c, bytes, size, &state) != fmi2OK) fail("bytes", 1);
  if (CALL(fmi2SetFMUstate)(c, state) != fmi2OK) fail("state", 1);
}

int main(int argc, char** argv) {
  take_arguments(argc, argv);
  if (argc != 13) return 2;
  step_size = atof(argv[8]);
  const int steps = atoi(argv[9]), middle = atoi(argv[10]);
  const int restoring = strcmp(argv[11], "restore") == 0;
  start(atof(argv[7]));
  if (restoring) restore(argv[12]);
  for (int k = restoring ? middle : 0; k < steps; ++k) {
    if (!restoring && k == middle) save(argv[12]);
    step(k);
  }
  if (CALL(fmi2Terminate)(c) != fmi2OK) fail("the end", 0);
  CALL(fmi2FreeInstance)(c);
  return 0;
}

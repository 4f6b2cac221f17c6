/* SPDX-License-Identifier: BSD-3-Clause
 * A host that loads and unloads the library, like a master that opens an FMU for each run, and then ends. Own argument:
 * number of cycles. Prints what it did, when it ends without a crash also what ran at its end. */
#include "c_host.h"

#ifdef _WIN32
static int close_library(void) { return FreeLibrary(library) != 0; }
static int loaded(const char* path) { return GetModuleHandleA(path) != NULL; }
#else
static int close_library(void) { return dlclose(library) == 0; }
static int loaded(const char* path) { return dlopen(path, RTLD_NOW | RTLD_NOLOAD) != NULL; }
#endif

static void at_the_end(void) { puts("end"); }

static int live(void) {
  double values[sizeof outputs / sizeof outputs[0]];
  fmi2Component c = instantiate();
  if (c == NULL || initialize(c, 0.1)) return 0;
  if (CALL(fmi2DoStep)(c, 0, 0.01, fmi2True) != fmi2OK) return 0;
  if (CALL(fmi2DoStep)(c, -1, 0.01, fmi2True) == fmi2OK) return 0; /* rejected, by an exception inside */
  const int read = CALL(fmi2GetReal)(c, outputs, n_outputs, values) == fmi2OK;
  CALL(fmi2FreeInstance)(c);
  return read;
}

int main(int argc, char** argv) {
  if (argc != 8) return 2;
  atexit(at_the_end); /* runs after what the library has left to be run */
  take_arguments(argc, argv);
  const int cycles = atoi(argv[7]);
  for (int k = 0; k < cycles; ++k) {
    if (k > 0 && open_library(argv[1]) == NULL) return 3;
    if (!live()) return 4;
    if (!close_library()) return 5;
    if (loaded(argv[1])) return 6; /* the test would be void */
  }
  printf("%d cycles\n", cycles);
  return 0;
}

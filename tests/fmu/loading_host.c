/* SPDX-License-Identifier: BSD-3-Clause
 * A host that repeatedly loads and unloads the library, like a master that opens an FMU for each run. Own arguments:
 * number of cycles; 1 to create and run an instance in each cycle. Prints resident memory [kB] and heap [bytes] after 20
 * cycles and at the end. */
#define _GNU_SOURCE
#include <malloc.h>
#include <unistd.h>

#include "c_host.h"

typedef struct {
  long resident; /* kB */
  size_t heap;   /* bytes */
} Memory;

static Memory memory_in_use(void) {
  const struct mallinfo2 m = mallinfo2();
  Memory t = {0, m.uordblks + m.hblkhd};
  long all;
  FILE* f = fopen("/proc/self/statm", "r");
  if (f == NULL || fscanf(f, "%ld %ld", &all, &t.resident) != 2) exit(9);
  fclose(f);
  t.resident *= sysconf(_SC_PAGESIZE) / 1024;
  return t;
}

static void run_instance(void) {
  double values[512];
  fmi2Component c = instantiate();
  if (c == NULL) exit(4);
  int bad = initialize(c, 1.5);
  for (int k = 0; k < 3; ++k) bad |= CALL(fmi2DoStep)(c, 0.01 * k, 0.01, fmi2True);
  bad |= CALL(fmi2DoStep)(c, -1, 0.01, fmi2True) == fmi2OK; /* rejected, by an exception inside */
  bad |= CALL(fmi2GetReal)(c, outputs, n_outputs, values);
  CALL(fmi2FreeInstance)(c);
  if (bad) exit(5);
}

int main(int argc, char** argv) {
  Memory first = {0, 0};
  take_arguments(argc, argv);
  dlclose(library);
  if (argc != 9) return 2;
  const int cycles = atoi(argv[7]), instances = atoi(argv[8]);
  for (int k = 0; k < cycles; ++k) {
    if (open_library(argv[1]) == NULL) return 3;
    if (instances) run_instance();
    dlclose(library);
    if (dlopen(argv[1], RTLD_NOW | RTLD_NOLOAD) != NULL) return 6; /* not unloaded: the test would be void */
    if (k == 19) first = memory_in_use();
  }
  const Memory last = memory_in_use();
  printf("%ld %ld %zu %zu\n", first.resident, last.resident, first.heap, last.heap);
  return 0;
}

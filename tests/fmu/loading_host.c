/* SPDX-License-Identifier: BSD-3-Clause
 * A host that loads and unloads the library again and again, as a master does that opens an FMU for each of its runs.
 * Own arguments: how many times; 1 to live an instance's life each time. Prints kB resident and bytes of heap after 20
 * times and at the end. */
#define _GNU_SOURCE
#include <malloc.h>
#include <unistd.h>

#include "c_host.h"

typedef struct {
  long resident; /* kB */
  size_t heap;   /* bytes */
} Taken;

static Taken taken(void) {
  const struct mallinfo2 m = mallinfo2();
  Taken t = {0, m.uordblks + m.hblkhd};
  long all;
  FILE* f = fopen("/proc/self/statm", "r");
  if (f == NULL || fscanf(f, "%ld %ld", &all, &t.resident) != 2) exit(9);
  fclose(f);
  t.resident *= sysconf(_SC_PAGESIZE) / 1024;
  return t;
}

static void live(void) {
  double values[512];
  fmi2Component c = instantiate();
  if (c == NULL) exit(4);
  int bad = initialize(c, 1.5);
  for (int k = 0; k < 3; ++k) bad |= CALL(fmi2DoStep)(c, 0.01 * k, 0.01, fmi2True);
  bad |= CALL(fmi2DoStep)(c, -1, 0.01, fmi2True) == fmi2OK; /* refused: an exception inside */
  bad |= CALL(fmi2GetReal)(c, outputs, n_outputs, values);
  CALL(fmi2FreeInstance)(c);
  if (bad) exit(5);
}

int main(int argc, char** argv) {
  Taken first = {0, 0};
  take_arguments(argc, argv);
  dlclose(library);
  if (argc != 9) return 2;
  const int cycles = atoi(argv[7]), lives = atoi(argv[8]);
  for (int k = 0; k < cycles; ++k) {
    if (open_library(argv[1]) == NULL) return 3;
    if (lives) live();
    dlclose(library);
    if (dlopen(argv[1], RTLD_NOW | RTLD_NOLOAD) != NULL) return 6; /* still there: nothing would be tested */
    if (k == 19) first = taken();
  }
  const Taken last = taken();
  printf("%ld %ld %zu %zu\n", first.resident, last.resident, first.heap, last.heap);
  return 0;
}

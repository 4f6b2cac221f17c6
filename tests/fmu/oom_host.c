/* SPDX-License-Identifier: BSD-3-Clause
 * A host in which memory runs out: oom_host LIBRARY GUID RESOURCES INPUT FIRST_OUTPUT OUTPUTS
 * repeats the complete life cycle of an FMU. In cycle n, n allocations succeed before one fails or, in a second series, all
 * others fail. All calls must return, and after a reset the instance must give bitwise the same run as without failures.
 * Returns 0 and prints a line of counts. */
#define _GNU_SOURCE
#include "c_host.h"

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static long left = -1; /* allocations until one fails; -1: none does */
static int permanently; /* whether all later ones fail, too */
static long denied;

static int deny(void) {
  if (left < 0) return 0;
  if (left > 0) {
    --left;
    return 0;
  }
  if (!permanently) left = -1;
  ++denied;
  return 1;
}

void* malloc(size_t n) { return deny() ? NULL : __libc_malloc(n); }
void* calloc(size_t n, size_t m) { return deny() ? NULL : __libc_calloc(n, m); }
void* realloc(void* p, size_t n) { return deny() ? NULL : __libc_realloc(p, n); }
void* memalign(size_t a, size_t n) { return deny() ? NULL : __libc_memalign(a, n); }
void* aligned_alloc(size_t a, size_t n) { return memalign(a, n); }
int posix_memalign(void** p, size_t a, size_t n) {
  *p = memalign(a, n);
  return *p == NULL ? 12 /* ENOMEM */ : 0;
}

/* The calls of a run; returns the combined status. Continues after failures, as a host might. */
static int run(fmi2Component c, double* values) {
  int bad = initialize(c, 1.5);
  for (int k = 0; k < 5; ++k) bad |= CALL(fmi2DoStep)(c, 0.01 * k, 0.01, fmi2True);
  bad |= CALL(fmi2GetReal)(c, outputs, n_outputs, values);
  return bad;
}

int main(int argc, char** argv) {
  double expected[512], values[512];
  long cycles = 0, none = 0, failed = 0;
  take_arguments(argc, argv);
  fmi2Component c = instantiate();
  if (c == NULL || run(c, expected) != fmi2OK) return 4;
  CALL(fmi2FreeInstance)(c);

  for (permanently = 0; permanently < 2; ++permanently) {
    for (long n = 0;; n += 1 + n / 200) { /* each n at first, then with increasing gaps */
      denied = 0;
      left = n;
      c = instantiate();
      const int bad = c != NULL ? run(c, values) : fmi2OK;
      const int complete = denied == 0;
      left = -1;
      ++cycles;
      none += c == NULL;
      failed += bad != 0;
      if (c != NULL) {
        if (CALL(fmi2Reset)(c) != fmi2OK || run(c, values) != fmi2OK) {
          fprintf(stderr, "unusable after allocation %ld failed\n", n);
          return 5;
        }
        if (memcmp(values, expected, n_outputs * sizeof(double)) != 0) {
          fprintf(stderr, "different run after allocation %ld failed\n", n);
          return 6;
        }
        CALL(fmi2FreeInstance)(c);
      }
      if (complete) break;
    }
  }
  printf("%ld cycles, %ld not instantiated, %ld with failed calls, %ld messages\n", cycles, none, failed, messages);
  return 0;
}

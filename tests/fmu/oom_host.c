/* SPDX-License-Identifier: BSD-3-Clause
 * A host in which memory runs out: host LIBRARY GUID RESOURCES INPUT FIRST_OUTPUT OUTPUTS
 * lives an FMU's whole life again and again, and each time one allocation more succeeds before one fails (or, the other
 * way, before all fail). Whatever happens the calls must come back, and after a reset the instance must give the run of
 * a host with memory, to the bit. Ends with 0 and a line of counts. */
#define _GNU_SOURCE
#include "c_host.h"

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static long left = -1; /* allocations until one fails; -1: none does */
static int for_ever;   /* and all after it */
static long denied;

static int deny(void) {
  if (left < 0) return 0;
  if (left > 0) {
    --left;
    return 0;
  }
  if (!for_ever) left = -1;
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

/* The calls of a run; what each gave. Goes on after failures, as a host might. */
static int run(fmi2Component c, double* values) {
  int bad = initialize(c, 1.5);
  for (int k = 0; k < 5; ++k) bad |= CALL(fmi2DoStep)(c, 0.01 * k, 0.01, fmi2True);
  bad |= CALL(fmi2GetReal)(c, outputs, n_outputs, values);
  return bad;
}

int main(int argc, char** argv) {
  double expected[512], values[512];
  long lives = 0, none = 0, failed = 0;
  take_arguments(argc, argv);
  fmi2Component c = instantiate();
  if (c == NULL || run(c, expected) != fmi2OK) return 4;
  CALL(fmi2FreeInstance)(c);

  for (for_ever = 0; for_ever < 2; ++for_ever) {
    for (long n = 0;; n += 1 + n / 200) { /* every one at first, then fewer and fewer */
      denied = 0;
      left = n;
      c = instantiate();
      const int bad = c != NULL ? run(c, values) : fmi2OK;
      const int whole = denied == 0;
      left = -1;
      ++lives;
      none += c == NULL;
      failed += bad != 0;
      if (c != NULL) {
        if (CALL(fmi2Reset)(c) != fmi2OK || run(c, values) != fmi2OK) {
          fprintf(stderr, "not usable after allocation %ld failed\n", n);
          return 5;
        }
        if (memcmp(values, expected, n_outputs * sizeof(double)) != 0) {
          fprintf(stderr, "another run after allocation %ld failed\n", n);
          return 6;
        }
        CALL(fmi2FreeInstance)(c);
      }
      if (whole) break;
    }
  }
  printf("%ld lives, %ld not born, %ld with refused calls, %ld sentences\n", lives, none, failed, sentences);
  return 0;
}

/* SPDX-License-Identifier: BSD-3-Clause
 * A host that counts the heap calls of a running plant. Own arguments: the value reference of a tunable parameter and,
 * optionally, a number of steps before calls count. Prints the number of calls of malloc etc. in: set, step, get, tune. */
#define _GNU_SOURCE
#include "c_host.h"

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);
extern void __libc_free(void*);

static long calls;

void* malloc(size_t n) { return ++calls, __libc_malloc(n); }
void* calloc(size_t n, size_t m) { return ++calls, __libc_calloc(n, m); }
void* realloc(void* p, size_t n) { return ++calls, __libc_realloc(p, n); }
void* memalign(size_t a, size_t n) { return ++calls, __libc_memalign(a, n); }
void* aligned_alloc(size_t a, size_t n) { return memalign(a, n); }
int posix_memalign(void** p, size_t a, size_t n) {
  *p = memalign(a, n);
  return *p == NULL ? 12 /* ENOMEM */ : 0;
}
void free(void* p) {
  if (p != NULL) ++calls;
  __libc_free(p);
}

int main(int argc, char** argv) {
  enum { set, step, get, tune, kinds };
  long count[kinds] = {0};
  double values[2048];
  int bad = 0;
  take_arguments(argc, argv);
  if (argc < 8 || argc > 9) return 2;
  const int first = argc == 9 ? atoi(argv[8]) : 0;
  const fmi2ValueReference tunable = (fmi2ValueReference)atoi(argv[7]);
  fmi2Component c = instantiate();
  if (c == NULL) return 4;
  bad |= initialize(c, 0.5);
  fmi2SetRealTYPE* set_real = CALL(fmi2SetReal);
  fmi2GetRealTYPE* get_real = CALL(fmi2GetReal);
  fmi2DoStepTYPE* do_step = CALL(fmi2DoStep);
  for (int k = 0; k < 400 && !bad; ++k) {
    const double torque = k % 7 < 4 ? 1.5 : -2.5;
    const double damping = k % 50 < 25 ? 0.1 : 0.2;
    long before = calls;
#define COUNTED(kind, call) (before = calls, bad |= (call), count[kind] += k < first ? 0 : calls - before)
    COUNTED(set, set_real(c, &input, 1, &torque));
    COUNTED(tune, set_real(c, &tunable, 1, &damping));
    COUNTED(step, do_step(c, 0.005 * k, 0.005, fmi2True));
    COUNTED(get, get_real(c, outputs, n_outputs, values));
  }
  CALL(fmi2FreeInstance)(c);
  printf("%ld %ld %ld %ld\n", count[set], count[step], count[get], count[tune]);
  return bad;
}

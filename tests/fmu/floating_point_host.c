/* SPDX-License-Identifier: BSD-3-Clause
 * A host that runs an instance in each of several floating-point modes and checks after each call that the mode and the
 * flags are unchanged. All runs must have identical outputs. Own argument: number of steps. Prints the number of modes,
 * and the number of outputs that were subnormal. */
#include <math.h>

#include "c_host.h"

#if defined(__x86_64__)
#include <xmmintrin.h>

typedef struct {
  unsigned sse;
  unsigned short x87;
} Mode;

/* Bits of the SSE mode: flags 0-5, subnormal operands to zero 6, masked traps 7-12, rounding 13-14, subnormal results to
 * zero 15. */
static const Mode modes[] = {
    {0x1f80, 0x037f},
    {0x1fbf, 0x037f} /* all flags */,
    {0x9fc0, 0x037f} /* subnormals to zero */,
    {0x3f80, 0x077f} /* round down */,
    {0x5f80, 0x0b7f} /* round up */,
    {0x7f80, 0x0f7f} /* round to zero */,
    {0x1900, 0x0370} /* traps */,
    {0x1f80, 0x007f} /* single precision */,
    {0x1f80, 0x027f} /* double precision */,
};

static Mode present_mode(void) {
  Mode mode = {_mm_getcsr(), 0};
  __asm__ volatile("fnstcw %0" : "=m"(mode.x87));
  return mode;
}

static void set_mode(const Mode* mode) {
  __asm__ volatile("fnclex\n\tfldcw %0" : : "m"(mode->x87));
  _mm_setcsr(mode->sse);
}

static long subnormals;
static Mode before; /* immediately before a call, since the host's own arithmetic raises flags */

static void check_mode(const char* call) {
  const Mode now = present_mode();
  if (now.sse != before.sse || now.x87 != before.x87) {
    set_mode(&modes[0]);
    fprintf(stderr, "%s: found mode %x %x, expected %x %x\n", call, now.sse, now.x87, before.sse, before.x87);
    exit(4);
  }
}

#define TRY(name, ...)                            \
  do {                                            \
    name##TYPE* const call = CALL(name);          \
    before = present_mode();                           \
    const fmi2Status status = call(__VA_ARGS__);  \
    check_mode(#name);                                  \
    if (status != fmi2OK) {                       \
      set_mode(&modes[0]);                            \
      fprintf(stderr, "%s: %d\n", #name, status); \
      exit(5);                                    \
    }                                             \
  } while (0)

/* A checksum of all outputs. */
static uint64_t run(long steps) {
  double values[sizeof outputs / sizeof outputs[0]], seed = 1;
  uint64_t sum = 14695981039346656037U; /* FNV-1a of the words */
  fmi2FMUstate state = NULL;
  before = present_mode();
  fmi2Component c = instantiate();
  check_mode("fmi2Instantiate");
  if (c == NULL) exit(6);
  before = present_mode();
  const int bad = initialize(c, 0);
  check_mode("initialization");
  if (bad) exit(5);
  for (long k = 0; k < steps; ++k) {
    volatile double t = 1e-3 * (double)k; /* computed before the mode is recorded */
    TRY(fmi2DoStep, c, t, 1e-3, fmi2True);
    TRY(fmi2GetReal, c, outputs, n_outputs, values);
    for (size_t i = 0; i < n_outputs; ++i) {
      uint64_t word;
      memcpy(&word, &values[i], sizeof word);
      sum = (sum ^ word) * 1099511628211U;
      if (fpclassify(values[i]) == FP_SUBNORMAL) ++subnormals;
    }
  }
  TRY(fmi2GetFMUstate, c, &state);
  TRY(fmi2SetFMUstate, c, state);
  TRY(fmi2FreeFMUstate, c, &state);
  TRY(fmi2GetDirectionalDerivative, c, outputs + n_outputs - 1, 1, &input, 1, &seed, values);
  TRY(fmi2Terminate, c);
  before = present_mode();
  CALL(fmi2FreeInstance)(c);
  check_mode("fmi2FreeInstance");
  return sum;
}

int main(int argc, char** argv) {
  const size_t count = sizeof modes / sizeof modes[0];
  uint64_t sums[sizeof modes / sizeof modes[0]];
  take_arguments(argc, argv);
  if (argc != 8) return 2;
  for (size_t i = 0; i < count; ++i) {
    set_mode(&modes[i]);
    sums[i] = run(atol(argv[7]));
    set_mode(&modes[0]);
    if (sums[i] != sums[0]) {
      fprintf(stderr, "mode %x %x: different outputs\n", modes[i].sse, modes[i].x87);
      return 7;
    }
  }
  printf("%zu %ld\n", count, subnormals);
  return 0;
}
#else
int main(void) { return 77; }
#endif

/* SPDX-License-Identifier: BSD-3-Clause
 * A host in every floating-point mode: lives a life in each and looks after each call whether the mode is as it was,
 * flags included; the lives must put out the same bits. Own argument: how many steps. Prints how many modes, and how
 * many outputs were neither zero nor normal numbers. */
#include <math.h>

#include "c_host.h"

#if defined(__x86_64__)
#include <xmmintrin.h>

typedef struct {
  unsigned sse;
  unsigned short x87;
} Mode;

/* Of the SSE: flags 0-5, small operands to zero 6, traps masked 7-12, rounding 13-14, small results to zero 15. */
static const Mode modes[] = {
    {0x1f80, 0x037f},
    {0x1fbf, 0x037f} /* all flags */,
    {0x9fc0, 0x037f} /* small to zero */,
    {0x3f80, 0x077f} /* down */,
    {0x5f80, 0x0b7f} /* up */,
    {0x7f80, 0x0f7f} /* to zero */,
    {0x1900, 0x0370} /* traps */,
    {0x1f80, 0x007f} /* single */,
    {0x1f80, 0x027f} /* double */,
};

static Mode present(void) {
  Mode mode = {_mm_getcsr(), 0};
  __asm__ volatile("fnstcw %0" : "=m"(mode.x87));
  return mode;
}

static void take(const Mode* mode) {
  __asm__ volatile("fnclex\n\tfldcw %0" : : "m"(mode->x87));
  _mm_setcsr(mode->sse);
}

static long small_ones;
static Mode before; /* a call: the host's own arithmetic raises flags */

static void look(const char* call) {
  const Mode now = present();
  if (now.sse != before.sse || now.x87 != before.x87) {
    take(&modes[0]);
    fprintf(stderr, "%s: found mode %x %x, expected %x %x\n", call, now.sse, now.x87, before.sse, before.x87);
    exit(4);
  }
}

#define TRY(name, ...)                            \
  do {                                            \
    name##TYPE* const call = CALL(name);          \
    before = present();                           \
    const fmi2Status status = call(__VA_ARGS__);  \
    look(#name);                                  \
    if (status != fmi2OK) {                       \
      take(&modes[0]);                            \
      fprintf(stderr, "%s: %d\n", #name, status); \
      exit(5);                                    \
    }                                             \
  } while (0)

/* A checksum of all outputs. */
static uint64_t life(long steps) {
  double values[sizeof outputs / sizeof outputs[0]], seed = 1;
  uint64_t sum = 14695981039346656037U; /* FNV-1a of the words */
  fmi2FMUstate state = NULL;
  before = present();
  fmi2Component c = instantiate();
  look("fmi2Instantiate");
  if (c == NULL) exit(6);
  before = present();
  const int bad = initialize(c, 0);
  look("initialisation");
  if (bad) exit(5);
  for (long k = 0; k < steps; ++k) {
    volatile double t = 1e-3 * (double)k; /* here, not in the call */
    TRY(fmi2DoStep, c, t, 1e-3, fmi2True);
    TRY(fmi2GetReal, c, outputs, n_outputs, values);
    for (size_t i = 0; i < n_outputs; ++i) {
      uint64_t word;
      memcpy(&word, &values[i], sizeof word);
      sum = (sum ^ word) * 1099511628211U;
      if (fpclassify(values[i]) == FP_SUBNORMAL) ++small_ones;
    }
  }
  TRY(fmi2GetFMUstate, c, &state);
  TRY(fmi2SetFMUstate, c, state);
  TRY(fmi2FreeFMUstate, c, &state);
  TRY(fmi2GetDirectionalDerivative, c, outputs + n_outputs - 1, 1, &input, 1, &seed, values);
  TRY(fmi2Terminate, c);
  before = present();
  CALL(fmi2FreeInstance)(c);
  look("fmi2FreeInstance");
  return sum;
}

int main(int argc, char** argv) {
  const size_t count = sizeof modes / sizeof modes[0];
  uint64_t sums[sizeof modes / sizeof modes[0]];
  take_arguments(argc, argv);
  if (argc != 8) return 2;
  for (size_t i = 0; i < count; ++i) {
    take(&modes[i]);
    sums[i] = life(atol(argv[7]));
    take(&modes[0]);
    if (sums[i] != sums[0]) {
      fprintf(stderr, "mode %x %x: other outputs\n", modes[i].sse, modes[i].x87);
      return 7;
    }
  }
  printf("%zu %ld\n", count, small_ones);
  return 0;
}
#else
int main(void) { return 77; }
#endif

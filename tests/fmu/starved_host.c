/* SPDX-License-Identifier: BSD-3-Clause
 * A host in which memory runs out: host LIBRARY GUID RESOURCES INPUT FIRST_OUTPUT OUTPUTS
 * lives an FMU's whole life again and again, and each time one allocation more succeeds before one fails (or, the other
 * way, before all fail). Whatever happens the calls must come back, and after a reset the instance must give the run of
 * a host with memory, to the bit. Ends with 0 and a line of counts. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

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

static void* library;
static const char *guid, *resources;
static fmi2ValueReference input, outputs[512];
static size_t n_outputs;
static long sentences;

static void* function(const char* name) {
  void* found = dlsym(library, name);
  if (found == NULL) {
    fprintf(stderr, "no %s\n", name);
    exit(2);
  }
  return found;
}
#define CALL(type, name) ((type*)function(name))

static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text,
                   ...) {
  (void)e;
  if (strcmp(name, "plant") != 0 || status == fmi2OK || category[0] == 0 || text[0] == 0) {
    fprintf(stderr, "a bad sentence: %s\n", text);
    exit(3);
  }
  ++sentences;
}

static const fmi2CallbackFunctions callbacks = {logger, NULL, NULL, NULL, NULL};

/* The calls of a run; what each gave. Goes on after failures, as a host might. */
static int run(fmi2Component c, double* values) {
  int bad = 0;
  const double torque = 1.5;
  bad |= CALL(fmi2SetupExperimentTYPE, "fmi2SetupExperiment")(c, fmi2False, 0, 0, fmi2False, 0);
  bad |= CALL(fmi2EnterInitializationModeTYPE, "fmi2EnterInitializationMode")(c);
  bad |= CALL(fmi2SetRealTYPE, "fmi2SetReal")(c, &input, 1, &torque);
  bad |= CALL(fmi2ExitInitializationModeTYPE, "fmi2ExitInitializationMode")(c);
  for (int k = 0; k < 5; ++k) bad |= CALL(fmi2DoStepTYPE, "fmi2DoStep")(c, 0.01 * k, 0.01, fmi2True);
  bad |= CALL(fmi2GetRealTYPE, "fmi2GetReal")(c, outputs, n_outputs, values);
  return bad;
}

static fmi2Component instantiate(void) {
  return CALL(fmi2InstantiateTYPE, "fmi2Instantiate")("plant", fmi2CoSimulation, guid, resources, &callbacks, fmi2False,
                                                      fmi2False);
}

int main(int argc, char** argv) {
  double expected[512], values[512];
  long lives = 0, none = 0, failed = 0;
  if (argc != 7) return 2;
  guid = argv[2];
  resources = argv[3];
  input = (fmi2ValueReference)atoi(argv[4]);
  n_outputs = (size_t)atoi(argv[6]);
  for (size_t i = 0; i < n_outputs; ++i) outputs[i] = (fmi2ValueReference)(atoi(argv[5]) + (int)i);
  library = dlopen(argv[1], RTLD_NOW);
  if (library == NULL) {
    fprintf(stderr, "%s\n", dlerror());
    return 2;
  }
  fmi2Component c = instantiate();
  if (c == NULL || run(c, expected) != fmi2OK) return 4;
  CALL(fmi2FreeInstanceTYPE, "fmi2FreeInstance")(c);

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
        if (CALL(fmi2ResetTYPE, "fmi2Reset")(c) != fmi2OK || run(c, values) != fmi2OK) {
          fprintf(stderr, "not usable after allocation %ld failed\n", n);
          return 5;
        }
        if (memcmp(values, expected, n_outputs * sizeof(double)) != 0) {
          fprintf(stderr, "another run after allocation %ld failed\n", n);
          return 6;
        }
        CALL(fmi2FreeInstanceTYPE, "fmi2FreeInstance")(c);
      }
      if (whole) break;
    }
  }
  printf("%ld lives, %ld not born, %ld with refused calls, %ld sentences\n", lives, none, failed, sentences);
  return 0;
}

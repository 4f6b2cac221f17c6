/* SPDX-License-Identifier: BSD-3-Clause
 * A host with many instances: multithreaded_host LIBRARY GUID RESOURCES INPUT FIRST_OUTPUT OUTPUTS TASK=N...
 *   cycles=N   instantiates, initializes and frees N times; prints the memory of the process after N/10 and after N times
 *   timing=N   the same, printing the CPU time up to the end of initialization: minimum, median, maximum
 *   crowd=N    N instances, stepped in turns; each must give the same bits as when run alone
 *   threads=N  the same instances distributed to N concurrent threads
 *   states=N   N instances, each of which is restored twice to a saved state, the second time after serialization
 *   run=N      N steps of one instance; prints its outputs, one per line
 *   wrong=N    N instances with invalid calls; each call must return the expected status
 * Returns 0 and prints a line for each task. */
#define _GNU_SOURCE
#include <math.h>
#include <pthread.h>
#include <time.h>
#ifndef _WIN32
#include <malloc.h>
#include <unistd.h>
#endif

#include "c_host.h"

enum { STEPS = 20 };
static const double size = 1e-3; /* s */

static _Noreturn void fail(const char* what, long which) {
  fprintf(stderr, "%s: %ld\n", what, which);
  exit(4);
}

static fmi2Component initialized(double torque) {
  fmi2Component c = instantiate();
  if (c == NULL || initialize(c, torque) != fmi2OK) fail("not initialized", 0);
  return c;
}

/* An instance with its own torques, and a checksum of the bits of its outputs. */
typedef struct {
  fmi2Component c;
  uint64_t sum;
} Run;

static double torque_of(long which, int k) { return 0.01 * (double)(which + 1) * (k % 4 < 2 ? 1 : -0.5); }

static void begin(Run* run_data, long which) {
  run_data->c = initialized(torque_of(which, 0));
  run_data->sum = 14695981039346656037U; /* FNV-1a of the words */
}

static void step(Run* run_data, long which, int k) {
  double values[sizeof outputs / sizeof outputs[0]];
  const double torque = torque_of(which, k);
  if (CALL(fmi2SetReal)(run_data->c, &input, 1, &torque) != fmi2OK) fail("torque rejected", which);
  if (CALL(fmi2DoStep)(run_data->c, k * size, size, fmi2True) != fmi2OK) fail("step rejected", which);
  if (CALL(fmi2GetReal)(run_data->c, outputs, n_outputs, values) != fmi2OK) fail("no outputs", which);
  for (size_t i = 0; i < n_outputs; ++i) {
    uint64_t word;
    memcpy(&word, &values[i], sizeof word);
    run_data->sum = (run_data->sum ^ word) * 1099511628211U;
  }
}

static void end(Run* run_data) { CALL(fmi2FreeInstance)(run_data->c); }

static long crowd_size;
static uint64_t* alone; /* the checksums of the instances, each run alone */

static void live_alone(void) {
  alone = calloc((size_t)crowd_size, sizeof *alone);
  for (long i = 0; i < crowd_size; ++i) {
    Run run_data;
    begin(&run_data, i);
    for (int k = 0; k < STEPS; ++k) step(&run_data, i, k);
    end(&run_data);
    alone[i] = run_data.sum;
    for (long j = 0; j < i; ++j) {
      if (alone[j] == alone[i]) fail("same outputs for different torques", i);
    }
  }
}

/* Runs the instances first, first + stride, ..., a step of each in turn. */
static void live_in_turns(long first, long stride) {
  Run* runs = calloc((size_t)crowd_size, sizeof *runs);
  for (long i = first; i < crowd_size; i += stride) begin(&runs[i], i);
  for (int k = 0; k < STEPS; ++k) {
    for (long i = first; i < crowd_size; i += stride) step(&runs[i], i, k);
  }
  for (long i = first; i < crowd_size; i += stride) {
    if (runs[i].sum != alone[i]) fail("outputs differ from those alone", i);
    end(&runs[i]);
  }
  free(runs);
}

static void crowd(long n) {
  crowd_size = n;
  live_alone();
  live_in_turns(0, 1);
  printf("crowd %ld\n", n);
}

static pthread_barrier_t gate;
static long n_threads;

static void* thread(void* first) {
  pthread_barrier_wait(&gate);
  live_in_turns((long)(intptr_t)first, n_threads);
  return NULL;
}

static void threads(long n) {
  pthread_t all[64];
  if (n > 64 || alone == NULL) exit(2);
  n_threads = n;
  pthread_barrier_init(&gate, NULL, (unsigned)n);
  for (long i = 0; i < n; ++i) {
    if (pthread_create(&all[i], NULL, thread, (void*)(intptr_t)i) != 0) fail("no thread", i);
  }
  for (long i = 0; i < n; ++i) pthread_join(all[i], NULL);
  pthread_barrier_destroy(&gate);
  printf("threads %ld\n", n);
}

#ifdef _WIN32
static void cycles(long n) {
  (void)n;
  fail("cycles: memory can be measured with glibc only", 0);
}
#else
static long resident_kB(void) {
  long all = 0, resident = 0;
  FILE* file = fopen("/proc/self/statm", "r");
  if (file == NULL || fscanf(file, "%ld %ld", &all, &resident) != 2) fail("no /proc/self/statm", 0);
  fclose(file);
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

static size_t heap_bytes(void) {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

static void cycles(long n) {
  long resident = resident_kB(); /* a first call, since reading touches pages, too */
  size_t heap = heap_bytes();
  for (long i = 0; i < n; ++i) {
    if (i == n / 10) {
      resident = resident_kB();
      heap = heap_bytes();
    }
    CALL(fmi2FreeInstance)(initialized(0.5));
  }
  printf("cycles %ld, kB resident %ld %ld, bytes of heap %zu %zu\n", n, resident, resident_kB(), heap, heap_bytes());
}
#endif

/* Makes the steps from `first` on; returns the checksum of their outputs. */
static uint64_t remaining_steps(Run* run_data, long which, int first) {
  run_data->sum = 0;
  for (int k = first; k < STEPS; ++k) step(run_data, which, k);
  return run_data->sum;
}

static void states(long n) {
  enum { MIDDLE = STEPS / 2 };
  for (long i = 0; i < n; ++i) {
    fmi2FMUstate state = NULL, other = NULL;
    size_t length = 0;
    Run run_data;
    begin(&run_data, i);
    for (int k = 0; k < MIDDLE; ++k) step(&run_data, i, k);
    if (CALL(fmi2GetFMUstate)(run_data.c, &state) != fmi2OK) fail("no state", i);
    const uint64_t expected = remaining_steps(&run_data, i, MIDDLE);
    if (CALL(fmi2SetFMUstate)(run_data.c, state) != fmi2OK) fail("state not restored", i);
    if (remaining_steps(&run_data, i, MIDDLE) != expected) fail("different run from a state", i);
    if (CALL(fmi2SerializedFMUstateSize)(run_data.c, state, &length) != fmi2OK) fail("no size", i);
    char* bytes = malloc(length);
    if (CALL(fmi2SerializeFMUstate)(run_data.c, state, bytes, length) != fmi2OK) fail("no bytes", i);
    if (CALL(fmi2DeSerializeFMUstate)(run_data.c, bytes, length, &other) != fmi2OK) fail("bytes rejected", i);
    free(bytes);
    if (CALL(fmi2SetFMUstate)(run_data.c, other) != fmi2OK) fail("deserialized state not restored", i);
    if (remaining_steps(&run_data, i, MIDDLE) != expected) fail("different run from a deserialized state", i);
    if (CALL(fmi2FreeFMUstate)(run_data.c, &state) != fmi2OK || state != NULL) fail("state not freed", i);
    end(&run_data); /* also frees the other state */
  }
  printf("states %ld\n", n);
}

static void run(long n) {
  double values[sizeof outputs / sizeof outputs[0]];
  Run run_data;
  begin(&run_data, 0);
  for (long k = 0; k < n; ++k) step(&run_data, 0, (int)k);
  if (CALL(fmi2GetReal)(run_data.c, outputs, n_outputs, values) != fmi2OK) fail("no outputs", 0);
  for (size_t i = 0; i < n_outputs; ++i) printf("%.17g\n", values[i]);
  end(&run_data);
}

static int ascending(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static double processor_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void timing(long n) {
  double* times = calloc((size_t)n, sizeof *times);
  for (long i = 0; i < n; ++i) {
    const double start = processor_seconds();
    fmi2Component c = initialized(0.5);
    times[i] = processor_seconds() - start;
    CALL(fmi2FreeInstance)(c);
  }
  qsort(times, (size_t)n, sizeof *times, ascending);
  printf("timing %ld, ms min %.3f median %.3f max %.3f\n", n, 1e3 * times[0], 1e3 * times[n / 2],
         1e3 * times[n - 1]);
  free(times);
}

static void expect(int status, int wanted, const char* what) {
  if (status != wanted) fail(what, status);
}

static void wrong_calls(void) {
  const fmi2ValueReference nobody = 4000000000U;
  const double nan_torque = NAN, big_torque = 1e300, torque = 0.5;
  double value = 0;
  if (CALL(fmi2Instantiate)("plant", fmi2CoSimulation, "wrong", resources, &callbacks, fmi2False, fmi2False) != NULL ||
      CALL(fmi2Instantiate)("plant", fmi2CoSimulation, guid, NULL, &callbacks, fmi2False, fmi2False) != NULL ||
      CALL(fmi2Instantiate)("plant", fmi2CoSimulation, guid, "file:///nowhere", &callbacks, fmi2False, fmi2False))
    fail("instantiated", 0);
  CALL(fmi2FreeInstance)(NULL);
  expect(CALL(fmi2DoStep)(NULL, 0, size, fmi2True), fmi2Error, "step of a null component");
  fmi2Component c = instantiate();
  if (c == NULL) fail("not instantiated", 0);
  expect(CALL(fmi2DoStep)(c, 0, size, fmi2True), fmi2Error, "step before initialization");
  expect(CALL(fmi2ExitInitializationMode)(c), fmi2Error, "end of initialization before its start");
  expect(CALL(fmi2GetReal)(c, NULL, 3, &value), fmi2Error, "no references");
  expect(initialize(c, 0.5), fmi2OK, "initialization");
  expect(CALL(fmi2SetReal)(c, &input, 1, &nan_torque), fmi2Error, "NaN");
  expect(CALL(fmi2SetReal)(c, &nobody, 1, &torque), fmi2Error, "unknown reference");
  expect(CALL(fmi2GetReal)(c, &nobody, 1, &value), fmi2Error, "unknown reference");
  expect(CALL(fmi2SetReal)(c, outputs, 1, &torque), fmi2Error, "an output set");
  expect(CALL(fmi2GetReal)(c, outputs, n_outputs, NULL), fmi2Error, "no values");
  expect(CALL(fmi2DoStep)(c, 0, -size, fmi2True), fmi2Error, "negative step");
  expect(CALL(fmi2DoStep)(c, 0, NAN, fmi2True), fmi2Error, "NaN as step");
  expect(CALL(fmi2DoStep)(c, 1, size, fmi2True), fmi2Error, "gap in time");
  expect(CALL(fmi2SetReal)(c, &input, 1, &big_torque), fmi2OK, "a finite torque");
  expect(CALL(fmi2DoStep)(c, 0, size, fmi2True), fmi2Discard, "impossible step");
  expect(CALL(fmi2SetReal)(c, &input, 1, &torque), fmi2OK, "torque");
  expect(CALL(fmi2DoStep)(c, 0, size, fmi2True), fmi2OK, "the next step");
  expect(CALL(fmi2DoStep)(c, 0, size, fmi2True), fmi2Error, "step back in time");
  expect(CALL(fmi2Terminate)(c), fmi2OK, "end");
  expect(CALL(fmi2Terminate)(c), fmi2Error, "second end");
  expect(CALL(fmi2Reset)(c), fmi2OK, "reset");
  expect(initialize(c, 0.5), fmi2OK, "initialization after a reset");
  CALL(fmi2FreeInstance)(c);
}

static void wrong(long n) {
  for (long i = 0; i < n; ++i) wrong_calls();
  printf("wrong %ld, %ld messages\n", n, (long)messages);
}

int main(int argc, char** argv) {
  static const struct {
    const char* name;
    void (*run)(long);
  } tasks[] = {{"cycles=", cycles}, {"timing=", timing}, {"crowd=", crowd}, {"threads=", threads},
               {"states=", states}, {"run=", run},       {"wrong=", wrong}};
  take_arguments(argc, argv);
  for (int i = 7; i < argc; ++i) {
    size_t t = 0;
    while (t < sizeof tasks / sizeof tasks[0] && strncmp(argv[i], tasks[t].name, strlen(tasks[t].name)) != 0) ++t;
    if (t == sizeof tasks / sizeof tasks[0]) exit(2);
    tasks[t].run(atol(argv[i] + strlen(tasks[t].name)));
  }
  free(alone);
  return 0;
}

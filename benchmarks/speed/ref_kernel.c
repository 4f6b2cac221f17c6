/* SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 199309L
#include "ref_kernel.h"

#include <math.h>
#include <time.h>

#define SIZE 24

double cpu_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void factor(double A[SIZE][SIZE], double L[SIZE][SIZE]) {
  for (int i = 0; i < SIZE; ++i) {
    for (int j = 0; j <= i; ++j) {
      double rest = A[i][j];
      for (int k = 0; k < j; ++k) rest -= L[i][k] * L[j][k];
      L[i][j] = i == j ? sqrt(rest) : rest / L[j][j];
    }
  }
}

static void solve(double L[SIZE][SIZE], double x[SIZE]) {
  for (int i = 0; i < SIZE; ++i) {
    double rest = 1;
    for (int k = 0; k < i; ++k) rest -= L[i][k] * x[k];
    x[i] = rest / L[i][i];
  }
  for (int i = SIZE - 1; i >= 0; --i) {
    double rest = x[i];
    for (int k = i + 1; k < SIZE; ++k) rest -= L[k][i] * x[k];
    x[i] = rest / L[i][i];
  }
}

double ref_kernel(int repetitions) {
  static volatile double sink;
  double A[SIZE][SIZE], L[SIZE][SIZE], x[SIZE], least = 1e30;
  for (int i = 0; i < SIZE; ++i) {
    for (int j = 0; j < SIZE; ++j) A[i][j] = 1.0 / (1 + i + j) + (i == j ? 2.0 : 0.0);
  }
  for (int block = 0; block < 10; ++block) {
    const double begin = cpu_seconds();
    for (int r = 0; r < repetitions; ++r) {
      A[0][0] = 3.0 + 1e-9 * r;
      factor(A, L);
      solve(L, x);
      sink += x[0];
    }
    const double mean = (cpu_seconds() - begin) / repetitions;
    if (mean < least) least = mean;
  }
  return least;
}

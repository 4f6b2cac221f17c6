/* SPDX-License-Identifier: BSD-3-Clause
 * The unit of time of the measurements, `ref`: Cholesky factorization and solution of a symmetric
 * positive definite system of 24 equations, in plain C. It makes times comparable between machines and under load. */
#pragma once
#ifdef __cplusplus
extern "C" {
#endif
/* Processor time of this thread [s]. */
double cpu_seconds(void);
/* Time of one call [s]: the smallest mean of ten blocks of `repetitions`. */
double ref_kernel(int repetitions);
#ifdef __cplusplus
}
#endif

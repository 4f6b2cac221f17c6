/* SPDX-License-Identifier: BSD-3-Clause
 * The unit of time of the measurements, `ref`: a symmetric positive definite system of 24 equations factorised by
 * Cholesky and solved, in plain C. Times of two machines, or of one busy machine at two moments, compare by it. */
#pragma once
#ifdef __cplusplus
extern "C" {
#endif
/* s of this thread's processor time. */
double cpu_seconds(void);
/* s for one: the least mean of ten blocks of `repetitions`. */
double ref_kernel(int repetitions);
#ifdef __cplusplus
}
#endif

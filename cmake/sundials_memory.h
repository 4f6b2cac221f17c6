/* SPDX-License-Identifier: BSD-3-Clause
 * Included before each file of SUNDIALS where the linker cannot redirect its calls of malloc: fmu/memory.cpp. */
#pragma once
#include <stdlib.h>

void* gelenk_malloc(size_t n);
void* gelenk_calloc(size_t count, size_t n);
void* gelenk_realloc(void* block, size_t n);
void gelenk_free(void* block);

#define malloc gelenk_malloc
#define calloc gelenk_calloc
#define realloc gelenk_realloc
#define free gelenk_free

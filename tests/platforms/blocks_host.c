/* SPDX-License-Identifier: BSD-3-Clause
 * The functions of fmu/zig.cpp, linked into this program, against loops over bytes: all sizes and distances of blocks up
 * to some hundred bytes. Prints the number of comparisons. */
#include <stddef.h>
#include <stdio.h>

enum { ROOM = 512, LONGEST = 150 };

void* memmove(void* to, const void* from, size_t n);
void* memcpy(void* to, const void* from, size_t n);
void* memset(void* to, int value, size_t n);
int memcmp(const void* a, const void* b, size_t n);
int bcmp(const void* a, const void* b, size_t n);

static unsigned char found[ROOM], expected[ROOM], before[ROOM];
static long comparisons;

static void prepare(void) {
  for (volatile int i = 0; i < ROOM; ++i) found[i] = expected[i] = before[i] = (unsigned char)(37 * i + i / 7 + 1);
}

static int same(void) {
  ++comparisons;
  for (volatile int i = 0; i < ROOM; ++i) {
    if (found[i] != expected[i]) return 0;
  }
  return 1;
}

static int sign(int x) { return (x > 0) - (x < 0); }

int main(void) {
  for (size_t n = 0; n <= LONGEST; ++n) {
    for (int shift = -LONGEST - 1; shift <= LONGEST + 1; ++shift) {
      const int from = 180, to = from + shift;
      prepare();
      for (volatile size_t i = 0; i < n; ++i) expected[to + (int)i] = before[from + (int)i];
      if (memmove(found + to, found + from, n) != found + to || !same()) return 3;
      prepare();
      for (volatile size_t i = 0; i < n; ++i) expected[to + (int)i] = before[i];
      if (memcpy(found + to, before, n) != found + to || !same()) return 4;
    }
    for (int value = -1; value < 300; value += 7) {
      prepare();
      for (volatile size_t i = 0; i < n; ++i) expected[101 + i] = (unsigned char)value;
      if (memset(found + 101, value, n) != found + 101 || !same()) return 5;
    }
    prepare();
    if (memcmp(found, expected, n) != 0 || bcmp(found, expected, n) != 0) return 6;
    for (size_t at = 0; at < n; ++at) {
      for (int other = 1; other < 256; other += 50) {
        prepare();
        found[at] = (unsigned char)(found[at] + other);
        found[at + 1] = (unsigned char)~found[at + 1]; /* the first difference decides */
        ++comparisons;
        if (sign(memcmp(found, expected, n)) != sign(found[at] - expected[at]) || bcmp(found, expected, n) == 0) return 7;
        if (memcmp(found, expected, at) != 0) return 8;
      }
    }
  }
  printf("%ld\n", comparisons);
  return 0;
}

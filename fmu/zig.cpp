// SPDX-License-Identifier: BSD-3-Clause
// Zig links these functions from its own runtime, which compares byte by byte and takes three times as many
// instructions as glibc to copy the few numbers of a mechanism. With those below, a step of the four-bar has 4 % fewer.
// cmake/GelenkFmu.cmake compiles this file with Zig's Clang only, and as if these functions were not known: it would
// call them in place of the loops.
#include <cstddef>
#include <cstdint>

namespace {

using Words __attribute__((vector_size(16))) = std::uint64_t;

template <class T>
T read_unaligned(const unsigned char* at) {
  T value;
  __builtin_memcpy_inline(&value, at, sizeof value);
  return value;
}

template <class T>
void store(unsigned char* at, T value) {
  __builtin_memcpy_inline(at, &value, sizeof value);
}

// sizeof(T) to 2 sizeof(T) bytes. All are read before any is written.
template <class T>
void move_ends(unsigned char* to, const unsigned char* from, std::size_t n) {
  const T first = read_unaligned<T>(from), last = read_unaligned<T>(from + n - sizeof(T));
  store(to, first);
  store(to + n - sizeof(T), last);
}

template <class T>
void fill_ends(unsigned char* to, T value, std::size_t n) {
  store(to, value);
  store(to + n - sizeof(T), value);
}

void move_few(unsigned char* to, const unsigned char* from, std::size_t n) {
  if (n >= 8) {
    move_ends<std::uint64_t>(to, from, n);
  } else if (n >= 4) {
    move_ends<std::uint32_t>(to, from, n);
  } else if (n >= 2) {
    move_ends<std::uint16_t>(to, from, n);
  } else if (n == 1) {
    *to = *from;
  }
}

void move_up(unsigned char* to, const unsigned char* from, std::size_t n) {
  const auto last = read_unaligned<Words>(from + n - 16);
  std::size_t i = 0;
  for (; i + 32 < n; i += 32) {
    const auto a = read_unaligned<Words>(from + i), b = read_unaligned<Words>(from + i + 16);
    store(to + i, a);
    store(to + i + 16, b);
  }
  if (i + 16 < n) store(to + i, read_unaligned<Words>(from + i));
  store(to + n - 16, last);
}

void move_down(unsigned char* to, const unsigned char* from, std::size_t n) {
  const auto first = read_unaligned<Words>(from);
  std::size_t i = n;
  for (; i > 32; i -= 32) {
    const auto a = read_unaligned<Words>(from + i - 16), b = read_unaligned<Words>(from + i - 32);
    store(to + i - 16, a);
    store(to + i - 32, b);
  }
  if (i > 16) store(to + i - 16, read_unaligned<Words>(from + i - 16));
  store(to, first);
}

void move(unsigned char* to, const unsigned char* from, std::size_t n) {
  if (n <= 16) {
    move_few(to, from, n);
  } else if (n <= 32) {
    move_ends<Words>(to, from, n);
  } else if (reinterpret_cast<std::uintptr_t>(to) - reinterpret_cast<std::uintptr_t>(from) >= n) {
    move_up(to, from, n);  // what is overwritten has been read
  } else {
    move_down(to, from, n);
  }
}

int compare(const unsigned char* a, const unsigned char* b, std::size_t n) {
  std::size_t i = 0;
  for (; i + 8 <= n; i += 8) {
    if (read_unaligned<std::uint64_t>(a + i) != read_unaligned<std::uint64_t>(b + i)) break;  // the bytes decide
  }
  for (; i < n; ++i) {
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  }
  return 0;
}

void fill(unsigned char* to, unsigned char value, std::size_t n) {
  const std::uint64_t eight = 0x0101010101010101U * value;
  if (n >= 16) {
    const Words sixteen = {eight, eight};
    for (std::size_t i = 0; i + 16 < n; i += 16) store(to + i, sixteen);
    store(to + n - 16, sixteen);
  } else if (n >= 8) {
    fill_ends<std::uint64_t>(to, eight, n);
  } else if (n >= 4) {
    fill_ends<std::uint32_t>(to, static_cast<std::uint32_t>(eight), n);
  } else {
    for (std::size_t i = 0; i < n; ++i) to[i] = value;
  }
}

}  // namespace

extern "C" {
void* memmove(void* to, const void* from, std::size_t n) {
  move(static_cast<unsigned char*>(to), static_cast<const unsigned char*>(from), n);
  return to;
}
void* memcpy(void* to, const void* from, std::size_t n) { return memmove(to, from, n); }
void* memset(void* to, int value, std::size_t n) {
  fill(static_cast<unsigned char*>(to), static_cast<unsigned char>(value), n);
  return to;
}
int memcmp(const void* a, const void* b, std::size_t n) {
  return compare(static_cast<const unsigned char*>(a), static_cast<const unsigned char*>(b), n);
}
int bcmp(const void* a, const void* b, std::size_t n) { return memcmp(a, b, n); }  // Clang calls it, too
}

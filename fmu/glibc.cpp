// SPDX-License-Identifier: BSD-3-Clause
// A library linked on this machine would require its glibc or a newer one, because of a few symbols whose older
// versions do the same. Here the older versions are requested instead, so that FMUs and the Python module load on all
// systems named in docs/fmu.md. The linker redirects the calls to the __wrap_ functions (cmake/GelenkGlibc.cmake).
#include <cstddef>

#if defined(__x86_64__) && defined(__GLIBC__)
#include <dlfcn.h>
#include <link.h>
#include <pthread.h>
#include <sys/stat.h>

// The version of all symbols of the first glibc for x86-64.
#define GELENK_FIRST(function) __asm__(".symver first_" #function "," #function "@GLIBC_2.2.5")

// The names are those of the linker and glibc.
// NOLINTBEGIN(bugprone-reserved-identifier,performance-no-int-to-ptr)
extern "C" {

// glibc 2.29, 2.35 and 2.38 introduced versions of these without an obsolete variant of error handling; the results are
// computed by the same code.
#define GELENK_REAL(function)        \
  GELENK_FIRST(function);            \
  double first_##function(double x); \
  double __wrap_##function(double x) { return first_##function(x); }
#define GELENK_REAL_2(function)                \
  GELENK_FIRST(function);                      \
  double first_##function(double x, double y); \
  double __wrap_##function(double x, double y) { return first_##function(x, y); }
GELENK_REAL(exp)
GELENK_REAL(exp2)
GELENK_REAL(log)
GELENK_REAL(log2)
GELENK_REAL_2(pow)
GELENK_REAL_2(hypot)
GELENK_REAL_2(fmod)

// glibc 2.33 introduced functions for what had been inline code around these.
GELENK_FIRST(__xstat);
GELENK_FIRST(__fxstat);
int first___xstat(int version, const char* path, struct stat* found);
int first___fxstat(int version, int file, struct stat* found);
constexpr int stat_version = 1;  // of struct stat on x86-64, which is the same as stat64

int __wrap_stat(const char* path, struct stat* found) { return first___xstat(stat_version, path, found); }
int __wrap_fstat64(int file, struct stat* found) { return first___fxstat(stat_version, file, found); }

// glibc 2.34 moved these from libpthread to libc.
GELENK_FIRST(pthread_once);
GELENK_FIRST(__pthread_key_create);
int first_pthread_once(pthread_once_t* once, void (*function)());
int first___pthread_key_create(pthread_key_t* key, void (*destroy)(void*));

int __wrap_pthread_once(pthread_once_t* once, void (*function)()) { return first_pthread_once(once, function); }
int __wrap___pthread_key_create(pthread_key_t* key, void (*destroy)(void*)) {
  return first___pthread_key_create(key, destroy);
}

#if __GLIBC_PREREQ(2, 32)
// Always false: whether reference counts may be changed without atomic operations. The host may start threads at any
// time.
extern char __libc_single_threaded;
char __libc_single_threaded = 0;
#endif

#if __GLIBC_PREREQ(2, 35)
// Finds the unwind tables of exceptions, for which glibc has a function since 2.35.
int _dl_find_object(void* address, struct dl_find_object* result) noexcept {
  struct Search {
    ElfW(Addr) address;
    struct dl_find_object* result;
  } search{reinterpret_cast<ElfW(Addr)>(address), result};
  const auto look = [](struct dl_phdr_info* object, std::size_t /*size*/, void* data) {
    auto& wanted = *static_cast<Search*>(data);
    const ElfW(Phdr)* tables = nullptr;
    const ElfW(Phdr)* home = nullptr;
    for (int i = 0; i < object->dlpi_phnum; ++i) {
      const ElfW(Phdr) & part = object->dlpi_phdr[i];
      if (part.p_type == PT_GNU_EH_FRAME) tables = &part;
      if (part.p_type == PT_LOAD && wanted.address - object->dlpi_addr - part.p_vaddr < part.p_memsz) home = &part;
    }
    if (home == nullptr) return 0;
    if (tables == nullptr) return -1;
    *wanted.result = {};
    wanted.result->dlfo_map_start = reinterpret_cast<void*>(object->dlpi_addr + home->p_vaddr);
    wanted.result->dlfo_map_end = reinterpret_cast<void*>(object->dlpi_addr + home->p_vaddr + home->p_memsz);
    wanted.result->dlfo_eh_frame = reinterpret_cast<void*>(object->dlpi_addr + tables->p_vaddr);
    return 1;
  };
  return dl_iterate_phdr(look, &search) == 1 ? 0 : -1;
}
#endif

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier,performance-no-int-to-ptr)
#endif

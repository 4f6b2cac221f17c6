// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/memory.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <functional>
#include <limits>
#include <mutex>

#include "fmu/spin_lock.h"
#include "fmu/step_memory.h"

namespace gelenk {
namespace {

// A stack of blocks: memory is reclaimed when the last block or all blocks are freed.
class Store {
 public:
  void* take(std::size_t n) noexcept {
    constexpr std::size_t grain = alignof(std::max_align_t);
    const std::size_t size = (std::max<std::size_t>(n, 1) + grain - 1) / grain * grain;
    const std::scoped_lock lock(lock_);
    if (size < n || size > bytes_.size() - used_) return nullptr;
    last_ = used_;
    used_ += size;
    ++blocks_;
    return bytes_.data() + last_;
  }

  // Number of bytes from a block to the end of the used part; 0: the block is not from this store.
  std::size_t size_bound(const void* block) noexcept {
    const auto* at = static_cast<const std::byte*>(block);
    if (!is_mine(at)) return 0;
    const std::scoped_lock lock(lock_);
    return static_cast<std::size_t>(bytes_.data() + used_ - at);
  }

  // Returns false if the block is not from this store.
  bool release(const void* block) noexcept {
    const auto* at = static_cast<const std::byte*>(block);
    if (!is_mine(at)) return false;
    const std::scoped_lock lock(lock_);
    if (at == bytes_.data() + last_) used_ = last_;
    if (--blocks_ == 0) used_ = last_ = 0;
    return true;
  }

 private:
  bool is_mine(const std::byte* at) const noexcept {
    return !std::less<>()(at, bytes_.data()) && std::less<>()(at, bytes_.data() + bytes_.size());
  }

  // Pages that are never touched take no physical memory.
  alignas(std::max_align_t) std::array<std::byte, std::size_t{16} << 20U> bytes_{};
  std::size_t used_ = 0, last_ = 0, blocks_ = 0;
  SpinLock lock_;
};

constinit Store store;
struct ReserveUse {
  bool open = false, used = false;
};
constinit thread_local ReserveUse reserve_use;

void* from_reserve(std::size_t n) noexcept {
  ReserveUse& use = reserve_use;
  void* block = use.open ? store.take(n) : nullptr;
  if (block != nullptr) use.used = true;
  return block;
}

}  // namespace

// An address of the thread's own memory costs a call; it is found once.
MemoryReserve::MemoryReserve() : use_(&reserve_use) {
  auto& use = *static_cast<ReserveUse*>(use_);
  open_before_ = use.open;
  used_before_ = use.used;
  use = {.open = true, .used = false};
}

MemoryReserve::~MemoryReserve() { *static_cast<ReserveUse*>(use_) = {.open = open_before_, .used = used_before_}; }

bool MemoryReserve::was_used() const { return static_cast<ReserveUse*>(use_)->used; }

}  // namespace gelenk

// Formats with an option of the linker that redirects all calls in the library, including its static dependencies, to
// __wrap_malloc etc. (cmake/GelenkFmu.cmake). Elsewhere SUNDIALS is compiled with other names
// (cmake/sundials_memory.h), and the operators new and delete are replaced; calls of malloc in the C++ library and in
// Eigen stay as they are.
#if defined(__ELF__)
#define GELENK_OURS(function) __wrap_##function
#define GELENK_THEIRS(function) __real_##function
#else
#include <cstdlib>
#include <new>
#define GELENK_OURS(function) gelenk_##function
#define GELENK_THEIRS(function) std::function
#endif

// The names are the linker's. NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {

#if defined(__ELF__)
void* __real_malloc(std::size_t n);
void* __real_calloc(std::size_t count, std::size_t n);
void* __real_realloc(void* block, std::size_t n);
void __real_free(void* block);
#endif

void* GELENK_OURS(malloc)(std::size_t n) {
  void* block = gelenk::StepMemory::take(n);
  if (block == nullptr) block = GELENK_THEIRS(malloc)(n);
  return block != nullptr ? block : gelenk::from_reserve(n);
}

void* GELENK_OURS(calloc)(std::size_t count, std::size_t n) {
  const bool overflows = n > 0 && count > std::numeric_limits<std::size_t>::max() / n;
  void* block = overflows ? nullptr : gelenk::StepMemory::take(count * n);
  if (block != nullptr) return std::memset(block, 0, count * n);
  block = GELENK_THEIRS(calloc)(count, n);
  if (block != nullptr || overflows) return block;
  block = gelenk::from_reserve(count * n);
  return block != nullptr ? std::memset(block, 0, count * n) : nullptr;
}

void GELENK_OURS(free)(void* block);

void* GELENK_OURS(realloc)(void* block, std::size_t n) {
  std::size_t room = gelenk::StepMemory::size(block);
  if (room >= n && room > 0) return block;
  if (room == 0) room = gelenk::store.size_bound(block);
  if (room == 0) {
    // The size of the block is unknown, so it cannot be moved to the reserve.
    return GELENK_THEIRS(realloc)(block, n);
  }
  void* other = GELENK_OURS(malloc)(n);
  if (other == nullptr) return nullptr;
  std::memcpy(other, block, std::min(n, room));
  GELENK_OURS(free)(block);
  return other;
}

void GELENK_OURS(free)(void* block) {
  if (gelenk::StepMemory::release(block) || gelenk::store.release(block) || gelenk::StepMemory::keep(block)) return;
  GELENK_THEIRS(free)(block);
}

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier)

#if !defined(__ELF__)
void* operator new(std::size_t n) {
  void* block = gelenk_malloc(std::max<std::size_t>(n, 1));
  if (block == nullptr) throw std::bad_alloc();
  return block;
}
void* operator new[](std::size_t n) { return operator new(n); }
void* operator new(std::size_t n, const std::nothrow_t& /*tag*/) noexcept {
  return gelenk_malloc(std::max<std::size_t>(n, 1));
}
void* operator new[](std::size_t n, const std::nothrow_t& tag) noexcept { return operator new(n, tag); }
void operator delete(void* block) noexcept { gelenk_free(block); }
void operator delete[](void* block) noexcept { gelenk_free(block); }
void operator delete(void* block, std::size_t /*n*/) noexcept { gelenk_free(block); }
void operator delete[](void* block, std::size_t /*n*/) noexcept { gelenk_free(block); }
void operator delete(void* block, const std::nothrow_t& /*tag*/) noexcept { gelenk_free(block); }
void operator delete[](void* block, const std::nothrow_t& /*tag*/) noexcept { gelenk_free(block); }
#endif

// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/step_memory.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstdlib>  // and posix_memalign
#include <mutex>
#include <new>
#include <utility>

#include "fmu/spin_lock.h"

namespace gelenk {
namespace {

// Of a region, and the multiples of it at which regions begin, so that blocks show to which they belong. Pages that are
// never touched take no physical memory.
constexpr std::size_t region_size = std::size_t{4} << 20U;
constexpr std::size_t grain = alignof(std::max_align_t);

// Sizes of blocks: multiples of the grain up to a limit, then four for each doubling.
constexpr std::size_t fine_limit = 1024;
constexpr std::size_t fine_classes = fine_limit / grain;
constexpr std::size_t doublings_to_half = 12;
constexpr std::size_t classes = fine_classes + std::size_t{4} * doublings_to_half;

struct Size {
  std::size_t at, bytes;  // the class, and what its blocks hold
};
Size size_for(std::size_t n) {
  n = std::max<std::size_t>(n, 1);
  if (n <= fine_limit) return {(n - 1) / grain, (n + grain - 1) / grain * grain};
  const auto doublings = static_cast<std::size_t>(std::bit_width(n - 1)) - 1;  // 2^doublings <= n - 1
  const std::size_t quarter = std::size_t{1} << (doublings - 2);
  const std::size_t part = (n - 1 - (std::size_t{1} << doublings)) / quarter;  // 0 to 3
  const auto first = static_cast<std::size_t>(std::bit_width(fine_limit)) - 1;
  return {fine_classes + 4 * (doublings - first) + part, (std::size_t{1} << doublings) + (part + 1) * quarter};
}

class Region {
 public:
  void* take(std::size_t n) noexcept {
    const std::scoped_lock lock(lock_);
    if (n > region_size / 2) {
      exhausted_ = true;
      return nullptr;
    }
    const Size size = size_for(n);
    Block* block = free_[size.at];
    if (block != nullptr) {
      free_[size.at] = block->next;
    } else {
      if (sizeof(Block) + size.bytes > region_size - used_) {
        exhausted_ = true;
        return nullptr;
      }
      block = new (reinterpret_cast<std::byte*>(this) + used_) Block;
      used_ += sizeof(Block) + size.bytes;
    }
    block->bytes = n;
    ++live_;
    return block + 1;
  }
  static std::size_t size(const void* block) noexcept { return size_for(before(block)->bytes).bytes; }
  // Returns whether that was the last block of a region without an owner.
  bool release(void* of) noexcept {
    auto* const block = static_cast<Block*>(of) - 1;
    const std::scoped_lock lock(lock_);
    Block*& first = free_[size_for(block->bytes).at];
    block->next = first;
    first = block;
    return --live_ == 0 && orphaned_;
  }
  bool keep(void* of) noexcept {
    const std::scoped_lock lock(lock_);
    if (exhausted_ || of == nullptr) return false;
    kept_ = new (of) Kept{kept_};
    return true;
  }
  // The same where the owner goes; frees what has been kept.
  bool orphan() noexcept {
    Kept* kept = nullptr;
    bool is_empty = false;
    {
      const std::scoped_lock lock(lock_);
      exhausted_ = orphaned_ = true;
      kept = std::exchange(kept_, nullptr);
      is_empty = live_ == 0;
    }
    while (kept != nullptr) std::free(std::exchange(kept, kept->next));
    return is_empty;
  }

 private:
  struct alignas(grain) Block {
    union {
      std::size_t bytes;  // while it is taken
      Block* next;
    };
  };
  struct Kept {  // in a block of the heap, which holds at least a pointer
    Kept* next;
  };
  static const Block* before(const void* block) { return static_cast<const Block*>(block) - 1; }

  SpinLock lock_;
  bool exhausted_ = false, orphaned_ = false;
  Kept* kept_ = nullptr;
  std::size_t live_ = 0;
  std::array<Block*, classes> free_{};
  std::size_t used_ = (sizeof(Region) + grain - 1) / grain * grain;
};

// All regions, by address, without a lock.
class Regions {
 public:
  bool add(Region* region) noexcept {
    for (std::size_t k = 0; k < probes; ++k) {
      Region* none = nullptr;
      if (slot(number(region), k).compare_exchange_strong(none, region)) return true;
    }
    return false;
  }
  void remove(Region* region) noexcept {
    for (std::size_t k = 0; k < probes; ++k) {
      Region* own = region;
      if (slot(number(region), k).compare_exchange_strong(own, nullptr)) return;
    }
  }
  // The region of a block; null: it is from elsewhere.
  Region* of(const void* block) noexcept {
    const std::uintptr_t at = number(block) / region_size * region_size;
    for (std::size_t k = 0; k < probes; ++k) {
      Region* const region = slot(at, k).load(std::memory_order_acquire);
      if (region != nullptr && number(region) == at) return region;
    }
    return nullptr;
  }

 private:
  static constexpr std::size_t probes = 4;
  static constexpr std::size_t slots = 4096;

  static std::uintptr_t number(const void* address) { return reinterpret_cast<std::uintptr_t>(address); }
  std::atomic<Region*>& slot(std::uintptr_t at, std::size_t k) { return slots_[(at / region_size + k) % slots]; }

  std::array<std::atomic<Region*>, slots> slots_{};
};

constinit Regions regions;
constinit thread_local void* in_use = nullptr;

void give_back(Region* region) noexcept {
  regions.remove(region);
  std::free(region);
}

}  // namespace

// Sanitizers see what steps do with memory on the heap alone.
#if defined(__ELF__) && !defined(GELENK_STEPS_USE_HEAP)
StepMemory::StepMemory() {
  if (posix_memalign(&region_, region_size, region_size) != 0) {  // older systems have no std::aligned_alloc
    region_ = nullptr;
    return;
  }
  auto* const region = new (region_) Region;
  if (regions.add(region)) return;
  std::free(region_);
  region_ = nullptr;
}
#else  // also where malloc is not replaced (memory.cpp)
StepMemory::StepMemory() = default;
#endif

StepMemory::~StepMemory() {
  auto* const region = static_cast<Region*>(region_);
  if (region != nullptr && region->orphan()) give_back(region);
}

StepMemory::InUse::InUse(const StepMemory* memory) : in_use_(&in_use), before_(*in_use_) {
  *in_use_ = memory == nullptr ? nullptr : memory->region_;
}

StepMemory::InUse::~InUse() { *in_use_ = before_; }

void* StepMemory::take(std::size_t n) noexcept {
  return in_use == nullptr ? nullptr : static_cast<Region*>(in_use)->take(n);
}

std::size_t StepMemory::size(const void* block) noexcept {
  return regions.of(block) != nullptr ? Region::size(block) : 0;
}

bool StepMemory::keep(void* block) noexcept { return in_use != nullptr && static_cast<Region*>(in_use)->keep(block); }

bool StepMemory::release(void* block) noexcept {
  Region* const region = regions.of(block);
  if (region == nullptr) return false;
  if (region->release(block)) give_back(region);
  return true;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "machine_code/executable_memory.h"

#include <atomic>
#include <cstring>
#include <utility>

#ifdef _WIN32
#define NOMINMAX
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#elif !defined(__wasm__)
#include <sys/mman.h>
#endif

namespace gelenk::machine_code {
namespace {

std::atomic<bool> is_refused{false};
// Systems permit some 65,000 mappings in a process, which others need, too.
constexpr int most_mappings = 16384;
std::atomic<int> mappings{0};

#ifdef _WIN32

void* copied(std::span<const std::uint8_t> code) {
  void* const first = VirtualAlloc(nullptr, code.size(), MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
  if (first == nullptr) return nullptr;
  std::memcpy(first, code.data(), code.size());
  DWORD before = 0;
  if (VirtualProtect(first, code.size(), PAGE_EXECUTE_READ, &before) == 0) {
    VirtualFree(first, 0, MEM_RELEASE);
    return nullptr;
  }
  FlushInstructionCache(GetCurrentProcess(), first, code.size());
  return first;
}

void unmap(void* first, std::size_t /*size*/) { VirtualFree(first, 0, MEM_RELEASE); }

#elif defined(__wasm__)

void* copied(std::span<const std::uint8_t> /*code*/) { return nullptr; }
void unmap(void* /*first*/, std::size_t /*size*/) {}

#else

void* copied(std::span<const std::uint8_t> code) {
  void* const first = mmap(nullptr, code.size(), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (first == MAP_FAILED) return nullptr;
  std::memcpy(first, code.data(), code.size());
  if (mprotect(first, code.size(), PROT_READ | PROT_EXEC) != 0) {
    munmap(first, code.size());
    return nullptr;
  }
  return first;
}

void unmap(void* first, std::size_t size) { munmap(first, size); }

#endif

}  // namespace

ExecutableMemory::ExecutableMemory(std::span<const std::uint8_t> code) : size_(code.size()) {
  if (code.empty() || is_refused.load()) return;
  if (++mappings <= most_mappings) first_ = copied(code);
  if (first_ == nullptr) --mappings;
}

void ExecutableMemory::swap(ExecutableMemory& other) noexcept {
  std::swap(first_, other.first_);
  std::swap(size_, other.size_);
}

void ExecutableMemory::release() {
  if (first_ == nullptr) return;
  unmap(first_, size_);
  first_ = nullptr;
  --mappings;
}

void ExecutableMemory::refuse(bool on) { is_refused.store(on); }

}  // namespace gelenk::machine_code

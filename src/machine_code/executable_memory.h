// SPDX-License-Identifier: BSD-3-Clause
// Memory that holds machine code: written first, then executable, never both at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace gelenk::machine_code {

class ExecutableMemory {
 public:
  ExecutableMemory() = default;
  // A copy of the code; empty if the system does not permit it.
  explicit ExecutableMemory(std::span<const std::uint8_t> code);
  ~ExecutableMemory() { release(); }
  ExecutableMemory(ExecutableMemory&& other) noexcept { swap(other); }
  ExecutableMemory& operator=(ExecutableMemory&& other) noexcept {
    swap(other);
    return *this;
  }
  ExecutableMemory(const ExecutableMemory&) = delete;
  ExecutableMemory& operator=(const ExecutableMemory&) = delete;

  bool empty() const { return first_ == nullptr; }
  void* at(std::size_t offset) const { return static_cast<std::uint8_t*>(first_) + offset; }

  // For tests: behaves as a system that permits no such memory.
  static void refuse(bool on);

 private:
  void swap(ExecutableMemory& other) noexcept;
  void release();

  void* first_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace gelenk::machine_code

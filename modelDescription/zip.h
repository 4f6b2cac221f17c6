// SPDX-License-Identifier: BSD-3-Clause
// A ZIP archive in memory, entries stored as they are (APPNOTE.TXT 6.3, sections 4.3.7, 4.3.12, 4.3.16).
// Dates are fixed, so that the same content gives the same bytes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

class Zip {
 public:
  // name: relative, with forward slashes, UTF-8. Throws std::length_error when the archive would pass 4 GB.
  void add(const std::string& name, std::string_view content, bool executable = false);

  // The archive's bytes; the archive is then empty.
  std::string finish();

 private:
  struct Entry {
    std::string name;
    std::uint32_t crc, size, offset, mode;
  };
  std::vector<Entry> entries_;
  std::string bytes_;
};

// CRC-32 of ISO 3309, as ZIP wants it.
std::uint32_t crc32(std::string_view content);

}  // namespace gelenk

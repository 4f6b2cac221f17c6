// SPDX-License-Identifier: BSD-3-Clause
// A ZIP archive in memory (APPNOTE.TXT 6.3, sections 4.3.7, 4.3.12, 4.3.16). Dates are fixed, so that the same content
// gives the same bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gelenk {

// Gives the zlib stream (RFC 1950) of bytes, without a dictionary. Who packs brings it: zlib itself, or Python's.
using Compress = std::function<std::string(std::string_view)>;

class Zip {
 public:
  // compress: makes smaller what it can; empty: entries are stored as they are.
  explicit Zip(Compress compress) : compress_(std::move(compress)) {}

  // name: relative, with forward slashes, UTF-8. Throws std::length_error when the archive would pass 4 GB.
  void add(const std::string& name, std::string_view content, bool executable = false);

  // The content of a gzip file (RFC 1952), taken over as it is compressed there. False: it is no such file, or one with
  // more in its head than a name.
  bool add_gzip(const std::string& name, std::string_view gzip, bool executable = false);

  // The archive's bytes; the archive is then empty.
  std::string finish();

 private:
  struct Entry {
    std::string name;
    std::uint32_t method, crc, packed, size, offset, mode;
  };
  void put_entry(const std::string& name, std::string_view packed, std::uint32_t method, std::uint32_t crc,
                 std::size_t size, bool executable);
  void put_common(const Entry& entry);

  Compress compress_;
  std::vector<Entry> entries_;
  std::string bytes_;
};

// CRC-32 of ISO 3309, as ZIP and PNG want it.
std::uint32_t crc32(std::string_view content);

}  // namespace gelenk

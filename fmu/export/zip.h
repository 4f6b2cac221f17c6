// SPDX-License-Identifier: BSD-3-Clause
// A ZIP archive in memory (APPNOTE.TXT 6.3, sections 4.3.7, 4.3.12, 4.3.16). Dates are constant, so that the same
// content gives the same bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gelenk {

// Compresses bytes to a zlib stream (RFC 1950) without a dictionary. Provided by the caller: zlib, or Python's zlib.
using Compress = std::function<std::string(std::string_view)>;

class Zip {
 public:
  // compress: used for entries that become smaller; empty: all entries are stored uncompressed.
  explicit Zip(Compress compress) : compress_(std::move(compress)) {}

  // name: relative, with forward slashes, UTF-8. Throws std::length_error if the archive would exceed 4 GB or 65535
  // files.
  void add(const std::string& name, std::string_view content, bool executable = false);

  // Adds the content of a gzip file (RFC 1952) without recompressing it. Returns false if it is not such a file or has
  // a header with more than a name.
  bool add_gzip(const std::string& name, std::string_view gzip, bool executable = false);

  // Returns the bytes of the archive, which is empty afterwards.
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

// CRC-32 of ISO 3309, as used by ZIP and PNG.
std::uint32_t crc32(std::string_view content);

}  // namespace gelenk

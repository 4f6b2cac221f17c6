// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/export/zip.h"

#include <array>
#include <limits>
#include <stdexcept>
#include <utility>

namespace gelenk {
namespace {

constexpr std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1U) : c >> 1U;
    table[i] = c;
  }
  return table;
}
constexpr auto crc_table = make_crc_table();

void put(std::string& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>((value >> (8 * i)) & 255U);
}

constexpr std::uint32_t unix_version_2 = 3U << 8U | 20U;
constexpr std::uint32_t regular_file = 0100000U;
constexpr std::uint32_t names_are_utf8 = 1U << 11U;
constexpr std::uint32_t first_of_january_1980 = 1U << 5U | 1U;  // MS-DOS date

constexpr std::uint32_t stored = 0;
constexpr std::uint32_t deflated = 8;

std::uint32_t number(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  return value;
}

}  // namespace

std::uint32_t crc32(std::string_view content) {
  std::uint32_t c = ~0U;
  for (const char byte : content) c = crc_table[(c ^ static_cast<unsigned char>(byte)) & 255U] ^ (c >> 8U);
  return ~c;
}

void Zip::add(const std::string& name, std::string_view content, bool executable) {
  const std::string stream = compress_ ? compress_(content) : std::string();
  constexpr std::size_t zlib_overhead = 6;  // bytes: header 2, checksum 4
  if (stream.size() > zlib_overhead && stream.size() - zlib_overhead < content.size()) {
    const std::string_view packed(stream.data() + 2, stream.size() - zlib_overhead);
    put_entry(name, packed, deflated, crc32(content), content.size(), executable);
  } else {
    put_entry(name, content, stored, crc32(content), content.size(), executable);
  }
}

bool Zip::add_gzip(const std::string& name, std::string_view gzip, bool executable) {
  using namespace std::string_view_literals;
  constexpr std::size_t fixed_header = 10;  // bytes
  constexpr std::size_t trailer = 8;        // bytes: CRC-32, size
  if (gzip.size() < fixed_header || !gzip.starts_with("\x1f\x8b\x08"sv)) return false;
  constexpr char name_flag = 8;
  if (gzip[3] != 0 && gzip[3] != name_flag) return false;
  const std::size_t header = gzip[3] == name_flag ? gzip.find('\0', fixed_header) + 1 : fixed_header;
  if (header < fixed_header || gzip.size() <= header + trailer) return false;
  const std::string_view packed = gzip.substr(header, gzip.size() - header - trailer);
  const std::string_view sums = gzip.substr(gzip.size() - trailer);
  put_entry(name, packed, deflated, number(sums), number(sums.substr(4)), executable);
  return true;
}

void Zip::put_entry(const std::string& name, std::string_view packed, std::uint32_t method, std::uint32_t crc,
                    std::size_t size, bool executable) {
  constexpr std::size_t limit = std::numeric_limits<std::uint32_t>::max();
  if (size + bytes_.size() + (1U << 20U) > limit || entries_.size() >= 65535) {
    throw std::length_error("the archive would have more than 4 GB or 65535 files");
  }
  entries_.push_back({name, method, crc, static_cast<std::uint32_t>(packed.size()), static_cast<std::uint32_t>(size),
                      static_cast<std::uint32_t>(bytes_.size()), regular_file | (executable ? 0755U : 0644U)});
  put(bytes_, 0x04034b50U, 4);
  put_common(entries_.back());
  bytes_ += name;
  bytes_ += packed;
}

// The fields common to local headers and the central directory, from "version needed" to "extra field length".
void Zip::put_common(const Entry& entry) {
  put(bytes_, 20, 2);
  put(bytes_, names_are_utf8, 2);
  put(bytes_, entry.method, 2);
  put(bytes_, 0, 2);  // midnight
  put(bytes_, first_of_january_1980, 2);
  put(bytes_, entry.crc, 4);
  put(bytes_, entry.packed, 4);
  put(bytes_, entry.size, 4);
  put(bytes_, static_cast<std::uint32_t>(entry.name.size()), 2);
  put(bytes_, 0, 2);
}

std::string Zip::finish() {
  const auto directory = static_cast<std::uint32_t>(bytes_.size());
  for (const Entry& entry : entries_) {
    put(bytes_, 0x02014b50U, 4);
    put(bytes_, unix_version_2, 2);
    put_common(entry);
    put(bytes_, 0, 2);  // comment
    put(bytes_, 0, 2);  // disk
    put(bytes_, 0, 2);  // internal attributes
    put(bytes_, entry.mode << 16U, 4);
    put(bytes_, entry.offset, 4);
    bytes_ += entry.name;
  }
  const auto size = static_cast<std::uint32_t>(bytes_.size()) - directory;
  const auto count = static_cast<std::uint32_t>(entries_.size());
  put(bytes_, 0x06054b50U, 4);
  put(bytes_, 0, 4);
  put(bytes_, count, 2);
  put(bytes_, count, 2);
  put(bytes_, size, 4);
  put(bytes_, directory, 4);
  put(bytes_, 0, 2);
  entries_.clear();
  return std::exchange(bytes_, {});
}

}  // namespace gelenk

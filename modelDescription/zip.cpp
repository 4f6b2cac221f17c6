// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/zip.h"

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

// What a local header and the directory say alike, from "version needed" to "extra field length".
void put_common(std::string& out, std::uint32_t crc, std::uint32_t size, std::size_t name_length) {
  put(out, 20, 2);
  put(out, names_are_utf8, 2);
  put(out, 0, 2);  // stored
  put(out, 0, 2);  // midnight
  put(out, first_of_january_1980, 2);
  put(out, crc, 4);
  put(out, size, 4);
  put(out, size, 4);
  put(out, static_cast<std::uint32_t>(name_length), 2);
  put(out, 0, 2);
}

}  // namespace

std::uint32_t crc32(std::string_view content) {
  std::uint32_t c = ~0U;
  for (const char byte : content) c = crc_table[(c ^ static_cast<unsigned char>(byte)) & 255U] ^ (c >> 8U);
  return ~c;
}

void Zip::add(const std::string& name, std::string_view content, bool executable) {
  constexpr std::size_t limit = std::numeric_limits<std::uint32_t>::max();
  if (content.size() + bytes_.size() + (1U << 20U) > limit || entries_.size() >= 65535) {
    throw std::length_error("the archive would have more than 4 GB or 65535 files");
  }
  const Entry entry{name, crc32(content), static_cast<std::uint32_t>(content.size()),
                    static_cast<std::uint32_t>(bytes_.size()), regular_file | (executable ? 0755U : 0644U)};
  put(bytes_, 0x04034b50U, 4);
  put_common(bytes_, entry.crc, entry.size, name.size());
  bytes_ += name;
  bytes_ += content;
  entries_.push_back(entry);
}

std::string Zip::finish() {
  const auto directory = static_cast<std::uint32_t>(bytes_.size());
  for (const Entry& entry : entries_) {
    put(bytes_, 0x02014b50U, 4);
    put(bytes_, unix_version_2, 2);
    put_common(bytes_, entry.crc, entry.size, entry.name.size());
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

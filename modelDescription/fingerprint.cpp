// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/fingerprint.h"

#include <ranges>

#ifndef GELENK_VERSION
#error "GELENK_VERSION is defined by the build: the project's version as a string"
#endif

namespace gelenk {
namespace {

__extension__ using Bits128 = unsigned __int128;

constexpr Bits128 join(unsigned long long high, unsigned long long low) {
  return (static_cast<Bits128>(high) << 64) | low;
}

// Fowler, Noll & Vo, FNV-1a: offset basis and prime for 128 bits.
constexpr Bits128 offset_basis = join(0x6c62272e07bb0142ULL, 0x62b821756295c58dULL);
constexpr Bits128 prime = join(0x0000000001000000ULL, 0x000000000000013bULL);

Bits128 add(Bits128 hash, std::string_view text) {
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * prime;
  return hash;
}

}  // namespace

std::string_view gelenk_version() { return GELENK_VERSION; }

std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

std::string fingerprint(std::string_view scene_json) {
  Bits128 hash = add(add(add(offset_basis, gelenk_version()), "\n"), scene_json);
  std::string text(32, '0');
  for (char& digit : std::views::reverse(text)) {
    digit = "0123456789abcdef"[static_cast<unsigned>(hash & 15)];
    hash >>= 4;
  }
  for (const std::size_t place : {20U, 16U, 12U, 8U}) text.insert(place, "-");
  return text;
}

}  // namespace gelenk

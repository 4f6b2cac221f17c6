// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/fingerprint.h"

#ifndef GELENK_VERSION
#error "GELENK_VERSION is defined by the build: the project's version as a string"
#endif

namespace gelenk {
namespace {

struct Bits128 {
  std::uint64_t high, low;
};

// Fowler, Noll & Vo, FNV-1a: offset basis and prime for 128 bits.
constexpr Bits128 offset_basis = {0x6c62272e07bb0142, 0x62b821756295c58d};

// Product with the prime 2^88 + 0x13b modulo 2^128.
Bits128 times_prime(Bits128 hash) {
  constexpr std::uint64_t rest = 0x13b;
  const std::uint64_t first = (hash.low & 0xffffffff) * rest;
  const std::uint64_t second = (hash.low >> 32) * rest + (first >> 32);
  return {hash.high * rest + (second >> 32) + (hash.low << 24), second << 32 | (first & 0xffffffff)};
}

Bits128 add(Bits128 hash, std::string_view text) {
  for (const char c : text) hash = times_prime({hash.high, hash.low ^ static_cast<unsigned char>(c)});
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
  const Bits128 hash = add(add(add(offset_basis, gelenk_version()), "\n"), scene_json);
  std::string text;
  for (const std::uint64_t half : {hash.high, hash.low}) {
    for (int shift = 60; shift >= 0; shift -= 4) text += "0123456789abcdef"[half >> shift & 15];
  }
  for (const std::size_t place : {20U, 16U, 12U, 8U}) text.insert(place, "-");
  return text;
}

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/saved_state.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "modelDescription/fingerprint.h"

namespace gelenk {
namespace {

constexpr std::uint64_t magic = 0x65746174734b4c47;  // "GLKstate" in this machine's byte order
constexpr std::uint64_t version = 1;                 // of the layout of the header and of the archive
constexpr std::size_t guid_length = 36;

struct Header {
  std::uint64_t magic, version;
  std::array<char, 40> guid;  // padded with zeros
  std::uint64_t words;        // of the archive
};

Header header_of(std::string_view guid, std::size_t words) {
  Header header{magic, version, {}, words};
  std::copy_n(guid.begin(), std::min(guid.size(), guid_length), header.guid.begin());
  return header;
}

constexpr std::size_t overhead = sizeof(Header) + sizeof(std::uint64_t);  // header and checksum

[[noreturn]] void refuse_bytes(const std::string& found, const std::string& expected) {
  throw std::invalid_argument("found " + found + ", expected " + expected);
}

}  // namespace

std::size_t serialized_size(const SavedState& state) {
  return overhead + state.archive.words().size() * sizeof(std::uint64_t);
}

void serialize(const SavedState& state, std::string_view guid, std::span<char> bytes) {
  const std::span<const std::uint64_t> words = state.archive.words();
  const Header header = header_of(guid, words.size());
  const std::size_t length = words.size() * sizeof(std::uint64_t);
  std::memcpy(bytes.data(), &header, sizeof header);
  if (length > 0) std::memcpy(bytes.data() + sizeof header, words.data(), length);
  const std::uint64_t sum = checksum({bytes.data(), sizeof header + length});
  std::memcpy(bytes.data() + sizeof header + length, &sum, sizeof sum);
}

std::unique_ptr<SavedState> deserialize(std::string_view guid, std::span<const char> bytes,
                                        const Vocabulary& vocabulary) {
  if (bytes.size() < overhead) {
    refuse_bytes(std::to_string(bytes.size()) + " bytes", "at least " + std::to_string(overhead));
  }
  Header header{};
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != magic) {
    refuse_bytes("bytes that are not a saved state", std::string("bytes written by ") + vocabulary.serialize);
  }
  if (header.version != version) {
    refuse_bytes("a state of layout " + std::to_string(header.version), "layout " + std::to_string(version));
  }
  const std::string_view found(header.guid.data(), guid_length);
  if (found != guid) {
    refuse_bytes("a state of another FMU, whose GUID is '" + std::string(found) + "'", "'" + std::string(guid) + "'");
  }
  const std::size_t length = bytes.size() - overhead;
  if (length % sizeof(std::uint64_t) != 0 || header.words != length / sizeof(std::uint64_t)) {
    refuse_bytes(std::to_string(bytes.size()) + " bytes",
                 std::string("the number returned by ") + vocabulary.serialized_size);
  }
  std::uint64_t sum = 0;
  std::memcpy(&sum, bytes.data() + sizeof header + length, sizeof sum);
  if (sum != checksum({bytes.data(), sizeof header + length})) {
    refuse_bytes("a state with a wrong checksum", "the state as it was written");
  }
  std::vector<std::uint64_t> words(header.words);
  if (length > 0) std::memcpy(words.data(), bytes.data() + sizeof header, length);
  return std::make_unique<SavedState>(SavedState{Archive(std::move(words)), false});
}

}  // namespace gelenk

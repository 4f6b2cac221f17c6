// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/saved_state.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "modelDescription/fingerprint.h"

namespace gelenk {
namespace {

constexpr std::uint64_t mark = 0x65746174734b4c47;  // "GLKstate", if the byte order is this machine's
constexpr std::uint64_t version = 1;                // of the layout, here and of what the classes write
constexpr std::size_t guid_length = 36;

struct Head {
  std::uint64_t mark, version;
  std::array<char, 40> guid;  // zeros behind it
  std::uint64_t words;        // of the record
};

Head head_of(std::string_view guid, std::size_t words) {
  Head head{mark, version, {}, words};
  std::copy_n(guid.begin(), std::min(guid.size(), guid_length), head.guid.begin());
  return head;
}

constexpr std::size_t frame = sizeof(Head) + sizeof(std::uint64_t);  // head and checksum

[[noreturn]] void refuse(const std::string& found, const std::string& expected) {
  throw std::invalid_argument("found " + found + ", expected " + expected);
}

}  // namespace

std::size_t serialized_size(const SavedState& state) {
  return frame + state.archive.words().size() * sizeof(std::uint64_t);
}

void serialize(const SavedState& state, std::string_view guid, std::span<char> bytes) {
  const std::vector<std::uint64_t>& words = state.archive.words();
  const Head head = head_of(guid, words.size());
  const std::size_t length = words.size() * sizeof(std::uint64_t);
  std::memcpy(bytes.data(), &head, sizeof head);
  if (length > 0) std::memcpy(bytes.data() + sizeof head, words.data(), length);
  const std::uint64_t sum = checksum({bytes.data(), sizeof head + length});
  std::memcpy(bytes.data() + sizeof head + length, &sum, sizeof sum);
}

std::unique_ptr<SavedState> deserialize(std::string_view guid, std::span<const char> bytes) {
  if (bytes.size() < frame) {
    refuse(std::to_string(bytes.size()) + " bytes", "at least " + std::to_string(frame));
  }
  Head head{};
  std::memcpy(&head, bytes.data(), sizeof head);
  if (head.mark != mark) refuse("bytes that are no state of a plant", "those of fmi2SerializeFMUstate");
  if (head.version != version) {
    refuse("a state of layout " + std::to_string(head.version), "layout " + std::to_string(version));
  }
  const std::string_view found(head.guid.data(), guid_length);
  if (found != guid) {
    refuse("a state of another FMU, whose GUID is '" + std::string(found) + "'", "'" + std::string(guid) + "'");
  }
  const std::size_t length = bytes.size() - frame;
  if (length % sizeof(std::uint64_t) != 0 || head.words != length / sizeof(std::uint64_t)) {
    refuse(std::to_string(bytes.size()) + " bytes", "as many as fmi2SerializedFMUstateSize told");
  }
  std::uint64_t sum = 0;
  std::memcpy(&sum, bytes.data() + sizeof head + length, sizeof sum);
  if (sum != checksum({bytes.data(), sizeof head + length})) {
    refuse("a state whose checksum is wrong", "it as it was written");
  }
  std::vector<std::uint64_t> words(head.words);
  if (length > 0) std::memcpy(words.data(), bytes.data() + sizeof head, length);
  return std::make_unique<SavedState>(SavedState{Archive(std::move(words)), false});
}

}  // namespace gelenk

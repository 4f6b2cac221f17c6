// SPDX-License-Identifier: BSD-3-Clause
// What stands behind an fmi2FMUstate, and how it travels between processes.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "util/archive.h"

namespace gelenk {

struct SavedState {
  Archive archive;
  bool own = true;  // this instance wrote it, or has gone on from it once; otherwise it came from outside
};

// Bytes of a state: a head (a mark, the layout's version, the plant's fingerprint, the length), the record's words in
// the machine's byte order, a checksum of all before. For instances of the same FMU and build.
std::size_t serialized_size(const SavedState& state);

// bytes: serialized_size() of them. guid: of the FMU; it covers scene and version.
void serialize(const SavedState& state, std::string_view guid, std::span<char> bytes);

// Throws std::invalid_argument, saying what was found and what is expected.
std::unique_ptr<SavedState> deserialize(std::string_view guid, std::span<const char> bytes);

}  // namespace gelenk

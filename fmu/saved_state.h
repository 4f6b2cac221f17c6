// SPDX-License-Identifier: BSD-3-Clause
// The implementation of an fmi2FMUstate or fmi3FMUState, and its serialization for other processes.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "fmu/status.h"
#include "util/archive.h"

namespace gelenk {

struct SavedState {
  Archive archive;
  bool own = true;  // whether this instance wrote it or has already restored it; otherwise it was deserialized
};

// Number of bytes of a serialized state: header (magic number, version of the layout, GUID, length), the words of the
// archive in the machine's byte order, and a checksum. Only for instances of the same FMU and build.
std::size_t serialized_size(const SavedState& state);

// Serializes a state. bytes: serialized_size(state) bytes. guid: that of the FMU, which identifies scene and version.
void serialize(const SavedState& state, std::string_view guid, std::span<char> bytes);

// vocabulary: for messages. Throws std::invalid_argument with what was found and what is expected.
std::unique_ptr<SavedState> deserialize(std::string_view guid, std::span<const char> bytes,
                                        const Vocabulary& vocabulary);

}  // namespace gelenk

// SPDX-License-Identifier: BSD-3-Clause
// Files are written completely, or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace gelenk {

// Writes a file, as python/gelenk/file_writing.py does: to a new file in the folder of the target, which is flushed to
// the disk and renamed. Symbolic links are followed, an existing file keeps its permissions. What is no regular file (a
// pipe, /dev/stdout) is written to directly, and so is a file in a folder in which no file can be made, or that cannot
// be replaced. Two processes may write one file. Throws std::system_error without the name of the file.
void write_file(const std::filesystem::path& target, std::string_view content);

}  // namespace gelenk

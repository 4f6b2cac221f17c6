// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/export/write_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#ifdef _WIN32
#include <io.h>
#else
#include <unistd.h>
#endif

namespace gelenk {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

#ifdef _WIN32
constexpr int new_file = _O_CREAT | _O_EXCL | _O_WRONLY | _O_BINARY;
constexpr int old_file = _O_CREAT | _O_TRUNC | _O_WRONLY | _O_BINARY;
int open_at(const fs::path& path, int flags) { return _wopen(path.c_str(), flags, _S_IREAD | _S_IWRITE); }
long long write_some(int file, const char* at, std::size_t size) {
  constexpr std::size_t most = 1U << 30U;
  return _write(file, at, static_cast<unsigned>(size < most ? size : most));
}
int flush_to_disk(int file) { return _commit(file); }
int close_file(int file) { return _close(file); }
#else
constexpr int new_file = O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC;
constexpr int old_file = O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC;
int open_at(const fs::path& path, int flags) { return ::open(path.c_str(), flags, 0666); }
long long write_some(int file, const char* at, std::size_t size) { return ::write(file, at, size); }
int flush_to_disk(int file) { return ::fsync(file); }
int close_file(int file) { return ::close(file); }
#endif

// An open file; closed at the latest at the end of its life.
class OpenFile {
 public:
  OpenFile(const fs::path& path, int flags) : file_(open_at(path, flags)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (is_open()) close_file(file_);
  }

  bool is_open() const { return file_ >= 0; }
  void write(std::string_view content) const {
    while (!content.empty()) {
      const long long count = write_some(file_, content.data(), content.size());
      if (count < 0 && errno != EINTR) fail(errno);
      if (count > 0) content.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  bool try_to_flush() const { return flush_to_disk(file_) == 0; }
  void flush() const {
    if (!try_to_flush()) fail(errno);
  }
  void close() {
    if (close_file(std::exchange(file_, -1)) != 0) fail(errno);
  }

 private:
  int file_;
};

void write_directly(const fs::path& target, std::string_view content) {
  OpenFile file(target, old_file);
  if (!file.is_open()) fail(errno);
  file.write(content);
  file.close();
}

// Whether what a folder contains are open files of a process, as in /dev and /dev/fd.
bool has_open_files(const fs::path& folder) {
  const std::string text = folder.string();
  return text == "/dev" || text == "/dev/fd" || text == "/proc" || text.starts_with("/proc/");
}

// Where a file is to be made or replaced, at the end of symbolic links; empty: it is written to directly.
fs::path place_of(const fs::path& target) {
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (error && fs::exists(fs::symlink_status(target)) && error != std::errc::no_such_file_or_directory) {
    throw std::system_error(error);
  }
  if (fs::is_directory(status)) fail(EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) return {};
  fs::path step = fs::absolute(target);
  constexpr int longest_chain = 40;  // of links on Linux
  for (int i = 0; i < longest_chain; ++i) {
    const fs::path folder = fs::canonical(step.parent_path(), error);
    if (error) throw std::system_error(error);
    if (has_open_files(folder)) return {};
    step = folder / step.filename();
    if (!fs::is_symlink(fs::symlink_status(step))) return step;
    step = folder / fs::read_symlink(step);
  }
  fail(ELOOP);
}

// ".NAME-0123456789abcdef.part" with the ending of the target: hidden, so that no pattern for the target meets it.
fs::path draft_name(const fs::path& place) {
  constexpr std::size_t longest_stem = 40;  // of the 255 bytes that names may have
  constexpr std::size_t longest_ending = 10;
  constexpr int digits = 16;
  std::random_device random;
  std::string number;
  while (number.size() < digits) number += "0123456789abcdef"[random() % 16];
  return place.parent_path() / ("." + place.stem().string().substr(0, longest_stem) + "-" + number + ".part" +
                                place.extension().string().substr(0, longest_ending));
}

// Gives a draft the owner and the permissions of the file that it will replace, as far as that is possible.
void make_alike([[maybe_unused]] const fs::path& draft, [[maybe_unused]] const fs::path& place) {
#ifndef _WIN32
  struct stat old{};
  if (::stat(place.c_str(), &old) != 0) return;
  [[maybe_unused]] const int of_another_user = ::chown(draft.c_str(), old.st_uid, old.st_gid);
  [[maybe_unused]] const int without_permissions = ::chmod(draft.c_str(), old.st_mode & 07777U);
#endif
}

// So that the new name is on the disk, too. Some file systems cannot; the content is there already.
void flush_folder([[maybe_unused]] const fs::path& folder) {
#ifndef _WIN32
  const OpenFile file(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file.is_open()) file.try_to_flush();
#endif
}

bool may_be_written(const fs::path& place) {
#ifdef _WIN32
  return ::_waccess(place.c_str(), 2) == 0;
#else
  return ::access(place.c_str(), W_OK) == 0;
#endif
}

// Deletes a draft unless it has been renamed.
struct Draft {
  fs::path path;
  explicit Draft(fs::path of) : path(std::move(of)) {}
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  ~Draft() {
    std::error_code none;
    fs::remove(path, none);
  }
};

}  // namespace

void write_file(const fs::path& target, std::string_view content) {
  const fs::path place = place_of(target);
  if (place.empty()) return write_directly(target, content);
  const bool exists = fs::exists(place);
  if (exists && !may_be_written(place)) fail(EACCES);
  const Draft draft(draft_name(place));
  OpenFile file(draft.path, new_file);
  if (!file.is_open()) {
    const int error = errno;
    if (exists && (error == EACCES || error == EPERM || error == EROFS)) return write_directly(place, content);
    fail(error);
  }
  if (exists) make_alike(draft.path, place);
  file.write(content);
  file.flush();
  file.close();
  std::error_code error;
  fs::rename(draft.path, place, error);
  // Of a file on which another file system is mounted, as in containers.
  if (error == std::errc::device_or_resource_busy || error == std::errc::cross_device_link) {
    return write_directly(place, content);
  }
  if (error) throw std::system_error(error);
  flush_folder(place.parent_path());
}

}  // namespace gelenk

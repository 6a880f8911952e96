// SPDX-License-Identifier: Apache-2.0
// Files by POSIX's calls.
#include "base/os/file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "base/error.h"

namespace bccsplat {
namespace {

// What strerror_r gives: a text of its own, or as POSIX has it a status, the text in the buffer.
[[maybe_unused]] const char* error_text(const char* text, const char* /*buffer*/) { return text; }
[[maybe_unused]] const char* error_text(int /*status*/, const char* buffer) { return buffer; }

[[noreturn]] void fail_errno(const std::string& path, const char* doing, int error) {
  Code code = Code::io_error;
  const char* hint = "";
  switch (error) {
  case ENOENT:
    code = Code::file_not_found;
    break;
  case EACCES:
  case EPERM:
  case EROFS:
    code = Code::permission_denied;
    break;
  case EEXIST:
    code = Code::file_exists;
    break;
  case ENOSPC:
  case EDQUOT:
  case EFBIG:
    code = Code::no_space;
    hint = "; free some space or write elsewhere";
    break;
  case ENOMEM:
    code = Code::out_of_memory;
    break;
  default:
    break;
  }
  char buffer[256] = {};
  fail(code, path, ": cannot ", doing, ": ", error_text(strerror_r(error, buffer, sizeof buffer), buffer),
       hint);
}

struct stat look(int file, const std::string& name) {
  struct stat info {};
  if (::fstat(file, &info) != 0) fail_errno(name, "read", errno);
  return info;
}

} // namespace

void OsFile::close() {
  if (is_open()) ::close(static_cast<int>(std::exchange(handle_, closed)));
}

OsFile OsFile::open_to_read(const std::string& path) {
  OsFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC), path);
  if (!file.is_open()) fail_errno(path, "open", errno);
  if (!S_ISREG(look(static_cast<int>(file.handle_), path).st_mode))
    fail(Code::io_error, path, ": not a regular file");
  return file;
}

OsFile OsFile::open_to_write(const std::string& path, const std::string& name) {
  constexpr mode_t everybody = 0666; // less the process's own mask
  OsFile file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, everybody), name);
  if (!file.is_open()) fail_errno(name, "create", errno);
  return file;
}

uint64_t OsFile::size() const {
  return static_cast<uint64_t>(look(static_cast<int>(handle_), name_).st_size);
}

size_t OsFile::read_at(uint64_t offset, std::span<std::byte> out) const {
  size_t done = 0;
  while (done < out.size()) {
    const auto n = ::pread(static_cast<int>(handle_), out.data() + done, out.size() - done,
                           static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_errno(name_, "read", errno);
    if (n == 0) break;
    done += static_cast<size_t>(n);
  }
  return done;
}

void OsFile::write_at(uint64_t offset, std::span<const std::byte> bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const auto n = ::pwrite(static_cast<int>(handle_), bytes.data() + done, bytes.size() - done,
                            static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_errno(name_, "write", errno);
    done += static_cast<size_t>(n);
  }
}

void OsFile::resize(uint64_t size, const char* doing) {
  if (::ftruncate(static_cast<int>(handle_), static_cast<off_t>(size)) != 0) fail_errno(name_, doing, errno);
}

void OsFile::make_durable() {
#ifdef __APPLE__
  if (::fcntl(static_cast<int>(handle_), F_FULLFSYNC) == 0) return; // fsync there leaves it in the drive
  if (::fsync(static_cast<int>(handle_)) != 0) fail_errno(name_, "write", errno);
#else
  if (::fdatasync(static_cast<int>(handle_)) != 0) fail_errno(name_, "write", errno);
#endif
}

bool OsFile::lock() {
  return ::flock(static_cast<int>(handle_), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

bool OsFile::is_at(const std::string& path) const {
  struct stat opened {
  }, named{};
  return ::fstat(static_cast<int>(handle_), &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

PathKind path_kind(const std::string& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return PathKind::nothing;
  return S_ISREG(info.st_mode) ? PathKind::file : S_ISDIR(info.st_mode) ? PathKind::folder : PathKind::other;
}

bool name_is_taken(const std::string& path) {
  struct stat info {};
  return ::lstat(path.c_str(), &info) == 0;
}

void remove_file(const std::string& path) noexcept { ::unlink(path.c_str()); }

void rename_file(const std::string& from, const std::string& to, OldFile old) {
  // link() refuses a name that appeared meanwhile; file systems without links fall back to rename.
  if (old == OldFile::refused) {
    if (::link(from.c_str(), to.c_str()) == 0) return remove_file(from);
    if (errno == EEXIST) fail_errno(to, "rename to", errno);
  }
  if (::rename(from.c_str(), to.c_str()) != 0) fail_errno(to, "rename to", errno);
}

} // namespace bccsplat

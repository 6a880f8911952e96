// SPDX-License-Identifier: Apache-2.0
// Files by Windows' calls. They are opened so that others may read, write, rename and remove them meanwhile,
// as POSIX has it.
#include "base/os/file.h"

#include <windows.h>

#include <winioctl.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/os/windows/wide.h"

namespace bccsplat {
namespace {

constexpr DWORD everything = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
constexpr DWORD low_bits = 32;
constexpr DWORD over_quota = 1295; // ERROR_DISK_QUOTA_EXCEEDED, which not every header has

Code code_of(DWORD error) {
  switch (error) {
  case ERROR_FILE_NOT_FOUND:
  case ERROR_PATH_NOT_FOUND:
  case ERROR_INVALID_NAME:
  case ERROR_BAD_PATHNAME:
    return Code::file_not_found;
  case ERROR_ACCESS_DENIED:
  case ERROR_SHARING_VIOLATION:
  case ERROR_WRITE_PROTECT:
    return Code::permission_denied;
  case ERROR_ALREADY_EXISTS:
  case ERROR_FILE_EXISTS:
    return Code::file_exists;
  case ERROR_DISK_FULL:
  case ERROR_HANDLE_DISK_FULL:
  case ERROR_FILE_TOO_LARGE:
  case over_quota:
    return Code::no_space;
  case ERROR_NOT_ENOUGH_MEMORY:
  case ERROR_OUTOFMEMORY:
    return Code::out_of_memory;
  default:
    return Code::io_error;
  }
}

[[noreturn]] void fail_windows(const std::string& path, const char* doing, DWORD error = GetLastError()) {
  const Code code = code_of(error);
  fail(code, path, ": cannot ", doing, ": ", windows_error_text(error),
       code == Code::no_space ? "; free some space or write elsewhere" : "");
}

HANDLE handle_of(intptr_t number) { return reinterpret_cast<HANDLE>(number); }
intptr_t number_of(HANDLE handle) { return reinterpret_cast<intptr_t>(handle); }
static_assert(sizeof(HANDLE) == sizeof(intptr_t));

OVERLAPPED place(uint64_t offset) {
  OVERLAPPED out{};
  out.Offset = static_cast<DWORD>(offset);
  out.OffsetHigh = static_cast<DWORD>(offset >> low_bits);
  return out;
}

// The most bytes of one call, whose counts have 32 bits.
DWORD piece(size_t left) { return static_cast<DWORD>(std::min<size_t>(left, size_t{1} << 30)); }

// Which file a handle is of.
struct Identity {
  DWORD volume = 0, high = 0, low = 0;
};
bool identify(HANDLE file, Identity& out) {
  BY_HANDLE_FILE_INFORMATION info{};
  if (!GetFileInformationByHandle(file, &info)) return false;
  out = {info.dwVolumeSerialNumber, info.nFileIndexHigh, info.nFileIndexLow};
  return true;
}

// A handle for one question.
class Opened {
 public:
  Opened(const std::string& path, DWORD access)
      : handle_(CreateFileW(to_wide_path(path).c_str(), access, everything, nullptr, OPEN_EXISTING,
                            FILE_FLAG_BACKUP_SEMANTICS, nullptr)) {}
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  ~Opened() {
    if (good()) CloseHandle(handle_);
  }
  [[nodiscard]] bool good() const { return handle_ != INVALID_HANDLE_VALUE; }
  [[nodiscard]] HANDLE get() const { return handle_; }

 private:
  HANDLE handle_;
};

// Windows 10's FILE_RENAME_INFO and its class, which headers of mingw-w64 10 hide behind a version that no
// system has.
struct PosixRename {
  DWORD flags = 3; // FILE_RENAME_FLAG_REPLACE_IF_EXISTS | FILE_RENAME_FLAG_POSIX_SEMANTICS
  HANDLE folder = nullptr;
  DWORD name_bytes = 0;
};
constexpr auto posix_rename = static_cast<FILE_INFO_BY_HANDLE_CLASS>(22);

// Renames as POSIX has it: a file of that name which readers have open stays theirs. Returns false where the
// system or the file system does not know this (before Windows 10, FAT).
bool renamed_over_open_file(const std::string& from, const std::string& to) {
  const Opened file(from, DELETE);
  if (!file.good()) return false;
  constexpr size_t name_at = offsetof(FILE_RENAME_INFO, FileName);
  const std::wstring name = to_wide_path(to);
  PosixRename head;
  head.name_bytes = static_cast<DWORD>(name.size() * sizeof(wchar_t));
  std::vector<std::byte> info(name_at + head.name_bytes + sizeof(wchar_t));
  std::memcpy(info.data(), &head, name_at);
  std::memcpy(info.data() + name_at, name.data(), head.name_bytes);
  return SetFileInformationByHandle(file.get(), posix_rename, info.data(), static_cast<DWORD>(info.size()));
}

} // namespace

void OsFile::close() {
  if (is_open()) CloseHandle(handle_of(std::exchange(handle_, closed)));
}

OsFile OsFile::open_to_read(const std::string& path) {
  if (path_kind(path) == PathKind::folder) fail(Code::io_error, path, ": not a regular file");
  OsFile file(number_of(CreateFileW(to_wide_path(path).c_str(), GENERIC_READ, everything, nullptr,
                                    OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr)),
              path);
  if (!file.is_open()) fail_windows(path, "open");
  if (GetFileType(handle_of(file.handle_)) != FILE_TYPE_DISK)
    fail(Code::io_error, path, ": not a regular file");
  return file;
}

OsFile OsFile::open_to_write(const std::string& path, const std::string& name) {
  OsFile file(number_of(CreateFileW(to_wide_path(path).c_str(), GENERIC_READ | GENERIC_WRITE, everything,
                                    nullptr, OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr)),
              name);
  if (!file.is_open()) fail_windows(name, "create");
  return file;
}

uint64_t OsFile::size() const {
  LARGE_INTEGER size{};
  if (!GetFileSizeEx(handle_of(handle_), &size)) fail_windows(name_, "read");
  return static_cast<uint64_t>(size.QuadPart);
}

size_t OsFile::read_at(uint64_t offset, std::span<std::byte> out) const {
  size_t done = 0;
  while (done < out.size()) {
    OVERLAPPED at = place(offset + done);
    DWORD n = 0;
    if (!ReadFile(handle_of(handle_), out.data() + done, piece(out.size() - done), &n, &at) &&
        GetLastError() != ERROR_HANDLE_EOF)
      fail_windows(name_, "read");
    if (n == 0) break;
    done += n;
  }
  return done;
}

void OsFile::write_at(uint64_t offset, std::span<const std::byte> bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    OVERLAPPED at = place(offset + done);
    DWORD n = 0;
    if (!WriteFile(handle_of(handle_), bytes.data() + done, piece(bytes.size() - done), &n, &at))
      fail_windows(name_, "write");
    done += n;
  }
}

void OsFile::resize(uint64_t size, const char* doing) {
  // Without it the zeros of an extension are written.
  DWORD ignored = 0;
  if (size > this->size())
    DeviceIoControl(handle_of(handle_), FSCTL_SET_SPARSE, nullptr, 0, nullptr, 0, &ignored, nullptr);
  FILE_END_OF_FILE_INFO end{};
  end.EndOfFile.QuadPart = static_cast<LONGLONG>(size);
  if (!SetFileInformationByHandle(handle_of(handle_), FileEndOfFileInfo, &end, sizeof end))
    fail_windows(name_, doing);
}

void OsFile::make_durable() {
  if (!FlushFileBuffers(handle_of(handle_))) fail_windows(name_, "write");
}

// Locks are of bytes, and keep readers from them: one that no file has stands for the whole.
bool OsFile::lock() {
  OVERLAPPED at = place(uint64_t{1} << 62);
  return LockFileEx(handle_of(handle_), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0, &at) ||
         GetLastError() != ERROR_LOCK_VIOLATION;
}

bool OsFile::is_at(const std::string& path) const {
  const Opened named(path, FILE_READ_ATTRIBUTES);
  Identity ours, theirs;
  return named.good() && identify(handle_of(handle_), ours) && identify(named.get(), theirs) &&
         ours.high == theirs.high && ours.low == theirs.low &&
         (ours.volume == theirs.volume || ours.volume == 0); // Wine forgets it when an open file is renamed
}

PathKind path_kind(const std::string& path) {
  const Opened file(path, FILE_READ_ATTRIBUTES);
  BY_HANDLE_FILE_INFORMATION info{};
  if (!file.good()) return PathKind::nothing;
  if (GetFileType(file.get()) != FILE_TYPE_DISK || !GetFileInformationByHandle(file.get(), &info))
    return PathKind::other;
  return info.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY ? PathKind::folder : PathKind::file;
}

bool name_is_taken(const std::string& path) {
  return GetFileAttributesW(to_wide_path(path).c_str()) != INVALID_FILE_ATTRIBUTES;
}

void remove_file(const std::string& path) noexcept { DeleteFileW(to_wide_path(path).c_str()); }

void rename_file(const std::string& from, const std::string& to, OldFile old) {
  if (old == OldFile::replaced && renamed_over_open_file(from, to)) return;
  const DWORD flags = old == OldFile::replaced ? MOVEFILE_REPLACE_EXISTING : 0;
  if (!MoveFileExW(to_wide_path(from).c_str(), to_wide_path(to).c_str(), flags))
    fail_windows(to, "rename to");
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Files as the operating system has them: opened, read and written by offset, locked, renamed. All that fails
// throws an Error with the path in its text. Paths are UTF-8 where the system has names of characters,
// otherwise its bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace bccsplat {

// What a path leads to, behind links.
enum class PathKind : uint8_t { nothing, file, folder, other };

class OsFile {
 public:
  OsFile() = default;
  OsFile(OsFile&& from) noexcept
      : handle_(std::exchange(from.handle_, closed)), name_(std::move(from.name_)) {}
  OsFile& operator=(OsFile&& from) noexcept {
    std::swap(handle_, from.handle_);
    std::swap(name_, from.name_);
    return *this;
  }
  OsFile(const OsFile&) = delete;
  OsFile& operator=(const OsFile&) = delete;
  ~OsFile() { close(); }

  // Opens a regular file that exists.
  [[nodiscard]] static OsFile open_to_read(const std::string& path);
  // Opens a file for reading and writing, made where there is none. Error texts call it `name`.
  [[nodiscard]] static OsFile open_to_write(const std::string& path, const std::string& name);
  [[nodiscard]] bool is_open() const { return handle_ != closed; }
  void close();

  [[nodiscard]] uint64_t size() const;
  // Returns how many bytes were read, fewer than asked for at the end of the file only.
  [[nodiscard]] size_t read_at(uint64_t offset, std::span<std::byte> out) const;
  void write_at(uint64_t offset, std::span<const std::byte> bytes);
  // Cuts the file, or extends it by zeros. `doing` is what the error text says could not be done.
  void resize(uint64_t size, const char* doing);
  // Everything written so far survives a crash once this returns.
  void make_durable();
  // Locks the file against other writers until it is closed; returns false where one of them has it.
  [[nodiscard]] bool lock();
  // Returns whether the path leads to this very file.
  [[nodiscard]] bool is_at(const std::string& path) const;

 private:
  using Handle = intptr_t; // a descriptor, or a HANDLE
  static constexpr Handle closed = -1;
  OsFile(Handle handle, std::string name) : handle_(handle), name_(std::move(name)) {}

  Handle handle_ = closed;
  std::string name_;
};

[[nodiscard]] PathKind path_kind(const std::string& path);
// Returns whether there is something of this name, be it a link that leads nowhere.
[[nodiscard]] bool name_is_taken(const std::string& path);
// Removes a file; one that cannot be removed stays.
void remove_file(const std::string& path) noexcept;
// Gives a file, open or not, its final name. One of that name is replaced in one step, or refused as
// file_exists.
enum class OldFile : uint8_t { replaced, refused };
void rename_file(const std::string& from, const std::string& to, OldFile old);

} // namespace bccsplat

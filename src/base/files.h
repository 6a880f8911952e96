// SPDX-License-Identifier: Apache-2.0
// Bytes by offset: files, memory and host streams. Files are opened nowhere else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bccsplat {

// Unwanted bytes between two wanted ones that cost less than another read of a file does.
inline constexpr uint64_t usual_merge_gap = 4 << 10;

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual uint64_t size() const = 0;
  // Fills `out` with the bytes at `offset`, or throws truncated / io_error, or WouldBlock where they are not
  // there yet. Concurrent calls are allowed.
  virtual void read_at(uint64_t offset, std::span<std::byte> out) const = 0;
  // Up to so many unwanted bytes between two wanted ones are read along.
  [[nodiscard]] virtual uint64_t merge_gap() const { return usual_merge_gap; }
  // Returns what the source is called in error texts.
  [[nodiscard]] virtual const std::string& name() const = 0;
};

[[nodiscard]] std::unique_ptr<ByteSource> open_file_source(const std::string& path);
// Sources over finished files, which may be more than a process may have open: about `open_at_once` of them
// are open, those read last, and one more for each thread that reads.
[[nodiscard]] std::vector<std::unique_ptr<ByteSource>>
open_file_sources(const std::vector<std::string>& paths, size_t open_at_once);
// Borrows the bytes: they must outlive the source.
[[nodiscard]] std::unique_ptr<ByteSource> open_memory_source(std::span<const std::byte> bytes);
// `read` returns the number of bytes read, short only at the end or on failure, or read_would_block.
inline constexpr int64_t read_would_block = -65536;
using ReadAt = std::function<int64_t(uint64_t offset, std::span<std::byte> out)>;
[[nodiscard]] std::unique_ptr<ByteSource> open_stream_source(uint64_t size, ReadAt read,
                                                             uint64_t merge_gap = usual_merge_gap,
                                                             std::string name = "stream");

class ByteSink {
 public:
  virtual ~ByteSink() = default;
  // Writes all of `bytes` at `offset`, extending the file, or throws no_space / io_error.
  virtual void write_at(uint64_t offset, std::span<const std::byte> bytes) = 0;
  // Everything written so far survives a crash once this returns.
  virtual void flush() = 0;
  // Ends the writing for good: a file gets its final name, a journal is removed. Without it the destructor
  // leaves what Partial says.
  virtual void commit() = 0;
};

// What becomes of the file under way when it is not committed, and of an old one that is there already.
enum class Partial : uint8_t {
  removed,   // nothing stays; an old one is overwritten
  kept,      // it stays; an old one is overwritten
  taken_over // it stays; writing goes on in an old one
};
// Writes to `path`.partial beside `path`; commit() renames it. An existing `path` is refused unless
// `overwrite`. No two sinks of one `path` may be open at once (Code::wrong_state).
[[nodiscard]] std::unique_ptr<ByteSink> create_file_sink(const std::string& path, bool overwrite,
                                                         Partial partial = Partial::removed);
// Writes to the file itself, cut to its first `keep` bytes; commit() removes it.
[[nodiscard]] std::unique_ptr<ByteSink> create_journal_sink(const std::string& path, uint64_t keep);
[[nodiscard]] bool file_exists(const std::string& path);
using WriteAt = std::function<int64_t(uint64_t offset, std::span<const std::byte> bytes)>;
// Returns whether all that was written is durable; may be empty.
using Flush = std::function<bool()>;
[[nodiscard]] std::unique_ptr<ByteSink> create_stream_sink(WriteAt write, Flush flush = {});
// Collects the bytes in `out`.
[[nodiscard]] std::unique_ptr<ByteSink> create_memory_sink(std::vector<std::byte>& out);

} // namespace bccsplat

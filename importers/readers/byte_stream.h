// SPDX-License-Identifier: Apache-2.0
// Files by offset, and the decoded bytes of encoded data as a stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "readers/value_type.h"

namespace bcc4 {

// A regular file, open for reading.
class InputFile {
 public:
  explicit InputFile(std::string path);
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] uint64_t size() const { return size_; }
  // Returns how many bytes were read: fewer than asked for only at the end of the file.
  [[nodiscard]] size_t read_some(uint64_t offset, std::span<std::byte> out);
  // Fills `out` or says at which offset the file ends.
  void read(uint64_t offset, std::span<std::byte> out);
  // Returns the offset behind `lines` line ends counted from `offset`.
  [[nodiscard]] uint64_t skip_lines(uint64_t offset, uint64_t lines);

 private:
  std::string path_;
  uint64_t size_ = 0;
  std::ifstream stream_;
};

// Returns the text of a small file; one of more than `limit` bytes is refused.
[[nodiscard]] std::string read_text_file(const std::string& path, uint64_t limit);
[[nodiscard]] uint64_t file_size(const std::string& path);
// Returns how many bytes deflate can make of `compressed` ones at most.
[[nodiscard]] uint64_t largest_inflated(uint64_t compressed);

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  // Reads the next bytes; fewer than asked for come only at the end.
  [[nodiscard]] virtual size_t read(std::span<std::byte> out) = 0;
};

enum class Encoding : uint8_t { raw, gzip, ascii };

// A run of decoded bytes held by one file.
struct Segment {
  std::string path;
  uint64_t offset = 0;  // in the file, where the encoded bytes begin
  uint64_t discard = 0; // decoded bytes to pass over first
  uint64_t bytes = 0;   // decoded bytes that count
  Encoding encoding = Encoding::raw;
  Type ascii_type = Type::f32; // numbers as text become this type, native byte order
  bool exact = false;          // more decoded bytes than `bytes` are an error
  uint64_t unread = 0;         // of these, the last that nobody will ask for: they need not be there
};

// Throws when its file is missing or cannot hold what it declares. It is called before anything is allocated
// by declared sizes.
void check_segment(const Segment& segment);

[[nodiscard]] std::unique_ptr<ByteStream> open_stream(const Segment& segment);

// Segments one after the other as one array of bytes. Encoded segments are cheap to read in rising order
// only.
class SegmentedBytes {
 public:
  // Throws when a file is missing or cannot hold what its segment declares.
  explicit SegmentedBytes(std::vector<Segment> segments);
  [[nodiscard]] uint64_t size() const { return begins_.back(); }
  void read(uint64_t offset, std::span<std::byte> out);
  // Returns the path of the segment that holds `offset`.
  [[nodiscard]] const std::string& path_at(uint64_t offset) const;

 private:
  [[nodiscard]] size_t segment_at(uint64_t offset) const;
  void read_encoded(size_t segment, uint64_t offset, std::span<std::byte> out);

  std::vector<Segment> segments_;
  std::vector<uint64_t> begins_; // of each segment, and the end
  size_t open_ = SIZE_MAX;       // segment of the open file or stream
  std::unique_ptr<InputFile> file_;
  std::unique_ptr<ByteStream> stream_;
  uint64_t position_ = 0; // decoded bytes taken from the open stream, without `discard`
};

} // namespace bcc4

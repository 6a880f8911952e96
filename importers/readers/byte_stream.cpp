// SPDX-License-Identifier: Apache-2.0
// Reads files by offset, and segments of encoded files as one array: encoded bytes are decoded from the
// beginning of their segment, so that reading back means to begin again.
#include "readers/byte_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "readers/decoders.h"
#include "readers/error.h"
#include "readers/system.h"

namespace bcc4 {
namespace fs = std::filesystem;

uint64_t file_size(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(to_path(path), error);
  if (!fs::exists(status)) fail_input(path, ": no such file");
  if (!fs::is_regular_file(status)) fail_input(path, ": not a regular file");
  const uint64_t size = fs::file_size(to_path(path), error);
  if (error) fail_input(path, ": ", error.message());
  return size;
}

InputFile::InputFile(std::string path) : path_(std::move(path)), size_(file_size(path_)) {
  errno = 0;
  stream_.open(to_path(path_), std::ios::binary);
  if (!stream_) fail_input(path_, ": cannot be read (", std::strerror(errno), ")");
}

size_t InputFile::read_some(uint64_t offset, std::span<std::byte> out) {
  if (offset >= size_ || out.empty()) return 0;
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(offset));
  stream_.read(reinterpret_cast<char*>(out.data()), out.size());
  if (stream_.bad()) fail_input(path_, ": read error at offset ", offset);
  return stream_.gcount();
}

void InputFile::read(uint64_t offset, std::span<std::byte> out) {
  const size_t got = read_some(offset, out);
  if (got != out.size())
    fail_input(path_, ": ends at offset ", offset + got, ", ", out.size() - got, " bytes too early");
}

uint64_t InputFile::skip_lines(uint64_t offset, uint64_t lines) {
  std::vector<std::byte> chunk(1 << 16);
  while (lines > 0) {
    const size_t got = read_some(offset, chunk);
    if (got == 0) fail_input(path_, ": ends before the data, ", lines, " lines to skip are missing");
    size_t i = 0;
    for (; i < got && lines > 0; ++i) lines -= chunk[i] == std::byte{'\n'};
    offset += i;
  }
  return offset;
}

std::string read_text_file(const std::string& path, uint64_t limit) {
  InputFile file(path);
  if (file.size() > limit) fail_input(path, ": ", file.size(), " bytes are too many for a text of this kind");
  std::string text(file.size(), '\0');
  file.read(0, std::as_writable_bytes(std::span(text)));
  return text;
}

uint64_t largest_inflated(uint64_t compressed) {
  return compressed > UINT64_MAX / 2048 ? UINT64_MAX : compressed * 1032 + 1024;
}

std::unique_ptr<ByteStream> open_stream(const Segment& segment) {
  auto file = std::make_unique<InputFile>(segment.path);
  switch (segment.encoding) {
  case Encoding::gzip:
    return open_gzip(std::move(file), segment.offset);
  case Encoding::ascii:
    return open_ascii(std::move(file), segment.offset, segment.ascii_type);
  case Encoding::raw:
    break;
  }
  fail_input(segment.path, ": not an encoded file");
}

void check_segment(const Segment& s) {
  const uint64_t size = file_size(s.path);
  const uint64_t held = size > s.offset ? size - s.offset : 0;
  const uint64_t all = s.bytes + s.discard, needed = all - s.unread;
  if (s.encoding == Encoding::raw && (held < needed || (s.exact && held > all)))
    fail_input(s.path, ": ", size, " bytes, but ", s.offset + s.discard, " (skipped) + ", s.bytes - s.unread,
               " (data) = ", s.offset + needed, " are expected");
  if (s.encoding == Encoding::gzip && needed > largest_inflated(held))
    fail_input(s.path, ": ", needed, " bytes of data are expected, but ", held,
               " compressed bytes cannot hold more than ", largest_inflated(held));
  if (s.encoding == Encoding::ascii && needed / type_size(s.ascii_type) > (held + 1) / 2)
    fail_input(s.path, ": ", needed / type_size(s.ascii_type), " numbers are expected, but ", held,
               " bytes of text cannot hold them");
}

SegmentedBytes::SegmentedBytes(std::vector<Segment> segments) : segments_(std::move(segments)) {
  uint64_t end = 0;
  for (const Segment& s : segments_) {
    begins_.push_back(end);
    end += s.bytes;
    check_segment(s);
  }
  begins_.push_back(end);
}

size_t SegmentedBytes::segment_at(uint64_t offset) const {
  const auto next = std::upper_bound(begins_.begin(), begins_.end() - 1, offset);
  return static_cast<size_t>(next - begins_.begin()) - 1;
}

const std::string& SegmentedBytes::path_at(uint64_t offset) const {
  return segments_[segment_at(offset)].path;
}

void SegmentedBytes::read(uint64_t offset, std::span<std::byte> out) {
  while (!out.empty()) {
    const size_t s = segment_at(offset);
    const uint64_t inside = offset - begins_[s];
    const Segment& segment = segments_[s];
    if (inside >= segment.bytes) fail_input(segment.path, ": data end at byte ", begins_.back());
    const auto piece = out.first(std::min<uint64_t>(out.size(), segment.bytes - inside));
    if (segment.encoding == Encoding::raw) {
      if (open_ != s) file_ = std::make_unique<InputFile>(segment.path);
      open_ = s;
      file_->read(segment.offset + segment.discard + inside, piece);
    } else {
      read_encoded(s, inside, piece);
    }
    out = out.subspan(piece.size());
    offset += piece.size();
  }
}

void SegmentedBytes::read_encoded(size_t s, uint64_t offset, std::span<std::byte> out) {
  const Segment& segment = segments_[s];
  std::vector<std::byte> passed;
  const auto take = [&](std::span<std::byte> into) {
    const size_t got = stream_->read(into);
    if (got != into.size())
      fail_input(segment.path, ": ", segment.discard + position_ + got, " bytes of data, but ",
                 segment.discard + segment.bytes, " are expected");
  };
  const auto pass = [&](uint64_t bytes) {
    passed.resize(std::min<uint64_t>(bytes, 1 << 18));
    for (; bytes > 0; bytes -= std::min<uint64_t>(bytes, passed.size()))
      take(std::span(passed).first(std::min<uint64_t>(bytes, passed.size())));
  };
  if (open_ != s || !stream_ || position_ > offset) {
    stream_ = open_stream(segment);
    open_ = s;
    position_ = 0;
    pass(segment.discard);
  }
  pass(offset - position_);
  position_ = offset;
  take(out);
  position_ += out.size();
  if (position_ == segment.bytes) { // reading on checks the trailer of the stream, too
    std::byte beyond{};
    const size_t more = stream_->read(std::span(&beyond, 1));
    if (more != 0 && segment.exact)
      fail_input(segment.path, ": more than the ", segment.discard + segment.bytes,
                 " bytes of data expected");
    stream_.reset();
  }
}

} // namespace bcc4

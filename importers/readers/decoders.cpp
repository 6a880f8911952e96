// SPDX-License-Identifier: Apache-2.0
// Decodes gzip and zlib by zlib, piece by piece or a block at once, and numbers written as text.
#include "readers/decoders.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "readers/error.h"

namespace bcc4 {
namespace {

class GzipStream : public ByteStream {
 public:
  GzipStream(std::unique_ptr<InputFile> file, uint64_t offset)
      : file_(std::move(file)), offset_(offset), in_(1 << 16) {
    if (inflateInit2(&z_, 15 + 32) != Z_OK) fail_resources(file_->path(), ": no memory to decompress it");
  }
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;
  ~GzipStream() override { inflateEnd(&z_); }

  size_t read(std::span<std::byte> out) override {
    size_t done = 0;
    while (done < out.size() && !ended_) {
      if (z_.avail_in == 0 && !refill()) {
        if (between_members_) break;
        fail_input(file_->path(), ": the compressed data end too early, at offset ", offset_);
      }
      between_members_ = false;
      const auto room = static_cast<uInt>(std::min<size_t>(out.size() - done, 1u << 30));
      z_.next_out = reinterpret_cast<Bytef*>(out.data() + done);
      z_.avail_out = room;
      const int result = inflate(&z_, Z_NO_FLUSH);
      done += room - z_.avail_out;
      if (result == Z_STREAM_END)
        next_member();
      else if (result == Z_MEM_ERROR)
        fail_resources(file_->path(), ": no memory to decompress it");
      else if (result != Z_OK && result != Z_BUF_ERROR)
        fail_input(file_->path(), ": damaged compressed data near offset ", offset_ - z_.avail_in, " (",
                   z_.msg ? z_.msg : "not gzip", ")");
    }
    return done;
  }

 private:
  bool refill() {
    const size_t got = file_->read_some(offset_, in_);
    offset_ += got;
    z_.next_in = reinterpret_cast<Bytef*>(in_.data());
    z_.avail_in = static_cast<uInt>(got);
    return got > 0;
  }

  // Another gzip member may follow; what is no member (padding) ends the data.
  void next_member() {
    between_members_ = true;
    if ((z_.avail_in == 0 && !refill()) || *z_.next_in != 0x1f)
      ended_ = true;
    else
      inflateReset(&z_);
  }

  std::unique_ptr<InputFile> file_;
  uint64_t offset_;
  std::vector<std::byte> in_;
  z_stream z_{};
  bool between_members_ = false;
  bool ended_ = false;
};

class AsciiStream : public ByteStream {
 public:
  AsciiStream(std::unique_ptr<InputFile> file, uint64_t offset, Type type)
      : file_(std::move(file)), offset_(offset), type_(type), in_(1 << 16) {}

  size_t read(std::span<std::byte> out) override {
    size_t done = 0;
    while (done < out.size()) {
      if (left_ == 0 && !next_value()) break;
      const size_t size = type_size(type_);
      const size_t piece = std::min(left_, out.size() - done);
      std::memcpy(out.data() + done, value_ + (size - left_), piece);
      done += piece;
      left_ -= piece;
    }
    return done;
  }

 private:
  static bool separates(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }

  bool next_char(char& c) {
    if (next_ == end_) {
      end_ = file_->read_some(offset_, in_);
      offset_ += end_;
      next_ = 0;
      if (end_ == 0) return false;
    }
    c = static_cast<char>(in_[next_++]);
    return true;
  }

  bool next_value() {
    std::string word;
    for (char c = 0; next_char(c);) {
      if (!separates(c))
        word += c;
      else if (!word.empty())
        break;
      if (word.size() > 64) break;
    }
    if (word.empty()) return false;
    if (!parse_value(word, type_, value_))
      fail_input(file_->path(), ": \"", word.substr(0, 64), "\" before offset ", offset_ - (end_ - next_),
                 " is no ", type_name(type_), " number");
    left_ = type_size(type_);
    return true;
  }

  std::unique_ptr<InputFile> file_;
  uint64_t offset_;
  Type type_;
  std::vector<std::byte> in_;
  size_t next_ = 0, end_ = 0;
  std::byte value_[8]{};
  size_t left_ = 0; // bytes of value_ not handed out yet
};

} // namespace

std::unique_ptr<ByteStream> open_gzip(std::unique_ptr<InputFile> file, uint64_t offset) {
  return std::make_unique<GzipStream>(std::move(file), offset);
}

std::unique_ptr<ByteStream> open_ascii(std::unique_ptr<InputFile> file, uint64_t offset, Type type) {
  return std::make_unique<AsciiStream>(std::move(file), offset, type);
}

FileStart read_start(const std::string& path, size_t count) {
  auto file = std::make_unique<InputFile>(path);
  FileStart start{std::string(count, '\0')};
  start.bytes.resize(file->read_some(0, std::as_writable_bytes(std::span(start.bytes))));
  start.gzip = start.bytes.starts_with("\x1f\x8b");
  if (!start.gzip) return start;
  start.bytes.assign(count, '\0');
  start.bytes.resize(open_gzip(std::move(file), 0)->read(std::as_writable_bytes(std::span(start.bytes))));
  return start;
}

bool inflate_block(std::span<const std::byte> compressed, std::span<std::byte> out) {
  uLongf size = static_cast<uLongf>(out.size());
  return uncompress(reinterpret_cast<Bytef*>(out.data()), &size,
                    reinterpret_cast<const Bytef*>(compressed.data()),
                    static_cast<uLong>(compressed.size())) == Z_OK &&
         size == out.size();
}

bool parse_value(std::string_view text, Type type, std::byte* to) {
  return visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_same_v<T, Half>) {
      return false;
    } else {
      const auto number = parse_number<T>(text);
      if (number) std::memcpy(to, &*number, sizeof *number);
      return number.has_value();
    }
  });
}

} // namespace bcc4

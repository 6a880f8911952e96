// SPDX-License-Identifier: Apache-2.0
// A little-endian byte cursor, each of whose reads is checked against the bytes present.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/error.h"

namespace bccsplat {

static_assert(std::endian::native == std::endian::little,
              "a big-endian host needs byte swaps in base/bytes.h");

class ByteReader {
 public:
  // `what` names the record in error texts; `offset` is where the bytes start in the file.
  ByteReader(std::span<const std::byte> bytes, std::string_view what, uint64_t offset = 0)
      : bytes_(bytes), what_(what), offset_(offset) {}

  [[nodiscard]] size_t position() const { return position_; }
  [[nodiscard]] size_t remaining() const { return bytes_.size() - position_; }

  template<class T>
  requires std::is_arithmetic_v<T>
  [[nodiscard]] T read() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }

  [[nodiscard]] std::span<const std::byte> take(uint64_t count) {
    if (count > remaining())
      fail(Code::truncated, what_, " at offset ", offset_ + position_, " needs ", count, " bytes, ",
           remaining(), " are left");
    const auto part = bytes_.subspan(position_, count);
    position_ += count;
    return part;
  }

  // LEB128, at most 10 bytes, shortest form only.
  [[nodiscard]] uint64_t read_varint() {
    if (position_ < bytes_.size() && static_cast<uint8_t>(bytes_[position_]) < 0x80)
      return static_cast<uint8_t>(bytes_[position_++]);
    return read_long_varint();
  }

  // Length-prefixed UTF-8, at most `limit` bytes.
  [[nodiscard]] std::string read_string(uint64_t limit) {
    const auto length = read<uint32_t>();
    if (length > limit) fail(Code::limit_exceeded, what_, ": text of ", length, " bytes, limit ", limit);
    const auto part = take(length);
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }

  void expect_end() const {
    if (remaining() != 0)
      fail(Code::corrupt, what_, " at offset ", offset_ + position_, ": ", remaining(), " bytes too many");
  }

 private:
  [[nodiscard]] uint64_t read_long_varint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = read<uint8_t>();
      if (shift == 63 && byte > 1) break;
      value |= static_cast<uint64_t>(byte & 0x7f) << shift;
      if (!(byte & 0x80)) {
        if (byte == 0 && shift > 0) break;
        return value;
      }
    }
    fail(Code::corrupt, what_, " at offset ", offset_ + position_, ": bad variable-length integer");
  }

  std::span<const std::byte> bytes_;
  std::string_view what_;
  uint64_t offset_;
  size_t position_ = 0;
};

class ByteWriter {
 public:
  template<class T>
  requires std::is_arithmetic_v<T>
  void write(T value) {
    const auto* p = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), p, p + sizeof(T));
  }
  void write_bytes(std::span<const std::byte> part) { bytes_.insert(bytes_.end(), part.begin(), part.end()); }
  void write_varint(uint64_t value) {
    while (value >= 0x80) {
      write(static_cast<uint8_t>(value | 0x80));
      value >>= 7;
    }
    write(static_cast<uint8_t>(value));
  }
  void write_string(std::string_view text) {
    write(static_cast<uint32_t>(text.size()));
    write_bytes(std::as_bytes(std::span<const char>(text.data(), text.size())));
  }

  [[nodiscard]] size_t size() const { return bytes_.size(); }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  [[nodiscard]] std::vector<std::byte> release() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

} // namespace bccsplat

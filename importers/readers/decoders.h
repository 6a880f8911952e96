// SPDX-License-Identifier: Apache-2.0
// Streams of decoded bytes: gzip and zlib, zlib blocks in memory, numbers as text.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "readers/byte_stream.h"

namespace bcc4 {

// Opens gzip members (one or more) or a zlib stream, from `offset` to the end of the file. Damage is an error
// with its offset.
[[nodiscard]] std::unique_ptr<ByteStream> open_gzip(std::unique_ptr<InputFile> file, uint64_t offset);
// Opens numbers separated by white space or commas.
[[nodiscard]] std::unique_ptr<ByteStream> open_ascii(std::unique_ptr<InputFile> file, uint64_t offset,
                                                     Type type);

// The first bytes of a file, unpacked when it is gzip; fewer than asked for only where it ends.
struct FileStart {
  std::string bytes{};
  bool gzip = false;
};
[[nodiscard]] FileStart read_start(const std::string& path, size_t count);

// Unpacks one zlib stream of exactly out.size() bytes; returns false when it is damaged or of another size.
[[nodiscard]] bool inflate_block(std::span<const std::byte> compressed, std::span<std::byte> out);
// Writes `text` as a number of `type` to `to`; returns false when it is none or does not fit.
[[nodiscard]] bool parse_value(std::string_view text, Type type, std::byte* to);

} // namespace bcc4

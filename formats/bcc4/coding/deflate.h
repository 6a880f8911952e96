// SPDX-License-Identifier: Apache-2.0
// Raw deflate streams (RFC 1951) and CRC-32 (ISO-HDLC, as in zlib and PNG).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/progress.h"

namespace bccsplat {

enum class DeflateKind {
  text,  // repeats matter
  noise, // prediction residuals: mostly their frequencies matter, and runs of zeros
};

// From this level on every way to code is tried, below it the ways are compared by estimates: files differ by
// less than 0.05 %, and coding takes 0.5 to 0.95 of the time (tests/bench/notes/storage.md).
inline constexpr int exhaustive_level = 7;

// Returns the smallest stream found. `level` is 1 .. 9. The stream is the same on every machine with the same
// zlib. With progress it throws Code::cancelled soon after a cancel.
[[nodiscard]] std::vector<std::byte> deflate_bytes(std::span<const std::byte> bytes, int level,
                                                   DeflateKind kind, Progress* progress = nullptr);
// Returns one stream of noise whose parts, which end at `ends` (rising, the last one at the end of all
// bytes), are each uniform but differ from one another, as byte planes do. Each part gets blocks of its own,
// stored where coding would save next to nothing, so that they cost no time to decode.
[[nodiscard]] std::vector<std::byte> deflate_parts(std::span<const std::byte> bytes,
                                                   std::span<const size_t> ends, int level);
// Inflates any number of streams, one after the other, with one set of tables.
class Inflater {
 public:
  Inflater();
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  // Fills `out`; returns false unless `bytes` is one whole stream of exactly that size.
  [[nodiscard]] bool inflate(std::span<const std::byte> bytes, std::span<std::byte> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};
// Inflates a single stream in the same way.
[[nodiscard]] bool inflate_bytes(std::span<const std::byte> bytes, std::span<std::byte> out);

[[nodiscard]] uint32_t crc32_of(std::span<const std::byte> bytes);

} // namespace bccsplat

// Raw deflate streams (RFC 1951) and CRC-32 (ISO-HDLC, as in zlib and PNG).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace bccsplat {

enum class DeflateKind {
  text,  // repeats matter
  noise, // prediction residuals: mostly their frequencies matter, and runs of zeros
};

// The smallest stream found; level 1 .. 9: up to 6 the ways to code noise are compared by estimates, from 7
// on they are all gone. Equal on every machine with the same zlib.
[[nodiscard]] std::vector<std::byte> deflate_bytes(std::span<const std::byte> bytes, int level,
                                                   DeflateKind kind);
// One stream of noise whose parts, which end at `ends` (rising, the last one at the end of all bytes), are
// alike within and unlike each other, as byte planes are: each gets blocks of its own, stored where coding
// would save next to nothing, so that it costs no time to decode.
[[nodiscard]] std::vector<std::byte> deflate_parts(std::span<const std::byte> bytes,
                                                   std::span<const size_t> ends, int level);
// What inflating needs beside the bytes, for any number of streams, one after the other.
class Inflater {
 public:
  Inflater();
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  // Fills `out`; false unless `bytes` is one whole stream of exactly that size.
  [[nodiscard]] bool inflate(std::span<const std::byte> bytes, std::span<std::byte> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};
// Of a single stream.
[[nodiscard]] bool inflate_bytes(std::span<const std::byte> bytes, std::span<std::byte> out);

[[nodiscard]] uint32_t crc32_of(std::span<const std::byte> bytes);

} // namespace bccsplat

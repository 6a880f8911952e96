// SPDX-License-Identifier: Apache-2.0
// Deflates with zlib, by the strategy that suits the bytes. Inflates with libdeflate where it is there.
#include "formats/bcc4/coding/deflate.h"

#include <zlib.h>

#include <algorithm>
#include <climits>
#include <memory>
#include <new>
#include <utility>

#if BCCSPLAT_WITH_LIBDEFLATE
#include <libdeflate.h>
#endif

#include "base/error.h"
#include "formats/bcc4/coding/entropy.h"

namespace bccsplat {
namespace {

// Parts that coding shrinks by less than 1/64 are stored. With 1/16 decoding f32 takes 0.97 of the time for
// 0.3 % of size and u16 0.99 for 0.6 %, with 1/8 0.90 and 0.88 for 1 and 5 % (tests/bench/notes/storage.md).
constexpr size_t least_saved = 64;
constexpr uint64_t table_bytes = 60; // about what the Huffman codes of a block take
// Handed to zlib at a time where a caller may cancel: the slowest strategy takes 10 ms for 32 KiB of
// corrections. The stream is the same.
constexpr size_t piece_bytes = size_t{1} << 12;

[[nodiscard]] std::vector<std::byte> deflate_with(std::span<const std::byte> bytes, int level, int strategy,
                                                  Progress* progress = nullptr) {
  if (bytes.size() > UINT_MAX / 2)
    fail(Code::limit_exceeded, "deflate: ", bytes.size(), " bytes in one piece");
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, -15, 8, strategy) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, deflateEnd);
  std::vector<std::byte> out(deflateBound(&stream, static_cast<uLong>(bytes.size())));
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  size_t left = bytes.size();
  while (progress && left > piece_bytes) {
    progress->check();
    stream.avail_in = piece_bytes;
    left -= piece_bytes;
    if (deflate(&stream, Z_NO_FLUSH) != Z_OK || stream.avail_in != 0)
      fail(Code::internal, "deflate: a piece did not fit");
  }
  stream.avail_in = static_cast<uInt>(left);
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) fail(Code::internal, "deflate: no end of stream");
  out.resize(stream.total_out);
  return out;
}

// How a part is coded: by the frequencies of its bytes, with run lengths as well, or not at all.
struct PartPlan {
  int level, strategy;
  bool operator==(const PartPlan&) const = default;
};
[[nodiscard]] PartPlan plan_part(std::span<const std::byte> part, int level) {
  uint64_t runs, frequencies; // bytes
  if (level >= exhaustive_level) {
    runs = deflate_with(part, level, Z_RLE).size();
    frequencies = deflate_with(part, level, Z_HUFFMAN_ONLY).size();
  } else {
    const DeflateBits bits = deflate_bits(part);
    runs = bits.with_runs_256 / (8 * 256) + table_bytes;
    frequencies = bits.alone_256 / (8 * 256) + table_bytes;
  }
  if (std::min(runs, frequencies) > part.size() - part.size() / least_saved) return {0, Z_DEFAULT_STRATEGY};
  return {level, runs < frequencies ? Z_RLE : Z_HUFFMAN_ONLY};
}

} // namespace

std::vector<std::byte> deflate_parts(std::span<const std::byte> bytes, std::span<const size_t> ends,
                                     int level) {
  if (bytes.size() > UINT_MAX / 2)
    fail(Code::limit_exceeded, "deflate: ", bytes.size(), " bytes in one piece");
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, -15, 8, Z_HUFFMAN_ONLY) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, deflateEnd);
  // deflateBound is for one part; the others have room for their block ends.
  std::vector<std::byte> out(deflateBound(&stream, static_cast<uLong>(bytes.size())) + 64 * ends.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  size_t begin = 0;
  for (const size_t end : ends) {
    const auto part = bytes.subspan(begin, end - begin);
    const PartPlan plan = plan_part(part, level);
    if (deflateParams(&stream, plan.level, plan.strategy) != Z_OK)
      fail(Code::internal, "deflate: no change of strategy");
    stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(part.data()));
    stream.avail_in = static_cast<uInt>(part.size());
    const bool last = end == bytes.size();
    const int result = deflate(&stream, last ? Z_FINISH : Z_BLOCK);
    if (result != (last ? Z_STREAM_END : Z_OK) || stream.avail_in != 0)
      fail(Code::internal, "deflate: a part did not fit");
    begin = end;
  }
  out.resize(stream.total_out);
  return out;
}

std::vector<std::byte> deflate_bytes(std::span<const std::byte> bytes, int level, DeflateKind kind,
                                     Progress* progress) {
  if (kind == DeflateKind::text) return deflate_with(bytes, level, Z_DEFAULT_STRATEGY, progress);
  // Matches that noise offers by chance cost more than they save, so that entropy coding alone often wins,
  // and it is fast.
  if (level < exhaustive_level) {
    const DeflateBits bits = deflate_bits(bytes);
    return deflate_with(bytes, level, bits.with_runs_256 < bits.alone_256 ? Z_RLE : Z_HUFFMAN_ONLY, progress);
  }
  std::vector<std::byte> best = deflate_with(bytes, level, Z_RLE, progress);
  const auto keep_smaller = [&best](std::vector<std::byte> other) {
    if (other.size() < best.size()) best = std::move(other);
  };
  keep_smaller(deflate_with(bytes, level, Z_HUFFMAN_ONLY, progress));
  keep_smaller(deflate_with(bytes, level, Z_FILTERED, progress));
  return best;
}

#if BCCSPLAT_WITH_LIBDEFLATE

struct Inflater::State {
  std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflater{
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor};
  State() {
    if (!inflater) throw std::bad_alloc();
  }

  bool inflate(std::span<const std::byte> bytes, std::span<std::byte> out) {
    size_t taken = 0, made = 0;
    return libdeflate_deflate_decompress_ex(inflater.get(), bytes.data(), bytes.size(), out.data(),
                                            out.size(), &taken, &made) == LIBDEFLATE_SUCCESS &&
           taken == bytes.size() && made == out.size();
  }
};

uint32_t crc32_of(std::span<const std::byte> bytes) {
  return libdeflate_crc32(0, bytes.data(), bytes.size());
}

#else

struct Inflater::State {
  z_stream stream{};
  State() {
    if (inflateInit2(&stream, -15) != Z_OK) throw std::bad_alloc();
  }
  ~State() { inflateEnd(&stream); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  bool inflate(std::span<const std::byte> bytes, std::span<std::byte> out) {
    if (bytes.size() > UINT_MAX || out.size() > UINT_MAX) return false;
    if (::inflateReset(&stream) != Z_OK) fail(Code::internal, "inflate: no new stream");
    std::byte none{}; // zlib wants a place even for no output
    stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.empty() ? &none : out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    const int result = ::inflate(&stream, Z_FINISH);
    if (result == Z_MEM_ERROR) throw std::bad_alloc();
    return result == Z_STREAM_END && stream.avail_in == 0 && stream.avail_out == 0;
  }
};

uint32_t crc32_of(std::span<const std::byte> bytes) {
  return static_cast<uint32_t>(::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

#endif

Inflater::Inflater() : state_(std::make_unique<State>()) {}
Inflater::~Inflater() = default;

bool Inflater::inflate(std::span<const std::byte> bytes, std::span<std::byte> out) {
  return state_->inflate(bytes, out);
}

bool inflate_bytes(std::span<const std::byte> bytes, std::span<std::byte> out) {
  return Inflater().inflate(bytes, out);
}

} // namespace bccsplat

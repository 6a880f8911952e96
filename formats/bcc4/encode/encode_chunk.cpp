// SPDX-License-Identifier: Apache-2.0
// Codes one chunk: run lists of its kept sites and holes, and its codes by the predictor that promises the
// fewest bits.
#include "formats/bcc4/encode/encode_chunk.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/encode/choose_predictor.h"
#include "points/runs.h"

namespace bccsplat {
namespace {

// Chunks of fewer codes than that are also tried as one stream; larger ones only from exhaustive_level on.
constexpr size_t few_codes = 1024;

[[nodiscard]] std::vector<std::byte> write_runs(const ChunkSites& sites) {
  ByteWriter out;
  RunEncoder occupancy(out);
  for_rows(sites.shape, [&](size_t m, size_t r, int width) { occupancy.row(sites.kept[m][r], width); });
  occupancy.finish();
  if (!sites.hole.empty()) {
    RunEncoder holes(out);
    for_rows(sites.shape, [&](size_t m, size_t r, int) {
      const uint16_t kept = sites.kept[m][r];
      holes.row(compress_bits(sites.hole[m][r], kept), std::popcount(kept));
    });
    holes.finish();
  }
  return out.release();
}

// Writes all lowest bytes, then all second bytes, and so on.
void write_planes(ByteWriter& out, std::span<const uint32_t> values, uint32_t bytes) {
  std::vector<std::byte> plane(values.size());
  for (uint32_t b = 0; b < bytes; ++b) {
    for (size_t i = 0; i < values.size(); ++i) plane[i] = static_cast<std::byte>(values[i] >> (8 * b));
    out.write_bytes(plane);
  }
}

[[nodiscard]] std::array<uint32_t, 2> range_of(std::span<const uint32_t> codes) {
  uint32_t low = UINT32_MAX, high = 0;
  for (const uint32_t c : codes) low = std::min(low, c), high = std::max(high, c);
  return {low, high};
}

struct CodedValues {
  uint8_t coding = raw_part, predictor = 0;
  std::vector<std::byte> bytes;
};

// Codes as they are, without prediction.
[[nodiscard]] std::vector<std::byte> write_patterns(std::span<const uint32_t> values,
                                                    const ChunkCodes& codes) {
  const size_t bytes = codes.bytes();
  std::vector<std::byte> out(values.size() * bytes);
  if (bytes == 1) {
    for (size_t i = 0; i < values.size(); ++i) out[i] = static_cast<std::byte>(values[i]);
    return out;
  }
  for (size_t i = 0; i < values.size(); ++i) {
    const uint32_t p = pattern_of(values[i], codes);
    std::memcpy(out.data() + i * bytes, &p, bytes);
  }
  return out;
}

[[nodiscard]] CodedValues write_values(const ChunkSites& sites, const ChunkCodes& codes, int level) {
  CodedValues best;
  const size_t raw_bytes = sites.codes.size() * codes.bytes();
  const auto keep_smaller = [&](Predictor predictor, std::vector<std::byte> stream) {
    if (stream.size() < (best.coding == raw_part ? raw_bytes : best.bytes.size()))
      best = {deflated_part, static_cast<uint8_t>(predictor), std::move(stream)};
  };
  const auto planes_of = [&](std::span<const int16_t> weights, std::span<const uint32_t> residuals) {
    ByteWriter planes;
    planes.write_bytes(std::as_bytes(weights));
    write_planes(planes, residuals, codes.bytes());
    return planes.release();
  };
  if (level > 0) {
    // The predictor of the lowest estimate is coded. Unpredicted codes are coded as well, as values may
    // repeat.
    const Choice choice = choose_predictor(sites, codes, level);
    const std::vector<std::byte> planes = planes_of(choice.weights, choice.residuals);
    // One stream for all planes is smaller only where the tables of separate ones outweigh what they save.
    if (codes.bytes() == 1 || sites.codes.size() < few_codes || level >= exhaustive_level)
      keep_smaller(choice.predictor, deflate_bytes(planes, level, DeflateKind::noise));
    std::vector<size_t> ends;
    for (size_t b = 1; b <= codes.bytes(); ++b)
      ends.push_back(choice.weights.size() * sizeof(int16_t) + b * sites.codes.size());
    if (ends.size() > 1) keep_smaller(choice.predictor, deflate_parts(planes, ends, level));
    if (level >= exhaustive_level)
      keep_smaller(Predictor::none, deflate_bytes(planes_of({}, sites.codes), level, DeflateKind::text));
  }
  if (best.coding == raw_part) best.bytes = write_patterns(sites.codes, codes);
  return best;
}

} // namespace

void keep_scattered_air(ChunkSites& sites, const ChunkCodes& codes) {
  // A gap costs 9.7 bits and a sample 5.4 (tests/bench/notes/storage.md), so that gaps of up to 1.25 sites in
  // the mean are filled. Fewer than 16 gaps do not matter; where more than 1/8 of the sites are air it is not
  // scattered.
  constexpr uint64_t least_gaps = 16, most_share = 8;
  const uint64_t all = sites.shape.sites(), missing = all - sites.codes.size();
  if (codes.bytes() > 1 || !sites.hole.empty() || missing < least_gaps || missing > all / most_share) return;
  uint64_t gaps = 0;
  bool before = true;
  for_rows(sites.shape, [&](size_t m, size_t r, int width) {
    for (int x = 0; x < width; ++x) {
      const bool kept = sites.kept[m][r] >> x & 1;
      gaps += before && !kept;
      before = kept;
    }
  });
  if (gaps < least_gaps || 4 * missing > 5 * gaps) return;
  std::vector<uint32_t> filled;
  filled.reserve(all);
  const uint32_t* next = sites.codes.data();
  for_rows(sites.shape, [&](size_t m, size_t r, int width) {
    for (int x = 0; x < width; ++x) filled.push_back(sites.kept[m][r] >> x & 1 ? *next++ : codes.air);
    sites.kept[m][r] = static_cast<uint16_t>((1u << width) - 1);
  });
  sites.codes = std::move(filled);
}

EncodedChunk encode_chunk(const ChunkSites& sites, const ChunkCodes& codes, int level) {
  EncodedChunk chunk;
  Bcc4Chunk& entry = chunk.entry;
  entry.kept = static_cast<uint32_t>(sites.codes.size());
  entry.holes = sites.holes();
  const auto [low, high] = range_of(sites.codes);
  entry.min_code = low;
  entry.max_code = high;
  CodedValues values = write_values(sites, codes, level);
  entry.values_bytes = static_cast<uint32_t>(values.bytes.size());
  entry.predictor = values.predictor;
  chunk.bytes = std::move(values.bytes);
  finish_entry(pack_runs(write_runs(sites), level), values.coding, chunk);
  return chunk;
}

} // namespace bccsplat

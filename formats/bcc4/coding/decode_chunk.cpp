// SPDX-License-Identifier: Apache-2.0
// Decodes one chunk, whole or as far as its first layers, and goes on where it stopped. The checksum and the
// runs are those of the whole chunk either way, and codes that lie outside the range that the index tells are
// refused; that the range is the chunk's own is checked when its last layer has been decoded.
#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/predict.h"
#include "formats/bcc4/coding/range.h"
#include "formats/bcc4/coding/restore_cells.h"
#include "formats/bcc4/coding/scratch.h"
#include "points/runs.h"

namespace bccsplat {
namespace {

// Reads the masks of all layers from the rows inside the domain, in coding order.
void read_masks(const ChunkShape& shape, RunDecoder& runs, std::vector<BrickMask>& masks) {
  masks.assign(shape.layers, BrickMask{});
  for (size_t m = 0; m < masks.size(); ++m) {
    const auto [nx, ny, nz] = shape.box[m];
    const auto rows = std::span(masks[m]);
    if (nx == brick_edge && ny == brick_edge) {
      runs.fill(rows.first(static_cast<size_t>(nz) * brick_edge));
      continue;
    }
    for (int z = 0; z < nz; ++z) {
      if (runs.skip(static_cast<uint64_t>(nx) * ny)) continue;
      for (int y = 0; y < ny; ++y) rows[z * brick_edge + y] = runs.row(nx);
    }
  }
  runs.finish();
}

void read_runs(ChunkData& data, const Bcc4Chunk& parts, std::span<const std::byte> bytes,
               std::string_view what, uint64_t offset) {
  ByteReader in(bytes, what, offset);
  RunDecoder occupancy(in, data.shape.sites(), parts.kept);
  read_masks(data.shape, occupancy, data.kept);
  if (parts.holes > 0) {
    RunDecoder holes(in, parts.kept, parts.holes);
    data.hole.assign(data.kept.size(), BrickMask{});
    for_rows(data.shape, [&](size_t m, size_t r, int) {
      const uint16_t kept = data.kept[m][r];
      data.hole[m][r] = expand_bits(holes.row(std::popcount(kept)), kept);
    });
    holes.finish();
  }
  in.expect_end();
}

[[nodiscard]] uint8_t values_coding(const Bcc4Chunk& entry) { return entry.coding & 15; }
[[nodiscard]] Predictor predictor_of(const Bcc4Chunk& entry) {
  return static_cast<Predictor>(entry.predictor);
}

void copy_raw(std::span<const std::byte> bytes, const ChunkCodes& codes, std::byte* packed) {
  if (!is_float(codes.type)) {
    std::copy(bytes.begin(), bytes.end(), packed);
    return;
  }
  for (size_t i = 0; i < bytes.size(); i += codes.bytes()) {
    uint32_t p = 0;
    std::memcpy(&p, bytes.data() + i, codes.bytes());
    p = code_of(p, codes);
    std::memcpy(packed + i, &p, codes.bytes());
  }
}

// Decodes the codes of these layers from the values part; data.first tells of all layers.
void read_values(ChunkData& data, const Bcc4Chunk& entry, std::span<const std::byte> part,
                 const WalkedLayers& layers, ChunkScratch& scratch) {
  const ChunkCodes& codes = data.coded;
  const Predictor predictor = predictor_of(entry);
  const size_t weight_bytes =
      predictor == Predictor::fitted ? fitted_weights(data.shape) * sizeof(int16_t) : 0;
  const size_t plane_bytes = size_t{entry.kept} * codes.bytes(),
               end = size_t{data.first[layers.end]} * codes.bytes(),
               begin = layers.codes_before * codes.bytes();
  const auto bytes = open_part(part, values_coding(entry), weight_bytes + plane_bytes, scratch.inflater,
                               scratch.values, "values of the chunk", entry.offset, unpredict_slack);
  data.codes.resize(end + unpredict_slack);
  if (values_coding(entry) == raw_part) {
    copy_raw(bytes, codes, data.codes.data());
  } else {
    std::vector<int16_t> weights(weight_bytes / sizeof(int16_t));
    if (weight_bytes > 0) std::memcpy(weights.data(), bytes.data(), weight_bytes);
    unpredict(data.shape, data.kept, codes, predictor, weights, bytes.last(plane_bytes), data.codes.data(),
              scratch.ring, layers);
  }
  data.codes.resize(end);
  data.codes.erase(data.codes.begin(), data.codes.begin() + begin);
}

// Refuses codes outside the range that the index tells, and of a whole chunk another range than that.
void check_range(const CodeRange& range, const Bcc4Chunk& entry, bool whole) {
  const uint32_t smallest = entry.min_code, largest = entry.max_code;
  const auto [low, high] = range;
  if (whole ? low != smallest || high != largest : low < smallest || high > largest)
    fail(Code::corrupt, "chunk at offset ", entry.offset, ": codes ", low, " .. ", high, ", the index says ",
         smallest, " .. ", largest);
}

// How many layers of a chunk are decoded where the first `asked` are wanted: all of them, where stopping
// saves next to nothing.
[[nodiscard]] int layers_to_decode(const ChunkData& data, const Bcc4Chunk& entry, int asked) {
  const int all = data.shape.layers;
  const bool predicted = values_coding(entry) == deflated_part && predictor_of(entry) != Predictor::none;
  if (!predicted || is_float(data.coded.type) || asked >= all) return all;
  return data.first[asked] == data.first.back() ? all : asked;
}

} // namespace

ChunkData decode_chunk(const ChunkShape& shape, const ChunkCodes& channel, const Bcc4Chunk& entry,
                       std::span<const std::byte> bytes, ChunkScratch& scratch, int layers) {
  check_stored(entry, bytes);
  ChunkData data;
  data.shape = shape;
  data.coded = channel;
  const uint64_t runs_offset = entry.offset + entry.values_bytes;
  read_runs(data, entry, open_runs(entry, bytes, scratch), "runs of the chunk", runs_offset);
  find_layers(data);
  const auto values = bytes.first(entry.values_bytes);
  const int end = layers_to_decode(data, entry, layers);
  read_values(data, entry, values, {0, end, 0}, scratch);
  const CodeRange range = packed_range(data.codes, data.coded.bytes());
  check_range(range, entry, end == shape.layers);
  if (end < shape.layers)
    data.rest = std::make_shared<const ChunkRest>(ChunkRest{shape,
                                                            data.coded,
                                                            entry,
                                                            data.kept,
                                                            data.hole,
                                                            data.first,
                                                            {values.begin(), values.end()},
                                                            end,
                                                            range});
  return data;
}

ChunkData finish_chunk(const ChunkRest& rest, const std::optional<LayersBefore>& before,
                       ChunkScratch& scratch) {
  ChunkData data;
  data.shape = rest.shape, data.coded = rest.coded;
  data.kept = rest.kept, data.hole = rest.hole, data.first = rest.first;
  WalkedLayers layers{0, rest.shape.layers, 0};
  if (before) {
    layers.first = rest.layers, layers.codes_before = rest.first[rest.layers];
    restore_cells(data.shape, data.kept, data.coded, rest.layers, *before, scratch.ring);
  }
  read_values(data, rest.entry, rest.values, layers, scratch);
  for (uint32_t& first : data.first) // layers that are not here have no codes
    first -= std::min(first, static_cast<uint32_t>(layers.codes_before));
  auto [low, high] = packed_range(data.codes, data.coded.bytes());
  check_range({std::min(low, rest.range[0]), std::max(high, rest.range[1])}, rest.entry, true);
  return data;
}

ChunkData chunk_of_holes(const ChunkShape& shape, const ChunkCodes& channel) {
  ChunkData data;
  data.shape = shape;
  data.coded = channel;
  data.kept.assign(shape.layers, BrickMask{});
  for_rows(shape, [&](size_t m, size_t r, int width) {
    data.kept[m][r] = static_cast<uint16_t>((1u << width) - 1);
  });
  data.hole = data.kept;
  find_layers(data);
  data.codes.resize(size_t{data.first.back()} * channel.bytes());
  for (size_t i = 0; i < data.codes.size(); i += channel.bytes())
    std::memcpy(data.codes.data() + i, &channel.air, channel.bytes());
  return data;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Codes one chunk: run lists of its kept sites and holes, and its codes by the predictor that promises the
// fewest bits; and decodes it again.
#include "formats/bcc4/coding/chunk.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "base/bytes.h"
#include "formats/bcc4/coding/choose_predictor.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/predict.h"
#include "formats/bcc4/coding/range.h"
#include "formats/bcc4/coding/scratch.h"
#include "points/runs.h"

namespace bccsplat {
namespace {

constexpr uint8_t raw = 0, deflated = 1;

// Chunks of fewer codes than that are also tried as one stream; larger ones only from exhaustive_level on.
constexpr size_t few_codes = 1024;

[[nodiscard]] int count_bits(const BrickMask& mask) {
  // Adds up growing groups of bits, which the compiler does in vectors: not every target counts bits in
  // hardware.
  unsigned n = 0;
  for (const uint16_t row : mask) {
    unsigned v = row;
    v -= v >> 1 & 0x5555;
    v = (v & 0x3333) + (v >> 2 & 0x3333);
    v = (v + (v >> 4)) & 0x0f0f;
    n += (v + (v >> 8)) & 31;
  }
  return static_cast<int>(n);
}

// Calls body(layer, row index z*16 + y, row width) for the rows inside the domain, in coding order.
template<class Body> void for_rows(const ChunkShape& shape, Body&& body) {
  for (int m = 0; m < shape.layers; ++m) {
    const Int3& n = shape.box[static_cast<size_t>(m)];
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        body(static_cast<size_t>(m), static_cast<size_t>(z * brick_edge + y), static_cast<int>(n[0]));
  }
}

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

// Reads the masks of all layers from the rows inside the domain, in coding order.
void read_masks(const ChunkShape& shape, RunDecoder& runs, std::vector<BrickMask>& masks) {
  masks.assign(static_cast<size_t>(shape.layers), BrickMask{});
  for (size_t m = 0; m < masks.size(); ++m) {
    const auto [nx, ny, nz] = shape.box[m];
    const auto rows = std::span(masks[m]);
    if (nx == brick_edge && ny == brick_edge) {
      runs.fill(rows.first(static_cast<size_t>(nz) * brick_edge));
      continue;
    }
    for (int z = 0; z < nz; ++z) {
      if (runs.skip(static_cast<uint64_t>(nx) * static_cast<uint64_t>(ny))) continue;
      for (int y = 0; y < ny; ++y) rows[static_cast<size_t>(z * brick_edge + y)] = runs.row(nx);
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

// The largest power of two, as a shift, that divides all steps of a chunk of i32.
[[nodiscard]] int common_shift(const ChunkSites& sites, const ChunkCodes& channel) {
  if (channel.type != ValueType::i32) return 0;
  uint32_t all = 1u << max_shift;
  for (const uint32_t code : sites.codes) all |= code - i32_air;
  return std::countr_zero(all);
}

struct CodedValues {
  uint8_t coding = raw, predictor = 0;
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
    if (stream.size() < (best.coding == raw ? raw_bytes : best.bytes.size()))
      best = {deflated, static_cast<uint8_t>(predictor), std::move(stream)};
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
  if (best.coding == raw) best.bytes = write_patterns(sites.codes, codes);
  return best;
}

// Returns a part that is stored raw, or inflates it into `room`, which has `slack` bytes more on both sides.
[[nodiscard]] std::span<const std::byte> open_part(std::span<const std::byte> part, uint8_t coding,
                                                   size_t decoded, DeflateKind kind, Inflater& inflater,
                                                   std::vector<std::byte>& room, std::string_view what,
                                                   uint64_t offset, size_t slack = 0) {
  if (coding == raw) {
    if (part.size() != decoded)
      fail(Code::corrupt, what, " at offset ", offset, ": ", part.size(), " raw bytes stand for ", decoded);
    return part;
  }
  if (room.size() < decoded + 2 * slack) room.resize(decoded + 2 * slack);
  const auto inner = std::span(room).subspan(slack, decoded);
  if (!inflater.inflate(part, inner, kind))
    fail(Code::corrupt, what, " at offset ", offset, ": no deflate stream of ", decoded, " bytes");
  return inner;
}

void read_values(ChunkData& data, const ChunkCodes& codes, const Bcc4Chunk& parts,
                 std::span<const std::byte> part, uint64_t offset, ChunkScratch& scratch) {
  const auto coding = static_cast<uint8_t>(parts.coding & 15);
  const auto predictor = static_cast<Predictor>(parts.predictor & 15);
  const size_t weight_count = predictor == Predictor::fitted ? fitted_weights(data.shape) : 0;
  const size_t plane_bytes = size_t{parts.kept} * codes.bytes();
  const auto bytes =
      open_part(part, coding, weight_count * sizeof(int16_t) + plane_bytes, DeflateKind::noise,
                scratch.inflater, scratch.values, "values of the chunk", offset, unpredict_slack);
  data.codes.resize(plane_bytes + unpredict_slack);
  if (coding == raw) {
    if (!is_float(codes.type))
      std::copy(bytes.begin(), bytes.end(), data.codes.begin());
    else
      for (size_t i = 0; i < plane_bytes; i += codes.bytes()) {
        uint32_t p = 0;
        std::memcpy(&p, bytes.data() + i, codes.bytes());
        p = code_of(p, codes);
        std::memcpy(data.codes.data() + i, &p, codes.bytes());
      }
  } else {
    std::vector<int16_t> weights(weight_count);
    if (weight_count > 0) std::memcpy(weights.data(), bytes.data(), weight_count * sizeof(int16_t));
    unpredict(data.shape, data.kept, codes, predictor, weights, bytes.last(plane_bytes), data.codes.data(),
              scratch.ring);
  }
  data.codes.resize(plane_bytes);
}

void find_layers(ChunkData& data) {
  uint32_t n = 0;
  data.first.reserve(data.kept.size() + 1);
  for (const BrickMask& mask : data.kept) {
    data.first.push_back(n);
    n += static_cast<uint32_t>(count_bits(mask));
  }
  data.first.push_back(n);
}

} // namespace

uint64_t ChunkShape::sites() const {
  uint64_t n = 0;
  for (int m = 0; m < layers; ++m) {
    const auto& [x, y, z] = box[static_cast<size_t>(m)];
    n += static_cast<uint64_t>(x * y * z);
  }
  return n;
}

ChunkShape chunk_shape(const Lattice4& lattice, int32_t first_layer, int32_t layers, const Int3& brick) {
  ChunkShape shape;
  shape.layers = layers;
  shape.period = lattice.layer_period();
  shape.still = lattice.is_static();
  shape.first_coset = lattice.coset(first_layer);
  for (int m = 0; m < shape.layers; ++m) {
    const Int3 dims = lattice.space.dims(shape.coset(m));
    Int3 n;
    for (size_t a = 0; a < 3; ++a) n[a] = std::clamp(dims[a] - brick[a] * brick_edge, 0, brick_edge);
    if (n[0] > 0 && n[1] > 0 && n[2] > 0) shape.box[static_cast<size_t>(m)] = n;
  }
  return shape;
}

uint32_t ChunkSites::holes() const {
  int n = 0;
  for (const auto& mask : hole) n += count_bits(mask);
  return static_cast<uint32_t>(n);
}

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

ChunkCodes codes_of_chunk(const ChunkCodes& channel, uint32_t smallest, uint32_t largest, int shift) {
  if (channel.type != ValueType::i32) return channel;
  const ChunkCodes units{ValueType::i32, i32_air, 0, shift};
  const uint32_t low = units.of_ordered(smallest), high = units.of_ordered(largest);
  const uint32_t base = std::min(low, i32_air), span = std::max(high, i32_air) - base;
  const ValueType type = span <= UINT8_MAX    ? ValueType::u8
                         : span <= UINT16_MAX ? ValueType::u16
                                              : ValueType::i32;
  return {type, i32_air - base, base, shift};
}

EncodedChunk encode_chunk(ChunkSites sites, const ChunkCodes& channel, int level) {
  EncodedChunk chunk;
  Bcc4Chunk& entry = chunk.entry;
  entry.kept = static_cast<uint32_t>(sites.codes.size());
  entry.holes = sites.holes();
  const auto [low, high] = range_of(sites.codes);
  entry.min_code = low;
  entry.max_code = high;
  const ChunkCodes codes = codes_of_chunk(channel, low, high, common_shift(sites, channel));
  for (uint32_t& code : sites.codes) code = codes.of_ordered(code);

  CodedValues values = write_values(sites, codes, level);
  std::vector<std::byte> runs = write_runs(sites);
  entry.runs_decoded = static_cast<uint32_t>(runs.size());
  uint8_t runs_coding = raw;
  if (level > 0) {
    // Runs of an object repeat from row to row; single sites that are left out here and there do not.
    std::vector<std::byte> stream = deflate_bytes(runs, level, DeflateKind::text);
    std::vector<std::byte> other = deflate_bytes(runs, level, DeflateKind::noise);
    if (other.size() < stream.size()) stream = std::move(other);
    if (stream.size() < runs.size()) {
      runs = std::move(stream);
      runs_coding = deflated;
    }
  }
  entry.values_bytes = static_cast<uint32_t>(values.bytes.size());
  entry.runs_bytes = static_cast<uint32_t>(runs.size());
  entry.coding = static_cast<uint8_t>(values.coding | runs_coding << 4);
  entry.predictor = static_cast<uint8_t>(values.predictor | codes.shift << 4);
  chunk.bytes = std::move(values.bytes);
  chunk.bytes.insert(chunk.bytes.end(), runs.begin(), runs.end());
  chunk.bytes.resize(entry.stored());
  entry.crc = crc32_of(chunk.bytes);
  return chunk;
}

ChunkData decode_chunk(const ChunkShape& shape, const ChunkCodes& channel, const Bcc4Chunk& entry,
                       std::span<const std::byte> bytes, ChunkScratch& scratch) {
  if (crc32_of(bytes) != entry.crc)
    fail(Code::checksum_mismatch, "chunk at offset ", entry.offset, ": bad checksum");
  for (const std::byte b : bytes.subspan(size_t{entry.values_bytes} + entry.runs_bytes))
    if (b != std::byte{0}) fail(Code::corrupt, "chunk at offset ", entry.offset, ": padding is not zero");
  ChunkData data;
  data.shape = shape;
  const ChunkCodes codes = data.coded =
      codes_of_chunk(channel, entry.min_code, entry.max_code, entry.shift());
  const uint64_t runs_offset = entry.offset + entry.values_bytes;
  const auto runs =
      open_part(bytes.subspan(entry.values_bytes, entry.runs_bytes), entry.coding >> 4, entry.runs_decoded,
                DeflateKind::text, scratch.inflater, scratch.runs, "runs of the chunk", runs_offset);
  read_runs(data, entry, runs, "runs of the chunk", runs_offset);
  find_layers(data);
  read_values(data, codes, entry, bytes.first(entry.values_bytes), entry.offset, scratch);
  const auto [low, high] = packed_range(data.codes, codes.bytes());
  // The codes are the chunk's own: what they stand for would wrap where a unit is more than a step.
  const uint32_t smallest = codes.of_ordered(entry.min_code), largest = codes.of_ordered(entry.max_code);
  if (low != smallest || high != largest)
    fail(Code::corrupt, "chunk at offset ", entry.offset, ": codes ", low, " .. ", high, ", the index says ",
         smallest, " .. ", largest);
  return data;
}

ChunkData chunk_of_holes(const ChunkShape& shape, const ChunkCodes& channel) {
  ChunkData data;
  data.shape = shape;
  const ChunkCodes codes = data.coded = codes_of_chunk(channel, channel.air, channel.air, 0);
  data.kept.assign(static_cast<size_t>(shape.layers), BrickMask{});
  for_rows(shape, [&](size_t m, size_t r, int width) {
    data.kept[m][r] = static_cast<uint16_t>((1u << width) - 1);
  });
  data.hole = data.kept;
  find_layers(data);
  data.codes.resize(size_t{data.first.back()} * codes.bytes());
  for (size_t i = 0; i < data.codes.size(); i += codes.bytes())
    std::memcpy(data.codes.data() + i, &codes.air, codes.bytes());
  return data;
}

} // namespace bccsplat

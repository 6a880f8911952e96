// SPDX-License-Identifier: Apache-2.0
// Codes the steps of a tile, and decodes them: one walk, which asks its coder for what it does not know.
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "formats/bcc4/wavelet/band_symbols.h"
#include "formats/bcc4/wavelet/step_walk.h"
#include "formats/bcc4/wavelet/wavelet_tile.h"

namespace bccsplat {
namespace {

struct Writing {
  const TileBands& bands;
  SymbolCoder<BinaryEncoder>& symbols;
  bool row(const WalkRow& r, uint32_t expected) {
    const int32_t* const s = bands.steps.data() + place_of(bands.shape, r);
    int32_t any = 0; // not std::any_of: nearly all rows are 0 to their end
    for (int x = 0; x < r.box.size[0]; ++x) any |= s[x];
    return symbols.row(any != 0, r, expected);
  }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    return context_of(symbols.code(bands.steps[place_of(bands.shape, r) + x], r, s));
  }
};

struct Reading {
  const Halvings& shape;
  const StepRule& rule;
  TileCoefficients& coefficients;
  SymbolCoder<BinaryDecoder>& symbols;
  bool row(const WalkRow& r, uint32_t expected) { return symbols.row(false, r, expected); }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    const int steps = symbols.code(0, r, s);
    if (steps == 0) return 0;
    coefficients.set(r.k, place_of(shape, r) - r.k * shape.samples() + x, value_of(steps, rule));
    return context_of(steps);
  }
};

constexpr std::string_view in_words = "values of the chunk";

void write_head(std::span<const TileBands> bands, const StepRule& rule, ByteWriter& out) {
  out.write(rule.step);
  for (const uint8_t c : rule.centres) out.write(c);
  std::array<int, 3> times{};
  for (const TileBands& b : bands)
    for (size_t a = 0; a < 3; ++a) times[a] = std::max(times[a], b.shape.times[a]);
  for (const int t : times) out.write(static_cast<uint8_t>(t));
  for (const TileBands& b : bands) {
    if (b.steps.empty()) continue;
    out.write(static_cast<uint8_t>(b.own_basis));
    if (b.own_basis)
      for (const int16_t v : b.basis.rows) out.write(v);
  }
}

struct Head {
  StepRule rule;
  std::vector<TileBands> bands; // without coefficients
};

TimeBasis read_basis(ByteReader& in, int layers, uint64_t offset) {
  const auto kind = in.read<uint8_t>();
  if (kind > 1) fail(Code::corrupt, in_words, " at offset ", offset, ": no basis of time ", kind);
  if (kind == 0) return cosine_basis(layers);
  TimeBasis basis{layers, {}};
  for (int i = 0; i < layers * layers; ++i) basis.rows.push_back(in.read<int16_t>());
  return basis;
}

Head read_head(ByteReader& in, std::span<const TileBox> boxes, uint64_t offset) {
  Head head;
  head.rule.step = in.read<float>();
  if (!(head.rule.step > 0 && head.rule.step <= largest_step))
    fail(Code::corrupt, in_words, " at offset ", offset, ": steps of ", head.rule.step);
  for (uint8_t& c : head.rule.centres) c = in.read<uint8_t>();
  std::array<int, 3> times{};
  for (int& t : times) {
    t = in.read<uint8_t>();
    if (t > most_halved) fail(Code::corrupt, in_words, " at offset ", offset, ": ", t, " halvings");
  }
  for (const TileBox& box : boxes) {
    TileBands& b = head.bands.emplace_back();
    if (box.sites() == 0) continue;
    b.shape = halved(box.size, times);
    b.basis = read_basis(in, box.layers, offset);
  }
  return head;
}

int most_layers_of(std::span<const TileBands> bands) {
  int most = 1;
  for (const TileBands& b : bands) most = std::max(most, b.basis.frames);
  return most;
}

} // namespace

std::vector<std::byte> code_tile(std::span<const TileBands> bands, const StepRule& rule, WalkRoom& room) {
  ByteWriter head;
  write_head(bands, rule, head);
  BinaryEncoder coder;
  SymbolCoder<BinaryEncoder> symbols(coder, most_layers_of(bands));
  for (const TileBands& b : bands) {
    if (b.steps.empty()) continue;
    BandWalk walk(b.shape, b.basis.frames, room);
    Writing visit{b, symbols};
    walk.run(visit);
  }
  std::vector<std::byte> out = head.release();
  const std::vector<std::byte> stream = coder.finish();
  out.insert(out.end(), stream.begin(), stream.end());
  return out;
}

std::vector<TileCoefficients> decode_tile(std::span<const TileBox> boxes, std::span<const std::byte> bytes,
                                          uint64_t offset, WalkRoom& room) {
  ByteReader in(bytes, in_words, offset);
  const Head head = read_head(in, boxes, offset);
  BinaryDecoder coder(bytes.subspan(in.position()));
  SymbolCoder<BinaryDecoder> symbols(coder, most_layers_of(head.bands));
  std::vector<TileCoefficients> out;
  for (size_t c = 0; c < boxes.size(); ++c) {
    const TileBands& b = head.bands[c];
    TileCoefficients& coefficients = out.emplace_back(b.shape, b.basis);
    if (boxes[c].sites() == 0) continue;
    BandWalk walk(b.shape, b.basis.frames, room);
    Reading visit{b.shape, head.rule, coefficients, symbols};
    walk.run(visit);
  }
  return out;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Copies the codes of a layer out of a chunk, or finds those of a brick of values, and spreads them again.
#include "formats/bcc4/coding/layer_codes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include <hwy/cache_control.h>

#include "formats/bcc4/coding/find_codes.h"
#include "formats/bcc4/coding/open_tile.h"
#include "formats/bcc4/coding/spread.h"

namespace bccsplat {
namespace {

constexpr size_t cache_line = 64;

// Codes in as many bytes as they have there.
template<class Code> void put_codes(std::span<const uint16_t> codes, std::byte* to) {
  for (const uint16_t code : codes) {
    const auto narrow = static_cast<Code>(code);
    std::memcpy(to, &narrow, sizeof narrow);
    to += sizeof narrow;
  }
}

template<class Code> void append(const std::byte* from, size_t count, std::vector<uint32_t>& to) {
  const size_t first = to.size();
  to.resize(first + count);
  for (size_t i = 0; i < count; ++i) {
    Code code;
    std::memcpy(&code, from + i * sizeof code, sizeof code);
    to[first + i] = code;
  }
}

} // namespace

std::byte* LayerCodes::begin(const ChunkData& data, size_t layer) {
  const size_t bytes = coder_.codes().bytes(), count = data.first[layer + 1] - data.first[layer];
  codes_.resize((count + 2 * BrickCodes::beside) * bytes);
  const BrickMask& sites = data.kept[layer];
  if (count < brick_sites) kept_ = std::make_unique<const Kept>(Kept{sites, row_index(sites)});
  if (!data.hole.empty() && data.hole[layer] != BrickMask{})
    hole_ = std::make_unique<const BrickMask>(data.hole[layer]);
  return codes_.data() + BrickCodes::beside * bytes;
}

LayerCodes::LayerCodes(const SampleCoder& coder, const ChunkData& data, size_t layer) : coder_(coder) {
  const size_t bytes = coder_.codes().bytes(), first = data.first[layer],
               count = data.first[layer + 1] - first;
  std::copy_n(data.codes.begin() + first * bytes, count * bytes, begin(data, layer));
}

LayerCodes::LayerCodes(const SampleCoder& coder, const OpenTile& tile, int brick, size_t layer)
    : coder_(coder) {
  static_assert(beyond_sums <= BrickCodes::beside);
  tile.make_codes(brick, static_cast<int>(layer), begin(tile.bricks()[brick], layer));
}

LayerCodes::LayerCodes(const SampleCoder& coder, const Brick& brick, std::span<const uint16_t> codes)
    : coder_(coder) {
  const size_t bytes = coder_.codes().bytes();
  codes_.resize((codes.size() + 2 * BrickCodes::beside) * bytes);
  std::byte* const first = codes_.data() + BrickCodes::beside * bytes;
  if (bytes == 1)
    put_codes<uint8_t>(codes, first);
  else
    put_codes<uint16_t>(codes, first);
  if (codes.size() < brick_sites)
    kept_ = std::make_unique<const Kept>(Kept{brick.kept, row_index(brick.kept)});
  if (brick.hole) hole_ = std::make_unique<const BrickMask>(*brick.hole);
}

std::shared_ptr<const LayerCodes> LayerCodes::of(const SampleCoder& coder, const Brick& brick) {
  if (is_float(coder.codes().type)) return nullptr;
  for (size_t row = 0; row < brick_rows && brick.hole; ++row)
    if ((*brick.hole)[row] & ~brick.kept[row]) return nullptr;
  std::array<uint16_t, brick_sites> codes;
  const size_t count = find_codes(coder, brick, codes);
  if (count == 0) return nullptr;
  return std::shared_ptr<const LayerCodes>(new LayerCodes(coder, brick, std::span(codes).first(count)));
}

void LayerCodes::append_codes(std::vector<uint32_t>& to) const {
  const size_t bytes = coder_.codes().bytes(), count = codes_.size() / bytes - 2 * BrickCodes::beside;
  const std::byte* const from = codes_.data() + BrickCodes::beside * bytes;
  if (bytes == 1)
    append<uint8_t>(from, count, to);
  else
    append<uint16_t>(from, count, to);
}

void LayerCodes::read(const PlanePart& part, float* to, std::ptrdiff_t stride) const {
  const size_t bytes = coder_.codes().bytes();
  const BrickCodes brick{codes_.data() + BrickCodes::beside * bytes, kept_ ? &kept_->sites : nullptr,
                         kept_ ? &kept_->first : nullptr};
  // Planes are read one after the other, each from many bricks.
  const size_t next = std::min((part.plane + 1) * brick_edge + part.y, brick_rows - 1);
  const std::byte* ahead = brick.codes + (brick.first ? (*brick.first)[next] : next * brick_edge) * bytes;
  for (size_t i = 0; i < static_cast<size_t>(part.height) * brick_edge * bytes; i += cache_line)
    hwy::Prefetch(ahead + i);
  spread_part(coder_, brick, part, to, stride);
}

uint64_t LayerCodes::bytes() const {
  return sizeof *this + codes_.capacity() + (kept_ ? sizeof(Kept) : 0) + (hole_ ? sizeof(BrickMask) : 0);
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/layer_codes.h"

#include <algorithm>

#include <hwy/cache_control.h>

#include "formats/bcc4/coding/spread.h"

namespace bccsplat {
namespace {

constexpr size_t cache_line = 64;

} // namespace

LayerCodes::LayerCodes(const SampleCoder& coder, const ChunkData& data, size_t layer)
    : coder_(coder), coded_(data.coded) {
  const size_t bytes = coded_.bytes(), first = data.first[layer], count = data.first[layer + 1] - first;
  codes_.resize((count + 2 * BrickCodes::beside) * bytes);
  std::copy_n(data.codes.begin() + static_cast<std::ptrdiff_t>(first * bytes), count * bytes,
              codes_.begin() + static_cast<std::ptrdiff_t>(BrickCodes::beside * bytes));
  const BrickMask& sites = data.kept[layer];
  if (count < brick_sites) kept_ = std::make_unique<const Kept>(Kept{sites, row_index(sites)});
  if (!data.hole.empty() && data.hole[layer] != BrickMask{})
    hole_ = std::make_unique<const BrickMask>(data.hole[layer]);
}

void LayerCodes::read(const PlanePart& part, float* to, std::ptrdiff_t stride) const {
  const size_t bytes = coded_.bytes();
  const BrickCodes brick{codes_.data() + BrickCodes::beside * bytes, kept_ ? &kept_->sites : nullptr,
                         kept_ ? &kept_->first : nullptr};
  // Planes are read one after the other, each from many bricks.
  const auto next = static_cast<size_t>(std::min((part.plane + 1) * brick_edge + part.y, brick_rows - 1));
  const std::byte* ahead = brick.codes + (brick.first ? (*brick.first)[next] : next * brick_edge) * bytes;
  for (size_t i = 0; i < static_cast<size_t>(part.height) * brick_edge * bytes; i += cache_line)
    hwy::Prefetch(ahead + i);
  spread_part(coder_, coded_, brick, part, to, stride);
}

uint64_t LayerCodes::bytes() const {
  return sizeof *this + codes_.capacity() + (kept_ ? sizeof(Kept) : 0) + (hole_ ? sizeof(BrickMask) : 0);
}

} // namespace bccsplat

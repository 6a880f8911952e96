#include "formats/bcc4/coding/layer_codes.h"

#include <algorithm>
#include <array>

#include "formats/bcc4/coding/spread.h"

namespace bccsplat {
namespace {

constexpr uint16_t whole_row = 0xffff;
constexpr std::array<uint16_t, brick_edge> whole_plane = [] {
  std::array<uint16_t, brick_edge> rows{};
  rows.fill(whole_row);
  return rows;
}();

// Codes behind the last one, so that it can be read in a vector of a row.
constexpr size_t beyond = brick_edge - 1;

} // namespace

LayerCodes::LayerCodes(const SampleCoder& coder, const ChunkData& data, size_t layer)
    : coder_(coder), coded_(data.coded) {
  const size_t bytes = coded_.bytes(), first = data.first[layer], count = data.first[layer + 1] - first;
  codes_.resize((count + beyond) * bytes);
  std::copy_n(data.codes.begin() + static_cast<std::ptrdiff_t>(first * bytes), count * bytes, codes_.begin());
  const BrickMask& sites = data.kept[layer];
  if (count < brick_sites) kept_ = std::make_unique<const Kept>(Kept{sites, row_index(sites)});
  if (!data.hole.empty() && data.hole[layer] != BrickMask{})
    hole_ = std::make_unique<const BrickMask>(data.hole[layer]);
}

void LayerCodes::read(const PlanePart& part, float* to, std::ptrdiff_t stride) const {
  const auto row = static_cast<size_t>(part.plane * brick_edge + part.y),
             height = static_cast<size_t>(part.height);
  const auto kept =
      kept_ ? std::span(kept_->sites).subspan(row, height) : std::span(whole_plane).first(height);
  const size_t first = kept_ ? kept_->first[row] : row * brick_edge;
  if (part.width == brick_edge) return spread_codes(coder_, coded_, kept, codes_, first, to, stride);
  std::array<float, brick_rows> rows;
  spread_codes(coder_, coded_, kept, codes_, first, rows.data());
  for (int y = 0; y < part.height; ++y)
    std::copy_n(rows.data() + y * brick_edge + part.x, part.width, to + y * stride);
}

uint64_t LayerCodes::bytes() const {
  return sizeof *this + codes_.capacity() + (kept_ ? sizeof(Kept) : 0) + (hole_ ? sizeof(BrickMask) : 0);
}

} // namespace bccsplat

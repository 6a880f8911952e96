// SPDX-License-Identifier: Apache-2.0
// The samples of one layer of a decoded chunk, apart from the others and in no more bytes than they have
// there.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/spread.h"
#include "points/runs.h"
#include "points/sample_layer.h"

namespace bccsplat {

class LayerCodes final : public CodedBrick {
 public:
  // data: of integers, with some of them in the layer.
  LayerCodes(const SampleCoder& coder, const ChunkData& data, size_t layer);
  // The same of a brick of a tile.
  LayerCodes(const SampleCoder& coder, const OpenTile& tile, int brick, size_t layer);
  // The codes of a brick that has kept sites; null of floats and where codes do not give back every
  // value.
  [[nodiscard]] static std::shared_ptr<const LayerCodes> of(const SampleCoder& coder, const Brick& brick);

  void read(const PlanePart& part, float* to, std::ptrdiff_t stride) const override;
  const BrickMask* kept() const override { return kept_ ? &kept_->sites : nullptr; }
  const BrickMask* hole() const override { return hole_.get(); }
  uint64_t bytes() const override;
  // Returns whether this coder gives its values these codes.
  [[nodiscard]] bool coded_as(const SampleCoder& coder) const {
    return coder_.codes().type == coder.codes().type && coder_.scale() == coder.scale() &&
           coder_.bias() == coder.bias();
  }
  // The codes of the kept sites, as the chunk has them.
  [[nodiscard]] std::span<const std::byte> packed() const {
    const size_t beside = BrickCodes::beside * coder_.codes().bytes();
    return std::span(codes_).subspan(beside, codes_.size() - 2 * beside);
  }
  // Appends the ordered codes of the kept sites.
  void append_codes(std::vector<uint32_t>& to) const;

 private:
  LayerCodes(const SampleCoder& coder, const Brick& brick, std::span<const uint16_t> codes);
  // Makes room for the codes of a layer, and says which sites they are of; returns where they go.
  std::byte* begin(const ChunkData& data, size_t layer);
  struct Kept {
    BrickMask sites;
    RowIndex first; // codes of rows
  };
  SampleCoder coder_;
  std::vector<std::byte> codes_;
  std::unique_ptr<const Kept> kept_; // null: all sites
  std::unique_ptr<const BrickMask> hole_;
};

} // namespace bccsplat

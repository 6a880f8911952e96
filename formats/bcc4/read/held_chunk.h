// SPDX-License-Identifier: Apache-2.0
// What a source of samples keeps of a chunk.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/layer_codes.h"
#include "formats/bcc4/coding/linear_tile.h"
#include "formats/bcc4/coding/open_tile.h"
#include "formats/bcc4/read/samples.h"

namespace bccsplat {

// A decoded chunk, without the layers that somebody has got who keeps them. Codes are held layer by layer, as
// they are handed over; values of floats would take more than the codes of the chunk do, which stay until all
// of its layers have gone. Layers that are still to be decoded are held as they are stored. A tile is held
// brick by brick; those of its layers that nobody has asked for are held as coefficients, where these take
// less than their codes would. A linear tile is held as its coefficients.
class Bcc4Samples::HeldChunk {
 public:
  // make(data, layer), make(tile, brick, layer): a brick of samples. `wanted`: layers, a bit each.
  template<class MakeBrick>
  HeldChunk(std::shared_ptr<const ChunkData> data, const MakeBrick& make, uint32_t wanted) : HeldChunk() {
    if (data->linear) {
      linear_ = data->linear, lost_ = data->lost;
      decoded_ = linear_->layers(), layers_ = all_layers();
    } else if (data->tile) {
      hold_tile(data->tile, make, wanted);
    } else if (data->bricks.empty()) {
      *this = HeldChunk(Single{}, std::move(data), make);
    } else {
      for (const auto& brick : data->bricks) tile_.push_back(HeldChunk(Single{}, brick, make));
    }
  }
  // With the rest of the chunk, which has been decoded.
  template<class MakeBrick>
  HeldChunk(const HeldChunk& begun, const ChunkData& all, const MakeBrick& make) : HeldChunk(begun) {
    for (size_t m = rest_->layers; m < bricks_.size(); ++m) bricks_[m] = make(all, static_cast<int>(m));
    decoded_ = all.shape.layers;
    rest_ = nullptr;
  }
  // With more layers of a tile.
  template<class MakeBrick>
  HeldChunk(const HeldChunk& begun, uint32_t wanted, const MakeBrick& make) : HeldChunk(begun) {
    make_layers(wanted & ~made_, make);
  }

  // The bricks of a tile, x fastest; empty: it is none.
  [[nodiscard]] std::span<const HeldChunk> tile() const { return tile_; }
  [[nodiscard]] bool lost() const { return lost_; }
  // Returns whether any layer has anything that is kept.
  [[nodiscard]] bool filled() const { return layers_ != 0; }
  // Returns whether these layers, a bit each, are here or air.
  [[nodiscard]] bool has(uint32_t layers) const {
    if (linear_) return true;
    if (open_) return (layers & ~made_) == 0;
    if (!tile_.empty()) return can_have(layers);
    return can_have(layers) && (!rest_ || layers >> decoded_ == 0);
  }
  // Returns whether they are once the rest has been decoded.
  [[nodiscard]] bool can_have(uint32_t layers) const {
    if (open_ || linear_) return true;
    return (data_ || (layers & gone_) == 0) &&
           std::all_of(tile_.begin(), tile_.end(), [&](const HeldChunk& b) { return b.can_have(layers); });
  }
  // Decodes it; finish(rest, what comes before it). That has gone where nobody keeps it.
  template<class Finish> [[nodiscard]] ChunkData finished(const Finish& finish) const {
    std::array<std::shared_ptr<const CodedBrick>, 2> kept;
    LayersBefore codes;
    for (int i = 0; i < 2; ++i) {
      const int m = decoded_ - 2 + i;
      const size_t k = i;
      if (m < 0 || (layers_ >> m & 1) == 0) continue;
      kept[k] = before_[k].lock();
      if (!kept[k]) return finish(*rest_, std::nullopt);
      codes[k] = static_cast<const LayerCodes&>(*kept[k]).packed();
    }
    return finish(*rest_, codes);
  }
  // Returns whether the layers that it lacks are those of a tile.
  [[nodiscard]] bool is_open_tile() const { return open_ != nullptr; }
  // A tile of which any sum of layers can be made; null: another chunk.
  [[nodiscard]] const LinearTile* linear() const { return linear_.get(); }
  // Returns how many layers have been decoded.
  [[nodiscard]] int decoded() const { return decoded_; }
  // The codes of all layers; null where they are held layer by layer.
  [[nodiscard]] const ChunkData* data() const { return data_.get(); }
  [[nodiscard]] const SampleBrick& brick(int layer) const { return bricks_[layer]; }
  // Returns null where nothing is left.
  [[nodiscard]] std::shared_ptr<const HeldChunk> without(uint32_t layers) const {
    auto left = std::make_shared<HeldChunk>(*this);
    return left->let_go(layers) ? left : nullptr;
  }
  [[nodiscard]] uint64_t bytes() const {
    uint64_t sum = sizeof *this + bricks_.size() * sizeof(SampleBrick) + (data_ ? data_->bytes() : 0) +
                   (rest_ ? rest_->bytes() : 0) + (open_ ? open_->bytes() : 0) +
                   (linear_ ? linear_->bytes() : 0);
    for (const SampleBrick& brick : bricks_) sum += brick.bytes();
    for (const HeldChunk& brick : tile_) sum += brick.bytes();
    return sum;
  }

 private:
  HeldChunk() : layers_(0), lost_(false), decoded_(0) {}
  struct Single {};
  template<class MakeBrick>
  HeldChunk(Single /*no tile*/, std::shared_ptr<const ChunkData> data, const MakeBrick& make)
      : rest_(data->rest), layers_(filled_layers(rest_ ? rest_->first : data->first)), lost_(data->lost),
        decoded_(rest_ ? rest_->layers : data->shape.layers) {
    if (is_float(data->coded.type)) {
      data_ = std::move(data);
      return;
    }
    bricks_.resize(data->first.size() - 1);
    for (int m = 0; m < decoded_; ++m) bricks_[m] = make(*data, m);
    for (int i = 0; rest_ && i < 2; ++i)
      if (const int m = decoded_ - 2 + i; m >= 0) before_[i] = brick(m).codes;
  }
  // A brick of a tile, without any layer.
  HeldChunk(Single /*no tile*/, const ChunkData& data)
      : layers_(filled_layers(data.first)), lost_(false), decoded_(data.shape.layers) {
    bricks_.resize(data.first.size() - 1);
  }
  template<class MakeBrick>
  void hold_tile(std::shared_ptr<const OpenTile> tile, const MakeBrick& make, uint32_t wanted) {
    open_ = std::move(tile);
    for (const ChunkData& brick : open_->bricks()) tile_.push_back(HeldChunk(Single{}, brick));
    decoded_ = open_->bricks().front().shape.layers;
    const bool apart = open_->bytes() < open_->code_bytes(all_layers() & ~wanted);
    make_layers(apart ? wanted & all_layers() : all_layers(), make);
  }
  [[nodiscard]] uint32_t all_layers() const { return static_cast<uint32_t>((uint64_t{1} << decoded_) - 1); }
  // Makes layers of an open tile; once all have been made it is not needed.
  template<class MakeBrick> void make_layers(uint32_t layers, const MakeBrick& make) {
    for (size_t i = 0; i < tile_.size(); ++i) {
      HeldChunk& brick = tile_[i];
      for (size_t m = 0; m < brick.bricks_.size(); ++m)
        if (layers >> m & 1) brick.bricks_[m] = make(*open_, static_cast<int>(i), static_cast<int>(m));
      brick.gone_ &= ~layers;
    }
    made_ |= layers, gone_ &= ~layers;
    if ((all_layers() & ~(made_ | gone_)) == 0) open_ = nullptr;
  }
  // The layers of a chunk in which something is kept, a bit each.
  [[nodiscard]] static uint32_t filled_layers(std::span<const uint32_t> first) {
    uint32_t bits = 0;
    for (size_t m = 0; m + 1 < first.size(); ++m)
      if (first[m + 1] > first[m]) bits |= uint32_t{1} << m;
    return bits;
  }

  // Returns whether anything is left.
  bool let_go(uint32_t layers) {
    gone_ |= layers;
    made_ &= ~layers;
    for (size_t m = 0; m < bricks_.size(); ++m)
      if (layers >> m & 1) bricks_[m] = {};
    bool any = (layers_ & ~gone_) != 0;
    for (HeldChunk& brick : tile_) any |= brick.let_go(layers);
    return any;
  }

  std::shared_ptr<const LinearTile> linear_; // then there is nothing else
  std::vector<HeldChunk> tile_;              // then there is nothing of its own
  std::shared_ptr<const OpenTile> open_; // what the other layers of a tile are made of; null: all were made
  uint32_t made_ = 0;                    // layers that are here, of an open tile
  std::shared_ptr<const ChunkData> data_;
  std::shared_ptr<const ChunkRest> rest_;                 // null: all layers have been decoded
  std::array<std::weak_ptr<const CodedBrick>, 2> before_; // of the two layers before the rest
  std::vector<SampleBrick> bricks_;                       // by layer, where there is no data_
  uint32_t layers_, gone_ = 0;                            // that are filled; that somebody has got
  bool lost_;
  int decoded_;
};

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// A box of numbers in some layers as wavelet coefficients: its time axis in a basis in which few layers hold
// what moves, each of these halved along x, y and z, and the coefficients in whole steps
// (formats/bcc4.md, section 12).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "formats/bcc4/wavelet/bands.h"
#include "formats/bcc4/wavelet/halvings.h"
#include "formats/bcc4/wavelet/layer_sums.h"
#include "formats/bcc4/wavelet/tile_coefficients.h"
#include "formats/bcc4/wavelet/time_basis.h"

namespace bccsplat {

// The sites of one coset in a tile: layers one after the other, x fastest.
struct TileBox {
  std::array<int, 3> size{0, 0, 0};
  int layers = 0;
  [[nodiscard]] size_t layer_sites() const { return size_t(size[0]) * size[1] * size[2]; }
  [[nodiscard]] size_t sites() const { return layer_sites() * layers; }
};

// One coset of a tile as coefficients, and these in steps.
struct TileBands {
  Halvings shape;
  TimeBasis basis;
  bool own_basis = false; // it is in the stream, else cosines
  std::vector<float> coefficients;
  std::vector<int32_t> steps; // once they have been chosen
};

inline constexpr int centre_middle = 128; // centres that say: the middle

// What steps stand for.
struct StepRule {
  float step = 1;
  // Where in the interval of a magnitude of 1, and of more, its value is: in 1/256 from centre_middle.
  std::array<uint8_t, 2> centres{centre_middle, centre_middle};
};

// The most that an axis is halved.
[[nodiscard]] int most_halvings(int size);

// Memory for the layers of a box, which the next one uses again once nobody holds them any more.
class LayerRoom {
 public:
  // Returns so many values, of any kind.
  [[nodiscard]] std::shared_ptr<float[]> take(size_t count) {
    if (floats_.use_count() != 1 || count_ < count) floats_.reset(new float[count]), count_ = count;
    return floats_;
  }

 private:
  std::shared_ptr<float[]> floats_;
  size_t count_ = 0;
};
// What coding takes, box after box: the system clears memory that it hands out anew.
struct TileRoom {
  WalkRoom walk;
  std::array<LayerRoom, 2> layers; // by coset, as are the others
  std::array<std::vector<float>, 2> values;
  std::array<std::vector<int32_t>, 2> steps;
};

// A box whose layers are put together in space, but not yet in time: any frame can be made of them. Layers
// without anything in them are not there.
class TileLayers {
 public:
  TileLayers() = default;
  TileLayers(const TileCoefficients& coefficients, LayerRoom& room);
  // The layers that a frame is the sum of; beyond each lie beyond_sums values more.
  [[nodiscard]] std::vector<WeighedLayer> sum_of(int frame) const;
  [[nodiscard]] std::vector<float> frames() const;
  [[nodiscard]] uint64_t bytes() const { return filled_.size() * stride_ * sizeof(float); }

 private:
  size_t samples_ = 0, stride_ = 0; // of a layer, and from one to the next
  TimeBasis basis_;
  std::vector<int> filled_;
  std::shared_ptr<const float[]> layers_;
};

// Bands with their steps to bytes, and back to numbers. The bytes say all but the boxes.
[[nodiscard]] std::vector<std::byte> code_tile(std::span<const TileBands> bands, const StepRule& rule,
                                               WalkRoom& room);
// What a reader gets of bands.
[[nodiscard]] TileCoefficients coefficients_of(const TileBands& bands, const StepRule& rule);
// Returns the coefficients of each box. Throws Code::corrupt, Code::truncated. `offset` is told in error
// texts.
[[nodiscard]] std::vector<TileCoefficients> decode_tile(std::span<const TileBox> boxes,
                                                        std::span<const std::byte> bytes, uint64_t offset,
                                                        WalkRoom& room);

} // namespace bccsplat

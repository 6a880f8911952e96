// SPDX-License-Identifier: Apache-2.0
// A source of the samples of a 4D volume: a .bcc4 file, or memory.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "base/context.h"
#include "lattice/lattice.h"
#include "points/brick.h"
#include "points/sample_layer.h"

namespace bccsplat {

// A box of bricks, half-open, in brick units of every coset.
struct BrickBox {
  Int3 begin{0, 0, 0};
  Int3 end{INT32_MAX, INT32_MAX, INT32_MAX};
  [[nodiscard]] bool contains(const Int3& b) const {
    for (size_t a = 0; a < 3; ++a)
      if (b[a] < begin[a] || b[a] >= end[a]) return false;
    return true;
  }
  // Returns whether a cube of edge bricks along each axis, the first one at b, has a brick of the box.
  [[nodiscard]] bool meets(const Int3& b, int32_t edge) const {
    for (size_t a = 0; a < 3; ++a)
      if (b[a] + edge <= begin[a] || b[a] >= end[a]) return false;
    return true;
  }
  // Returns the box with the bricks beside it.
  [[nodiscard]] BrickBox widened() const {
    BrickBox box;
    for (size_t a = 0; a < 3; ++a) {
      box.begin[a] = std::max(0, begin[a] - 1);
      box.end[a] = end[a] == INT32_MAX ? INT32_MAX : end[a] + 1;
    }
    return box;
  }
  [[nodiscard]] bool empty() const { return begin[0] >= end[0] || begin[1] >= end[1] || begin[2] >= end[2]; }
  // Returns the least box that has both, either of which may be empty.
  [[nodiscard]] BrickBox joined(const BrickBox& other) const {
    if (empty() || other.empty()) return empty() ? other : *this;
    BrickBox both;
    for (size_t a = 0; a < 3; ++a) {
      both.begin[a] = std::min(begin[a], other.begin[a]);
      both.end[a] = std::max(end[a], other.end[a]);
    }
    return both;
  }
  bool operator==(const BrickBox&) const = default;
};
// The same box, but along a periodic axis all of it where it comes so near to an end that what lies beside it
// is at the other one: the last brick may be narrow.
[[nodiscard]] inline BrickBox go_round(BrickBox box, const Lattice3& lattice) {
  for (size_t a = 0; a < 3; ++a) {
    const int32_t bricks = (lattice.dims(0)[a] + brick_edge - 1) / brick_edge;
    if (lattice.periodic[a] && (box.begin[a] < 1 || box.end[a] > bricks - 2))
      box.begin[a] = 0, box.end[a] = INT32_MAX;
  }
  return box;
}

// Planes first .. last across an axis of space, of every coset, counted as Lattice3::plane does.
struct PlaneRange {
  size_t axis = 0;
  int32_t first = 0, last = INT32_MAX;
};
// The bricks that have sites on these planes; of a range that goes beyond an end all of them.
[[nodiscard]] BrickBox bricks_on(const Lattice3& lattice, const PlaneRange& planes);

// Bricks of a layer of a file that somebody asks for.
struct LayerRead {
  int32_t layer = 0;
  BrickBox bricks;
  bool operator<(const LayerRead& other) const {
    return std::tie(layer, bricks.begin, bricks.end) <
           std::tie(other.layer, other.bricks.begin, other.bricks.end);
  }
};
using LayerReads = std::set<LayerRead>;

// A sum of layers of one coset, each with its weight.
struct LayerSum {
  struct Term {
    int32_t layer = 0;
    float weight = 0;
  };
  int32_t layer = 0; // whose holes the sum has
  std::vector<Term> terms;
};

class SampleSource {
 public:
  virtual ~SampleSource() = default;
  [[nodiscard]] virtual const Lattice4& lattice() const = 0;
  [[nodiscard]] virtual int channels() const = 0;
  // The value of sites that are not there.
  [[nodiscard]] virtual float air(int channel) const = 0;
  // The value that layers hold theirs relative to: air, or where no site is left out another value
  // (formats/bcc4/field_base.h).
  [[nodiscard]] virtual float base(int channel) const { return air(channel); }
  // The steps that samples of integers come in: coefficients that are made of them may be rounded, far
  // more finely. 0 where nothing may be rounded.
  [[nodiscard]] virtual double sample_step(int /*channel*/) const { return 0; }
  // Returns the samples of the bricks of one layer inside `region`; bricks outside may be absent. layer in
  // [0, lattice().layers()). Concurrent calls are allowed.
  [[nodiscard]] virtual BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                                              const Context& context) const = 0;
  // Hands over several layers, in the order given: cheaper than one by one where layers that follow each
  // other are stored together.
  template<class Layer> using TakeLayer = std::function<void(int32_t layer, Layer&& read)>;
  virtual void read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                           const Context& context, const TakeLayer<BrickLayer>& take) const;
  // Hands over layers in the form that takes least memory.
  virtual void read_samples(int channel, std::span<const int32_t> layers, const BrickBox& region,
                            const Context& context, const TakeLayer<SampleLayer>& take) const;
  // Returns whether sums of layers cost about what a layer does; add_layers() is then there.
  [[nodiscard]] virtual bool adds_layers(int /*channel*/) const { return false; }
  // Returns how many bricks a sum of these layers has at most. It reads the index.
  [[nodiscard]] virtual uint64_t bricks_at_most(int /*channel*/, std::span<const int32_t> /*layers*/,
                                                const BrickBox& /*region*/) const {
    return 0;
  }
  // Returns sums of layers as read_layer() returns layers, in the order of `sums`.
  [[nodiscard]] virtual std::vector<BrickLayer> add_layers(int channel, std::span<const LayerSum> sums,
                                                           const BrickBox& region,
                                                           const Context& context) const;
  // Tells what of the file behind it reading layers asks for.
  virtual void list_reads(std::span<const int32_t> layers, const BrickBox& region, LayerReads& out) const;
};

// Dense or sparse layers in memory: for tests and for hosts that never touch a file.
class MemorySamples final : public SampleSource {
 public:
  // layers[channel][layer]
  MemorySamples(const Lattice4& lattice, std::vector<float> air, std::vector<std::vector<BrickLayer>> layers)
      : lattice_(lattice), air_(std::move(air)), layers_(std::move(layers)) {}
  const Lattice4& lattice() const override { return lattice_; }
  int channels() const override { return static_cast<int>(layers_.size()); }
  float air(int channel) const override { return air_[channel]; }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox&, const Context&) const override {
    return layers_[channel][layer];
  }

 private:
  Lattice4 lattice_;
  std::vector<float> air_;
  std::vector<std::vector<BrickLayer>> layers_;
};

} // namespace bccsplat

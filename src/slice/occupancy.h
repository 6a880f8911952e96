// SPDX-License-Identifier: Apache-2.0
// Tells where a volume holds points at all, in cells of 4 sites per axis of each layer: what lies far from
// any point is the base of the field and need not be evaluated.
#pragma once

#include <optional>
#include <vector>

#include "points/sample_source.h"
#include "slice/plane_geometry.h"

namespace bccsplat {

class Occupancy {
 public:
  explicit Occupancy(const Lattice4& lattice)
      : lattice_(lattice), layers_(static_cast<size_t>(lattice.layers())) {}
  void add(int32_t layer, const BrickLayer& points);
  // False when no kept site or hole of the volume or of its mirror image lies in the box (index space).
  [[nodiscard]] bool any(const Vec4& low, const Vec4& high) const;

 private:
  struct Layer {
    Int3 cells{};
    std::vector<bool> used; // x fastest
  };
  Lattice4 lattice_;
  std::vector<Layer> layers_; // without cells: air
};

// Samples of a part of a volume, read once and held in memory.
class HeldSamples final : public SampleSource {
 public:
  // Returns nothing when they take more than `limit` bytes or than the budget has left. The source must
  // outlive this.
  static std::optional<HeldSamples> read(const SampleSource& source, int channel, const BrickBox& region,
                                         uint64_t limit, const Context& context);

  const Lattice4& lattice() const override { return source_->lattice(); }
  int channels() const override { return source_->channels(); }
  float air(int channel) const override { return source_->air(channel); }
  float base(int channel) const override { return source_->base(channel); }
  BrickLayer read_layer(int, int32_t layer, const BrickBox&, const Context&) const override {
    return layers_[layer];
  }

 private:
  explicit HeldSamples(const SampleSource& source) : source_(&source) {}
  const SampleSource* source_;
  std::vector<BrickLayer> layers_;
  std::vector<Reservation> memory_;
};

} // namespace bccsplat

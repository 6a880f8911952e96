// SPDX-License-Identifier: Apache-2.0
// The part of a volume that a slice depends on: of every layer only the bricks in reach of its hyperplane, or
// of the thickness around it, are read; the others count as the base of the field.
#pragma once

#include <vector>

#include "points/sample_source.h"
#include "slice/plane_geometry.h"

namespace bccsplat {

// A point of the slice depends on samples up to this far from it, in index units and frames, and the slice
// looks at mirror images up to this far beyond the ends of the domain.
struct TouchReach {
  Vec4 samples{}, mirrored{};
  double half_thickness = 0;
};

class TouchedSamples final : public SampleSource {
 public:
  // The source must outlive this. within: bricks outside are not read either.
  TouchedSamples(const SampleSource& source, const Hyperplane& hyperplane, const TouchReach& reach,
                 const BrickBox& within = {})
      : source_(source), hyperplane_(hyperplane), reach_(reach), within_(within) {}

  const Lattice4& lattice() const override { return source_.lattice(); }
  int channels() const override { return source_.channels(); }
  float air(int channel) const override { return source_.air(channel); }
  float base(int channel) const override { return source_.base(channel); }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;
  void list_reads(std::span<const int32_t> layers, const BrickBox& region, LayerReads& out) const override;

  // Returns whether samples of bricks begin .. end - 1 of a layer, or their mirror images, may lie in reach.
  [[nodiscard]] bool touches(int32_t layer, const Int3& begin, const Int3& end) const;

 private:
  // The boxes of a layer's bricks that are read.
  [[nodiscard]] std::vector<BrickBox> boxes(int32_t layer, const BrickBox& region) const;

  const SampleSource& source_;
  Hyperplane hyperplane_;
  TouchReach reach_;
  BrickBox within_;
};

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// A volume turned in space-time, with one of its spatial axes in the place of time. Its time slices are the
// axis slices of the volume, with everything that holds for time slices.
#pragma once

#include <map>

#include "points/sample_source.h"

namespace bccsplat {

// The axes of the turned volume, as axes of the volume: the others in order, then `axis` (0, 1 or 2).
[[nodiscard]] std::array<size_t, 4> turned_axes(size_t axis);
// D4* and 4D CC map onto themselves. The lattice must have more than one plane of samples along the axis, and
// time. What is periodic stays so.
[[nodiscard]] Lattice4 turned_lattice(const Lattice4& lattice, size_t axis);

// Planes first .. last of the axis, read once and held in memory; no other layer may be asked for. Along a
// periodic axis they may be counted on beyond its ends.
class TurnedSamples final : public SampleSource {
 public:
  TurnedSamples(const SampleSource& source, int channel, size_t axis, int32_t first, int32_t last,
                const Context& context);

  const Lattice4& lattice() const override { return lattice_; }
  int channels() const override { return 1; }
  float air(int) const override { return air_; }
  float base(int) const override { return base_; }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;

 private:
  Lattice4 lattice_;
  float air_, base_;
  std::map<int32_t, BrickLayer> layers_;
  Reservation memory_;
};

} // namespace bccsplat

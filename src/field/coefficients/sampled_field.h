// SPDX-License-Identifier: Apache-2.0
// The samples of a volume that stores coefficients: the field of its own kernel at the sites. Other kernels
// and axis slices, whose prefilters start from samples, read them in place of those of a file.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "kernel/kernel.h"
#include "points/sample_source.h"

namespace bccsplat {

class SampledField final : public SampleSource {
 public:
  // stored: holds coefficients; it must outlive the object. kernel: the one they belong to, in its form for
  // the lattice. prune: samples up to this magnitude (value units) are dropped; 0 keeps all that are not
  // zero.
  SampledField(const SampleSource& stored, const Kernel& kernel, float prune);

  const Lattice4& lattice() const override { return stored_.lattice(); }
  int channels() const override { return stored_.channels(); }
  float air(int channel) const override { return stored_.air(channel); }
  float base(int channel) const override { return stored_.base(channel); }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;
  // Each stored layer is read once for all of these.
  void read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                   const Context& context, const TakeLayer<BrickLayer>& take) const override;
  void read_samples(int channel, std::span<const int32_t> layers, const BrickBox& region,
                    const Context& context, const TakeLayer<SampleLayer>& take) const override;
  // Sums at these planes alone, of the stored planes that the kernel reaches from there.
  void read_planes(int channel, std::span<const int32_t> layers, const PlaneRange& planes,
                   const Context& context, const TakeLayer<BrickLayer>& take) const override;
  void list_reads(std::span<const int32_t> layers, const BrickBox& region, LayerReads& out) const override;
  void list_planes(std::span<const int32_t> layers, const PlaneRange& planes, LayerReads& out) const override;
  const std::string& coefficient_kernel() const override { return none_; }

  // A coefficient's share of a sample: of the layer `layer` further on, at sites this many planes away.
  struct Tap {
    int layer;
    Int3 planes;
    float weight;
  };

 private:
  // What is summed: the sites of a region that lie on some planes.
  struct Wanted {
    BrickBox region;
    PlaneRange planes;
  };
  void read(int channel, std::span<const int32_t> layers, const Wanted& wanted, const BrickBox& stored,
            const Context& context, const TakeLayer<BrickLayer>& take) const;
  // The stored bricks that sums at these planes depend on.
  [[nodiscard]] BrickBox stored_around(const PlaneRange& planes) const;
  [[nodiscard]] BrickLayer make(int32_t layer, const Wanted& wanted,
                                const std::map<int32_t, BrickLayer>& stored, const Context& context) const;

  const SampleSource& stored_;
  std::vector<Tap> taps_; // by layer
  float prune_;
  std::string none_;
};

} // namespace bccsplat

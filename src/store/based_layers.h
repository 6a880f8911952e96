// SPDX-License-Identifier: Apache-2.0
// The layers of a channel under way relative to the base that its field will have
// (formats/bcc4/field_base.h), as far as those seen so far tell.
#pragma once

#include <cstdint>

#include "fit/kept/histogram.h"
#include "formats/bcc4/field_base.h"
#include "store/layer_window.h"

namespace bccsplat {

class BasedLayers final : public SampleSource {
 public:
  // The window must outlive this.
  explicit BasedLayers(const LayerWindow& window)
      : window_(window), seen_({ValueType::f32, 1, window.air(0), window.air(0)}) {}

  // Takes note of every layer of the channel.
  void see(const SampleLayer& layer);
  // Returns whether the base will be another than air.
  [[nodiscard]] bool far_from_air() const;
  // From here on the base is the median of what was seen.
  void settle();

  const Lattice4& lattice() const override { return window_.lattice(); }
  int channels() const override { return 1; }
  float air(int channel) const override { return window_.air(channel); }
  double sample_step(int channel) const override { return window_.sample_step(channel); }
  float base(int) const override { return base_; }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;

 private:
  [[nodiscard]] StoredValues values() const;

  const LayerWindow& window_;
  uint64_t sites_ = 0, kept_ = 0;
  SampleHistogram seen_;
  float base_ = 0;
};

} // namespace bccsplat

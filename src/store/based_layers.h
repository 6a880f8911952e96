// SPDX-License-Identifier: Apache-2.0
// The layers of a channel under way relative to the base that its field will have
// (formats/bcc4/field_base.h), as far as those seen so far tell: once a site is left out, or air is near, it
// stays so.
#pragma once

#include <optional>
#include <string>

#include "fit/layer_window.h"
#include "points/values.h"

namespace bccsplat {

class BasedLayers final : public SampleSource {
 public:
  // The window must outlive this.
  explicit BasedLayers(const LayerWindow& window) : window_(window) {}

  // Takes note of every layer of the channel.
  void see(const BrickLayer& layer);
  // Whether the base will be another than air.
  [[nodiscard]] bool far_from_air() const;
  // From here on the base is the middle of what was seen.
  void settle();

  const Lattice4& lattice() const override { return window_.lattice(); }
  int channels() const override { return 1; }
  float air(int channel) const override { return window_.air(channel); }
  float base(int) const override { return base_; }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;
  const std::string& coefficient_kernel() const override { return window_.coefficient_kernel(); }

 private:
  const LayerWindow& window_;
  bool whole_ = true;         // all sites were kept
  std::optional<Range> seen_; // of values, absolute
  float base_ = 0;
};

} // namespace bccsplat

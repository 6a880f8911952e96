// SPDX-License-Identifier: Apache-2.0
// What the parts of a series hold together, before they are joined.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/memory.h"
#include "formats/bcc4/read/samples.h"
#include "store/join.h"

namespace bccsplat {

class JoinedSamples final : public SampleSource {
 public:
  // Joins one level of the parts. Keeps up to cache_bytes of chunks, within the budget.
  JoinedSamples(const SeriesParts& parts, int level, MemoryBudget& budget, uint64_t cache_bytes);

  const Lattice4& lattice() const override { return first().lattice(); }
  int channels() const override { return first().channels(); }
  float air(int channel) const override { return first().air(channel); }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& region,
                        const Context& context) const override;
  void read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                   const Context& context, const TakeLayer<BrickLayer>& take) const override;

 private:
  struct Part {
    BrickBox bricks; // which it has; others are air in it
    std::unique_ptr<Bcc4Samples> samples;
  };
  [[nodiscard]] const Bcc4Samples& first() const { return *parts_.front().samples; }

  std::vector<Part> parts_;
};

} // namespace bccsplat

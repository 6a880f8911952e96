// SPDX-License-Identifier: Apache-2.0
// Moments of a series on the GPU: layers of coefficients, and what is merged of them by their weights.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "field/moment.h"
#include "gpu/field_bricks.h"
#include "gpu/gpu_bricks.h"
#include "gpu/gpu_programs.h"

namespace bccsplat {

using GpuLayerKey = std::pair<uint64_t, int32_t>; // series, and layer of it

// What is made of a moment at any of its weights: the places of bricks, and bounds of the field.
struct GpuMomentKey {
  std::vector<GpuLayerKey> layers; // none: of a slice that is no moment
  float most = 0;                  // MomentPlan::largest_weight()
  bool operator==(const GpuMomentKey&) const = default;
};

struct GpuLayer {
  GpuLayerKey key;
  size_t coset = 0;
  LayerBricks bricks; // without their values
  uint64_t bytes = 0; // on the GPU
  std::optional<GpuBricks> sites;
};

[[nodiscard]] GpuMomentKey key_of(const MomentPlan& moment, const std::vector<const GpuLayer*>& layers);

// Sites merged of layers.
class GpuMoment {
 public:
  // bricks: as moment_bricks() makes them.
  GpuMoment(const FieldBricks& bricks, const std::vector<const GpuLayer*>& layers);
  [[nodiscard]] size_t bricks() const { return count_; }
  // Sets the sites of bricks from `first` on to the sum of the layers, unless they are that already. Returns
  // whether it did anything.
  bool merge(GpuPrograms& programs, const std::vector<const GpuLayer*>& layers,
             const std::vector<float>& weights, const GpuBricks& sites, size_t first = 0);

 private:
  void merge_buffers(GpuPrograms& programs, const std::vector<const GpuLayer*>& layers,
                     const GpuBricks& sites);
  void merge_textures(GpuPrograms& programs, const std::vector<const GpuLayer*>& layers,
                      const GpuBricks& sites);
  // Adds the layers from number `from` on, as many as a shader looks at.
  void draw_textures(GLuint program, const std::vector<const GpuLayer*>& layers, size_t from,
                     const GpuBricks& sites) const;

  size_t count_;               // bricks
  size_t first_ = 0;           // of them, in the sites
  std::vector<uint32_t> from_; // by layer and brick: its place in the layer
  GlBuffer from_buffer_;
  GlTexture from_texture_;
  std::vector<float> weights_; // of what the sites are now
};

} // namespace bccsplat

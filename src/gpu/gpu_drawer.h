// SPDX-License-Identifier: Apache-2.0
// Draws shots on a GPU: rays through the slices, whose sites each sample gathers.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "draw/drawer.h"
#include "gpu/gpu_device.h"
#include "gpu/gpu_scene.h"

namespace bccsplat {

class GpuDrawer : public Drawer {
 public:
  // The GPU that shots are drawn by from now on; null: none, and what is kept is dropped.
  void use(std::shared_ptr<GpuDevice> device);

  [[nodiscard]] const char* name() const override { return "gpu"; }
  [[nodiscard]] bool covers(Shots shots) const override;
  [[nodiscard]] bool merges() const override { return true; }
  // Throws GpuFailure, too; nothing was emitted then.
  DrawStats draw(Shots shots, const Context& context,
                 const std::function<void(const TilePixels&)>& emit) override;
  void forget() override {
    if (scene_) scene_->forget();
  }

 private:
  // ends: as packed_ends().
  GpuPixels draw_objects(std::span<const GpuObject> objects, const Shot& shot, TrailCombine combine,
                         const std::vector<float>& ends, const Context& context, DrawStats& stats);
  GpuPixels draw_shots(Shots shots, const Context& context, DrawStats& stats);
  GpuPixels draw_trail(const Shot& shot, const Context& context, DrawStats& stats);

  std::shared_ptr<GpuDevice> device_;
  std::optional<GpuScene> scene_; // of the device
};

} // namespace bccsplat

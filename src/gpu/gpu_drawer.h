// SPDX-License-Identifier: Apache-2.0
// Draws shots on a GPU: rays through the slice, whose sites each sample gathers. It keeps the last two slices
// there, and the layers of a series that moments are merged of.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "draw/drawer.h"
#include "gpu/gpu_device.h"
#include "gpu/gpu_moment.h"
#include "gpu/gpu_objects.h"

namespace bccsplat {

struct GpuPixels; // gpu/gpu_picture.h

class GpuDrawer : public Drawer {
 public:
  GpuDrawer();
  ~GpuDrawer() override;

  // The GPU that shots are drawn by from now on; null: none, and what is kept is dropped.
  void use(std::shared_ptr<GpuDevice> device);

  [[nodiscard]] const char* name() const override { return "gpu"; }
  [[nodiscard]] bool covers(Shots shots) const override;
  [[nodiscard]] bool merges() const override { return true; }
  // Throws GpuFailure, too; nothing was emitted then.
  DrawStats draw(Shots shots, const Context& context,
                 const std::function<void(const TilePixels&)>& emit) override;
  void forget() override;

 private:
  struct Kept; // a slice on the GPU
  Kept& find(const Slice& slice, const Context& context, DrawStats& stats);
  Kept& find_merged(const Slice& slice, const Context& context, DrawStats& stats);
  // Finds a moment whose layers are merged on the GPU.
  Kept& find_moment(const Slice& slice, const MomentPlan& moment, const Context& context, DrawStats& stats);
  Kept& keep(std::unique_ptr<Kept> fresh);
  void drop(std::unique_ptr<Kept>& kept);
  void drop_all();
  GpuPixels draw_pixels(const Shot& shot, const ClassTable& table, Kept& kept, const Context& context);
  GpuPixels draw_slice(const Shot& shot, const Context& context, DrawStats& stats);
  GpuPixels draw_trail(const Shot& shot, const Context& context, DrawStats& stats);
  GpuPixels draw_instances(Shots shots, const Context& context, DrawStats& stats);
  GpuPixels draw_objects(std::span<const GpuObject> objects, const Shot& shot, TrailCombine combine,
                         const std::vector<float>& ends, const Context& context, DrawStats& stats);

  std::shared_ptr<GpuDevice> device_;
  std::array<std::unique_ptr<Kept>, 2> kept_; // the latest first
  GpuLayers layers_;
  GpuObjects objects_;
  uint64_t too_large_ = 0; // a series whose layers find no room
};

} // namespace bccsplat

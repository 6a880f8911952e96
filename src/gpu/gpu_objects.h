// SPDX-License-Identifier: Apache-2.0
// Several slices on a GPU, composited into one picture: a slice and its trail, or several instances. Those of
// the last picture are kept.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/context.h"
#include "draw/stats.h"
#include "gpu/gpu_device.h"
#include "gpu/gpu_moment.h"
#include "gpu/gpu_picture.h"
#include "gpu/object_look.h"

namespace bccsplat {

class GpuObjects {
 public:
  GpuObjects();
  ~GpuObjects();

  // Draws objects that not_as_objects() lets pass; `shot` says what of the picture is asked for, and its
  // target. ends: as packed_ends(). change: how fast each object's field changes (change_at_sites()). Throws
  // GpuFailure, memory_budget, cancelled.
  GpuPixels draw(std::span<const GpuObject> objects, const Shot& shot, TrailCombine combine,
                 const std::vector<float>& ends, std::span<const double> change, GpuDevice& device,
                 GpuLayers& layers, const Context& context, DrawStats& stats);
  void drop(GpuDevice& device);

 private:
  struct Kept;
  // What is on the GPU of the objects; it is made anew where they are not those of the last picture.
  Kept& find(std::span<const GpuObject> objects, GpuDevice& device, GpuLayers& layers, const Context& context,
             DrawStats& stats);
  std::unique_ptr<Kept> kept_;
};

} // namespace bccsplat

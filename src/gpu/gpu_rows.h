// SPDX-License-Identifier: Apache-2.0
// The rows of a picture on a GPU, by jobs that others may come between.
#pragma once

#include <optional>
#include <vector>

#include "base/context.h"
#include "draw/shot.h"
#include "gpu/gpu_device.h"
#include "gpu/gpu_picture.h"

namespace bccsplat {

// Takes a picture off the GPU, on the thread that its objects belong to.
struct EndOnGpu {
  GpuDevice& device;
  std::optional<GpuPicture>& picture;
  ~EndOnGpu() {
    if (picture) device.clear([this] { picture.reset(); });
  }
};

// The host's depths of a picture, packed; empty: none.
[[nodiscard]] std::vector<float> packed_ends(const SheetView& view);

// Bytes here and there of a picture that is read back.
[[nodiscard]] uint64_t picture_bytes(const Shot& shot);

// Draws all rows; returns the pixels, or none where the shot has a target, which they are laid over. Throws
// GpuFailure, cancelled.
[[nodiscard]] GpuPixels draw_all_rows(GpuDevice& device, GpuPicture& picture, const Shot& shot,
                                      const Context& context);

} // namespace bccsplat

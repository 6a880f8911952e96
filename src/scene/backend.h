// SPDX-License-Identifier: Apache-2.0
// What pictures are drawn by: the CPU, a GPU, or whichever is there.
#pragma once

#include <cstdint>
#include <memory>

#include "gpu/gpu_info.h"

namespace bccsplat {

// automatic: by a card where one is found, and where it covers the picture.
enum class Backend : uint8_t { automatic = 1, cpu = 2, gpu = 3 };

class GpuDevice; // gpu/gpu_device.h

// Nothing is opened yet. Null where the library was built without.
[[nodiscard]] std::shared_ptr<GpuDevice> make_gpu(const GpuWishes& wishes);
// Returns what a GPU is, which is opened for it and keeps it. Throws missing_feature where there is none;
// null: as much.
[[nodiscard]] const GpuInfo& gpu_info(GpuDevice* device);
// Returns whether pictures are drawn by it where nobody asks for that; null: false.
[[nodiscard]] bool prefers_gpu(GpuDevice* device);
// Takes note of why a GPU did not draw: what fails for good is not tried again.
void note_failure(GpuDevice* device, const GpuFailure& failure);
// Bytes of slices that are on the GPU now.
[[nodiscard]] uint64_t gpu_bytes(const GpuDevice* device);

} // namespace bccsplat

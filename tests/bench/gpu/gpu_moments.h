// SPDX-License-Identifier: Apache-2.0
// Parts of the suite `gpu`: moments of a series whose layers are on the GPU, and pictures beside the CPU's.
#pragma once

#include <memory>
#include <vector>

#include "gpu/gpu_device.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// A series of drifting smoke with this many samples a side: pictures of new moments between the same layers,
// with nothing to be sent, and of a series that is played, with the decoding and sending of new layers.
[[nodiscard]] std::vector<Row> measure_moments(int samples, int size, const std::shared_ptr<GpuDevice>& gpu,
                                               int rounds);

// Marschner-Lobb in every quality: dB to the truth of the GPU and of the CPU, and of each to the other.
[[nodiscard]] std::vector<Row> compare_with_cpu(const std::shared_ptr<GpuDevice>& gpu, bool quick);

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Equation (6) of Neophytou & Mueller 2002 with the bandwidth of each axis: the mean of the 4D samples around
// a point, weighted by exp(-2 sum ((p - s) / w)^2) within twice the bandwidths w.
#pragma once

#include <cstdint>
#include <span>

#include "base/context.h"
#include "base/vec.h"
#include "points/sample_source.h"

namespace bccsplat {

// Bandwidths along x, y, z and t count in distances of the volume's lattice. Returns how far samples are
// asked for around a point, in index units and frames.
[[nodiscard]] Vec4 gaussian_reach(const Lattice4& lattice, const Vec4& bandwidth);

// Sets values at points (index units) near the domain, relative to the base of the field. Beyond the ends of
// the domain samples are those of the mirror image.
void gaussian_means(const SampleSource& source, int channel, const Vec4& bandwidth,
                    std::span<const Vec4> points, std::span<float> values, const Context& context);

} // namespace bccsplat

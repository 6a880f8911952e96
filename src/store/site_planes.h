// SPDX-License-Identifier: Apache-2.0
// The field at the sites of a layer that are the source's samples. Kernel exact goes through the samples that
// are stored, but for rounding: what a reader gets there needs neither coefficients nor other layers.
#pragma once

#include <cstdint>

#include "base/context.h"
#include "points/sample_layer.h"

namespace bccsplat {

// Fills plane z, x fastest, of a layer of one coset: values in the units of the channel; NaN in holes.
void read_site_plane(const SampleLayer& layer, float air, int64_t z, float* to);
// Returns how far a layer's values are from a base at most; air: relative to it.
[[nodiscard]] float largest_at_sites(const SampleLayer& layer, float air, const Context& context);

// How far a reader's value may be from the stored sample, as a part of the largest distance from the base of
// the field: rounding of coefficients, a third of this of noise (at_sites_test.cpp), and what the prefilter
// leaves out in time (kernel/cc_kernel.cpp).
inline constexpr double exact_rounding = 0x1p-15;

} // namespace bccsplat

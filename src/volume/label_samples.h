// SPDX-License-Identifier: Apache-2.0
// The samples of labels as the file has them, which no field goes through exactly.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/context.h"
#include "field/sample_grid.h"
#include "field/slice_labels.h"
#include "volume/open_slice.h"
#include "volume/open_volume.h"

namespace bccsplat {

// Puts the labels that stand at samples (x, y, z, t) in the place of values there; NaN stays. The lattice is
// the source's own grid.
void read_labels(const OpenVolume& volume, uint32_t channel, std::span<const Vec4> samples,
                 std::span<float> values, const Context& context);
// Uneven axes that a slice through samples stands along in even positions.
[[nodiscard]] EvenPlaces even_places(const OpenSlice& slice);
// Returns the samples of such a slice: its own grid, but along uneven axes in indices.
[[nodiscard]] Grid label_grid(const OpenSlice& slice);
// Returns their labels, x fastest.
[[nodiscard]] std::vector<float> read_labels(const OpenVolume& volume, const OpenSlice& slice,
                                             const Context& context);
// Has the file's cache hold the labels of a frame, or of a box of it: what makes a slice of it lets go of
// them.
void hold_labels(const OpenVolume& volume, uint32_t channel, double frame, const std::optional<IndexBox>& box,
                 const Context& context);

} // namespace bccsplat

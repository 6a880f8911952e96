// SPDX-License-Identifier: Apache-2.0
// How a channel looks where nobody says it.
#pragma once

#include <optional>

#include "scene/picture.h"
#include "shade/look.h"
#include "volume/open_slice.h"
#include "volume/value_counts.h"

namespace bccsplat {

// Returns the transfer function of a slice by the histogram of its channel. Several surfaces are told apart
// by the colours of their values; one has one.
[[nodiscard]] TransferFunction default_function(const OpenVolume& volume, uint32_t channel,
                                                const Slice& slice, const RenderOptions& options);

// Returns the survey for a look of a slice: off the time axis by the values that the slice holds, so that a
// plane through the dark part of a series is no darker than a frame; else that of the channel. Throws
// invalid_argument: labels of too many values.
[[nodiscard]] ValueSurvey survey_of_slice(const OpenVolume& volume, const OpenSlice& slice, Look look);

// Returns the length that a look's opacities are meant for; 0: a mean voxel. A slice through time, or one
// sample thick, is as opaque along its shortest axis as a frame is.
[[nodiscard]] double distance_of_look(const OpenVolume& volume, const Slice& slice);

// Returns the noise of gradients per world length at the volume's own voxels whatever the level, so that
// levels are lit alike. asked: per mean voxel; none: as the file tells.
[[nodiscard]] GradientNoise noise_of(const OpenVolume& volume, const OpenSlice& slice,
                                     const std::optional<double>& asked);

} // namespace bccsplat

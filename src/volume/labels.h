// SPDX-License-Identifier: Apache-2.0
// Channels of labels: numbers of things, which nothing lies between. A point has the label of the sample
// nearest to it, in space and time.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/context.h"
#include "field/slice.h"
#include "slice/part.h"
#include "volume/open_slice.h"
#include "volume/open_volume.h"

namespace bccsplat {

// Returns whether a channel is of labels, kept on the source's own grid, where they come back as they are:
// the file says so, or says nothing and has few whole numbers of an integer source.
[[nodiscard]] bool is_labels(const OpenVolume& volume, uint32_t channel);

// Moves places (x, y, z, t) of index space that lie within the samples onto the nearest ones.
void snap_to_samples(const OpenVolume& volume, std::span<Vec4> points);

// Returns whether a cut shows labels: one along the axes, of a channel of labels, without a mean over
// anything.
[[nodiscard]] bool cuts_labels(const OpenVolume& volume, const SliceRequest& request);
// Returns what is cut where somebody asks for that: labels stand at samples, whose plane and box it is.
[[nodiscard]] SliceRequest as_cut(const OpenVolume& volume, const SliceRequest& request);
// Gives a slice through samples their labels.
void add_labels(OpenSlice& slice, const OpenVolume& volume, const Context& context);

// Returns the cut of a channel of labels at the frame nearest to `frame`, at their own samples.
[[nodiscard]] SliceRequest request_labels(const OpenVolume& volume, uint32_t channel, double frame,
                                          const std::optional<IndexBox>& box);
// Hides of a time slice what lies nearest to a sample whose label is none of these, at the frame nearest to
// `frame`. Reads the box of the slice, or all.
void show_labels_only(Slice& slice, const OpenVolume& volume, uint32_t channel,
                      std::span<const double> labels, double frame, const std::optional<IndexBox>& box,
                      const Context& context);

} // namespace bccsplat

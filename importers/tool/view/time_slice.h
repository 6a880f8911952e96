// SPDX-License-Identifier: Apache-2.0
// Slices by time, and dense samples of a slice some planes at a time.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "readers/frame_reader.h"
#include "tool/handles.h"

namespace bcc4 {

// In as many digits as times have: sums of steps are off by the last ones.
[[nodiscard]] std::string time_text(double time);

// Tells whoever looks at a part of a series that it is one.
void warn_of_part(const Volume& volume, const std::string& path);

// Frame index of "--time T" (in the file's unit), or T itself with --index. Says what times there are when T
// is none.
[[nodiscard]] double frame_index(const Volume& volume, double time, bool index);

// "X0-X1,Y0-Y1,Z0-Z1" of --roi: samples of the source grid from 0, both ends included. Fails where the
// volume has none such.
void check_region(const SampleBox& region, const bccsplat_volume_info& volume);
// Returns the box in samples that bccsplat_slice_options.box takes.
[[nodiscard]] std::optional<std::array<double, 6>> sample_box(const Volume& volume,
                                                              const std::optional<SampleBox>& region);

// The time slice at a frame index, fractions allowed, or the part of it in a region.
[[nodiscard]] Slice cut_frame(const Volume& volume, double index, uint32_t channel,
                              const std::optional<SampleBox>& region = {},
                              int32_t motion = BCCSPLAT_MOTION_DEFAULT);
[[nodiscard]] bccsplat_slice_info slice_info(const Slice& slice);

// Samples the slice's box at the source's resolution, or a part of it counted from its first sample, some
// planes at a time: values of planes first_plane .. in order, x fastest.
void sample_planes(const Slice& slice,
                   const std::function<void(uint64_t first_plane, std::span<const float> values)>& take,
                   const std::optional<SampleBox>& part = {});
// The same of a box of the source's samples at a frame index: those of a frame as the file has them, and
// between frames those of a slice.
void sample_frame(const Volume& volume, double index, uint32_t channel, const SampleBox& box,
                  const std::function<void(uint64_t first_plane, std::span<const float> values)>& take,
                  int32_t motion = BCCSPLAT_MOTION_DEFAULT);

} // namespace bcc4

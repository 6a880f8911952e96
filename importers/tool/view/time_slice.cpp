// SPDX-License-Identifier: Apache-2.0
// Cuts slices by time, and reads their samples, or those of a frame as the file has them, some planes at a
// time.
#include "tool/view/time_slice.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "tool/interrupt.h"

namespace bcc4 {
namespace {

constexpr uint64_t kValuesAtOnce = uint64_t{1} << 24;      // sampled at a time
constexpr uint64_t kFrameValuesAtOnce = uint64_t{1} << 26; // read at a time

} // namespace

std::string time_text(double time) { return short_number(time, 12); }

void warn_of_part(const Volume& volume, const std::string& path) {
  const bccsplat_volume_info v = volume_info(volume);
  if (v.part_end == 0) return;
  std::fprintf(
      stderr,
      "bcc4: warning: %s: a part of a series, frames %llu to %llu: others, and moments near its ends, "
      "lack what other parts hold; bcc4 concat joins them\n",
      path.c_str(), static_cast<unsigned long long>(v.part_first),
      static_cast<unsigned long long>(v.part_end - 1));
}

double frame_index(const Volume& volume, double time, bool index) {
  const bccsplat_volume_info info = volume_info(volume);
  if (index) {
    const double last = last_index(info);
    if (!(time >= 0 && time <= last)) fail_usage("--index --time ", time, ": the frames are 0 to ", last);
    return time;
  }
  double frame = 0;
  const bccsplat_status status = bccsplat_volume_time_to_index(volume.get(), time, &frame);
  if (status == BCCSPLAT_ERROR_OUT_OF_DOMAIN || status == BCCSPLAT_ERROR_INVALID_ARGUMENT)
    fail_usage("--time ", time, ": the series runs from ", time_text(info.time_first), " to ",
               time_text(info.time_end), *info.time_unit ? concat(" ", info.time_unit) : "",
               " (--index takes frame numbers)");
  check(status, "--time");
  return frame;
}

void check_region(const SampleBox& region, const bccsplat_volume_info& v) {
  for (size_t i = 0; i < 3; ++i)
    if (region.begin[i] + region.dims[i] > v.dims[i])
      fail_usage("--roi: samples ", region.begin[i], " to ", region.begin[i] + region.dims[i] - 1, " along ",
                 "xyz"[i], ", the file has 0 to ", v.dims[i] - 1);
}

std::optional<std::array<double, 6>> sample_box(const Volume& volume,
                                                const std::optional<SampleBox>& region) {
  if (!region) return std::nullopt;
  check_region(*region, volume_info(volume));
  std::array<double, 6> box{};
  for (size_t a = 0; a < 3; ++a) {
    box[a] = static_cast<double>(region->begin[a]);
    box[a + 3] = static_cast<double>(region->begin[a] + region->dims[a] - 1);
  }
  return box;
}

Slice cut_frame(const Volume& volume, double index, uint32_t channel, const std::optional<SampleBox>& region,
                int32_t motion) {
  auto hyperplane = sized<bccsplat_hyperplane>();
  hyperplane.d = 1;
  hyperplane.e = -index;
  auto options = sized<bccsplat_slice_options>();
  options.channel = channel, options.motion = motion;
  const auto box = sample_box(volume, region);
  if (box) options.box = box->data();
  options.cancel_token = interrupt_token();
  bccsplat_slice* slice = nullptr;
  check(bccsplat_slice_create(volume.get(), &hyperplane, &options, &slice), "slice");
  return Slice(slice);
}

bccsplat_slice_info slice_info(const Slice& slice) {
  auto info = sized<bccsplat_slice_info>();
  check(bccsplat_slice_get_info(slice.get(), &info), "slice");
  return info;
}

void sample_planes(const Slice& slice, const std::function<void(uint64_t, std::span<const float>)>& take,
                   const std::optional<SampleBox>& part) {
  const bccsplat_slice_info info = slice_info(slice);
  SampleBox box;
  std::copy(info.dims, info.dims + 3, box.dims.begin());
  if (part) box = *part;
  const uint64_t plane = box.dims[0] * box.dims[1];
  if (plane == 0 || box.dims[2] == 0) return;
  const uint64_t step = std::clamp<uint64_t>(kValuesAtOnce / plane, 1, box.dims[2]);
  std::vector<float> values(plane * step);
  for (uint64_t z = 0; z < box.dims[2]; z += step) {
    stop_if_interrupted();
    auto grid = sized<bccsplat_grid>();
    for (size_t a = 0; a < 3; ++a) {
      grid.origin[a] = info.extent[a][0] + static_cast<double>(box.begin[a]);
      grid.step[a] = 1;
      grid.dims[a] = box.dims[a];
    }
    grid.origin[2] += static_cast<double>(z);
    grid.dims[2] = std::min(step, box.dims[2] - z);
    const std::span<float> some = std::span(values).first(plane * grid.dims[2]);
    check(bccsplat_slice_sample_grid(slice.get(), &grid, some.data()), "slice");
    take(z, some);
  }
}

void sample_frame(const Volume& volume, double index, uint32_t channel, const SampleBox& box,
                  const std::function<void(uint64_t, std::span<const float>)>& take, int32_t motion) {
  const bccsplat_volume_info v = volume_info(volume);
  const auto frame = static_cast<uint64_t>(index);
  if (static_cast<double>(frame) != index || frame >= v.dims[3]) {
    // What follows the motion is all of a moment, of which a box is sampled.
    if (motion == BCCSPLAT_MOTION_ON)
      return sample_planes(cut_frame(volume, index, channel, std::nullopt, motion), take, box);
    const bool whole = std::equal(box.dims.begin(), box.dims.end(), v.dims);
    // A periodic axis without sample 0 once more.
    sample_planes(cut_frame(volume, index, channel, whole ? std::nullopt : std::optional(box)), take,
                  SampleBox{{0, 0, 0}, box.dims});
    return;
  }
  const uint64_t plane = box.dims[0] * box.dims[1];
  const uint64_t step = std::clamp<uint64_t>(kFrameValuesAtOnce / plane, 1, box.dims[2]);
  std::vector<float> values(plane * step);
  for (uint64_t z = 0; z < box.dims[2]; z += step) {
    stop_if_interrupted();
    const uint64_t planes = std::min(step, box.dims[2] - z);
    const uint64_t begin[] = {box.begin[0], box.begin[1], box.begin[2] + z},
                   end[] = {box.begin[0] + box.dims[0], box.begin[1] + box.dims[1], begin[2] + planes};
    check(bccsplat_volume_read_frame(volume.get(), channel, frame, begin, end, values.data()), "frame");
    take(z, std::span(values).first(plane * planes));
  }
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
#include "choose/frame_samples.h"

namespace bccsplat::series {
namespace {

Slice cut_frame(const Volume& volume, uint64_t frame, uint32_t channel, bccsplat_cancel_token* token) {
  auto hyperplane = sized<bccsplat_hyperplane>();
  hyperplane.d = 1, hyperplane.e = -static_cast<double>(frame);
  auto options = sized<bccsplat_slice_options>();
  options.channel = channel, options.cancel_token = token;
  bccsplat_slice* slice = nullptr;
  check(bccsplat_slice_create(volume.get(), &hyperplane, &options, &slice), "slice");
  return Slice(slice);
}

} // namespace

void sample_frame(const Volume& volume, uint64_t frame, uint32_t channel, const SampleBox& box,
                  bccsplat_cancel_token* token, std::span<float> values) {
  if (box.samples() == 0) return;
  const Slice slice = cut_frame(volume, frame, channel, token);
  auto info = sized<bccsplat_slice_info>();
  check(bccsplat_slice_get_info(slice.get(), &info), "slice");
  auto grid = sized<bccsplat_grid>();
  for (size_t a = 0; a < 3; ++a) {
    grid.origin[a] = info.extent[a][0] + static_cast<double>(box.begin[a]);
    grid.step[a] = 1;
    grid.dims[a] = box.dims[a];
  }
  check(bccsplat_slice_sample_grid(slice.get(), &grid, values.data()), "slice");
}

} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
#include "tool/output/stored_sites.h"

#include <algorithm>
#include <cmath>

#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

// A Gaussian that is cut off and weights samples as they are: its sum is air where there are none.
constexpr const char* kKernel = "paper";

bool leaves_air(const Volume& volume, uint32_t channel) {
  const bccsplat_volume_info v = volume_info(volume);
  const bccsplat_channel_info c = channel_info(volume, channel);
  return v.store != BCCSPLAT_STORE_COEFFICIENTS && c.error_bound == 0 && c.sites_kept < v.sites_total;
}

// What differs from air by no more is air as the file stores values: half of a step, or what the import took
// for air; of fields that are mostly stored nothing.
float least_difference(const bccsplat_volume_info& v, const bccsplat_channel_info& c) {
  constexpr double mostly = 0.75;
  if (static_cast<double>(c.sites_kept) > mostly * static_cast<double>(v.sites_total)) return 0;
  const bool steps = c.value_type == BCCSPLAT_TYPE_U8 || c.value_type == BCCSPLAT_TYPE_U16;
  return static_cast<float>(std::max(c.air_threshold, steps ? c.value_scale / 2 : 0));
}

} // namespace

StoredSites::StoredSites(const Device& device, const std::string& path, uint32_t channel)
    : channel_(channel) {
  Volume volume = open_volume(device, path, "");
  air_ = static_cast<float>(channel_info(volume, channel).air);
  if (volume_info(volume).lattice != BCCSPLAT_LATTICE_CC && leaves_air(volume, channel))
    volume_ = open_volume(device, path, kKernel);
  least_ = least_difference(volume_info(volume), channel_info(volume, channel));
}

void StoredSites::move_to(double index, const std::optional<SampleBox>& region) {
  if (volume_) slice_ = cut_frame(*volume_, index, channel_, region);
}

void StoredSites::clear(uint64_t first_plane, const std::array<uint64_t, 3>& dims,
                        std::span<float> values) const {
  if (!slice_) return;
  const uint64_t plane = dims[0] * dims[1];
  const SampleBox box{{0, 0, first_plane}, {dims[0], dims[1], values.size() / plane}};
  sample_planes(
      *slice_,
      [&](uint64_t z, std::span<const float> near) {
        for (size_t i = 0; i < near.size(); ++i)
          if (float& value = values[z * plane + i]; near[i] == air_ || std::abs(value - air_) <= least_)
            value = air_;
      },
      box);
}

} // namespace bcc4

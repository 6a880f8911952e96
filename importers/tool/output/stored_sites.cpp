// SPDX-License-Identifier: Apache-2.0
#include "tool/output/stored_sites.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

constexpr const char* kKernel = "paper"; // weights samples as they are
// Distances of the lattice. Smoke with faint edges has less than 2e-4 of its range beyond.
constexpr double kNear = 1.5;

// Is every source sample a site?
bool on_source_grid(const bccsplat_volume_info& v) {
  const auto [least, most] = std::minmax({v.scales[0], v.scales[1], v.scales[2]});
  return v.lattice == BCCSPLAT_LATTICE_CC && least == 1 && most == 1;
}

// Whether the source is air wherever a site is not stored. With corrections that holds only where samples are
// sites: samples of air then have no correction.
bool leaves_air(const bccsplat_volume_info& v, const bccsplat_channel_info& c) {
  return v.periodic_axes == 0 && c.sites_kept < v.sites_total &&
         (c.error_bound == 0 || (v.store == BCCSPLAT_STORE_WAVELETS && on_source_grid(v)));
}

// What differs from air by no more is air as the file stores values: half of a step, or what the import took
// for air; of fields that are mostly stored nothing.
float least_difference(const bccsplat_volume_info& v, const bccsplat_channel_info& c) {
  constexpr double mostly = 0.75;
  if (c.error_bound > 0) return 0;
  if (static_cast<double>(c.sites_kept) > mostly * static_cast<double>(v.sites_total)) return 0;
  const bool steps = c.value_type == BCCSPLAT_TYPE_U8 || c.value_type == BCCSPLAT_TYPE_U16;
  return static_cast<float>(std::max(c.air_threshold, steps ? c.value_scale / 2 : 0));
}

// How far a stored site may be from a sample that is not air.
double reach_of(const bccsplat_volume_info& v) {
  constexpr double own = 0.5; // on the source's grid
  const double scale = std::max({1.0, v.scales[0], v.scales[1], v.scales[2]});
  return on_source_grid(v) ? own : kNear * scale;
}

// The stored sites of a slice: places in samples of the whole frame.
std::vector<float> places_of(const Slice& slice) {
  uint64_t count = 0;
  check(bccsplat_slice_get_points(slice.get(), 0, nullptr, nullptr, &count), "slice");
  std::vector<float> places(3 * count);
  check(bccsplat_slice_get_points(slice.get(), count, places.data(), nullptr, nullptr), "slice");
  return places;
}

// The samples of a box that are near a site.
class NearSites {
 public:
  NearSites(const SampleBox& box, double reach) : box_(box), reach_(reach), near_(box.samples()) {}

  void mark(const float* place) {
    std::array<int64_t, 3> from{}, to{};
    for (size_t a = 0; a < 3; ++a) {
      const double at = place[a] - static_cast<double>(box_.begin[a]);
      from[a] = std::max<int64_t>(0, static_cast<int64_t>(std::ceil(at - reach_)));
      to[a] = std::min(static_cast<int64_t>(box_.dims[a]) - 1, static_cast<int64_t>(std::floor(at + reach_)));
    }
    for (int64_t z = from[2]; z <= to[2]; ++z)
      for (int64_t y = from[1]; y <= to[1]; ++y)
        for (int64_t x = from[0]; x <= to[0]; ++x)
          if (squared_distance({x, y, z}, place) <= reach_ * reach_)
            near_[x + box_.dims[0] * (y + box_.dims[1] * z)] = 1;
  }
  [[nodiscard]] bool operator[](size_t i) const { return near_[i] != 0; }

 private:
  [[nodiscard]] double squared_distance(const std::array<int64_t, 3>& i, const float* place) const {
    std::array<double, 3> d{};
    for (size_t a = 0; a < 3; ++a)
      d[a] = static_cast<double>(i[a]) + static_cast<double>(box_.begin[a]) - place[a];
    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  }
  SampleBox box_;
  double reach_;
  std::vector<uint8_t> near_;
};

} // namespace

StoredSites::StoredSites(const Device& device, const std::string& path, uint32_t channel)
    : channel_(channel) {
  const Volume volume = open_volume(device, path, "");
  const bccsplat_volume_info v = volume_info(volume);
  const bccsplat_channel_info c = channel_info(volume, channel);
  air_ = static_cast<float>(c.air);
  least_ = least_difference(v, c);
  reach_ = reach_of(v);
  if (leaves_air(v, c)) volume_ = open_volume(device, path, kKernel);
}

void StoredSites::clear(double index, const SampleBox& region, uint64_t first_plane,
                        std::span<float> values) const {
  if (!volume_) return;
  SampleBox box = region;
  box.begin[2] += first_plane;
  box.dims[2] = values.size() / (box.dims[0] * box.dims[1]);
  const std::vector<float> places = places_of(cut_frame(*volume_, index, channel_, box));
  NearSites near(box, reach_);
  for (size_t i = 0; i < places.size(); i += 3) near.mark(&places[i]);
  for (size_t i = 0; i < values.size(); ++i)
    if (const bool air = !near[i] || std::abs(values[i] - air_) <= least_; air && !std::isnan(values[i]))
      values[i] = air_;
}

} // namespace bcc4

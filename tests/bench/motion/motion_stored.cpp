// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/motion/motion_stored.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/bench/report.h"

namespace bccsplat::bench {
namespace {

constexpr int repeats = 3; // of which the least counts

} // namespace

StoredMoments::StoredMoments(const std::string& path) : device_(make_api_device(1)) {
  bccsplat_volume* opened = nullptr;
  api(bccsplat_volume_open_file(device_.get(), path.c_str(), nullptr, &opened));
  volume_.reset(opened);
}

Handle<bccsplat_slice> StoredMoments::slice(double index, bccsplat_motion motion) const {
  auto plane = host::sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -index;
  auto options = host::sized<bccsplat_slice_options>();
  options.motion = motion;
  bccsplat_slice* made = nullptr;
  api(bccsplat_slice_create(volume_.get(), &plane, &options, &made));
  return Handle<bccsplat_slice>(made);
}

motion::Box StoredMoments::moment(double index, bccsplat_motion motion) const {
  const Handle<bccsplat_slice> made = slice(index, motion);
  const bccsplat_slice_info info = info_of(made.get());
  motion::Box box;
  for (size_t a = 0; a < 3; ++a) box.dims[a] = static_cast<int32_t>(info.dims[a]);
  box.values.resize(info.dims[0] * info.dims[1] * info.dims[2]);
  api(bccsplat_slice_sample_grid(made.get(), nullptr, box.values.data()));
  for (float& v : box.values)
    if (!std::isfinite(v)) v = 0; // missing
  return box;
}

double StoredMoments::seconds(double index, bccsplat_motion motion) const {
  return cpu_seconds([&] { (void)slice(index, motion); });
}

MomentSeconds moment_seconds(const std::string& path, double index, double last) {
  MomentSeconds least{INFINITY, INFINITY};
  for (int i = 0; i < repeats; ++i) {
    const StoredMoments volume(path);
    least.first = std::min(least.first, volume.seconds(index));
    least.next = std::min(least.next, volume.seconds(std::min(index + .5, last)));
  }
  return least;
}

double following_seconds(const std::string& path, double index) {
  const StoredMoments volume(path);
  (void)volume.seconds(index, BCCSPLAT_MOTION_ON);
  double least = INFINITY;
  for (int i = 0; i < repeats; ++i) least = std::min(least, volume.seconds(index, BCCSPLAT_MOTION_ON));
  return least;
}

double four_frames_seconds(const std::string& path, double index, double last) {
  double least = INFINITY;
  for (int i = 0; i < repeats; ++i) {
    const StoredMoments volume(path);
    double sum = 0;
    for (const int away : {-1, 0, 1, 2})
      sum += volume.seconds(std::clamp(std::floor(index) + away, 0.0, last));
    least = std::min(least, sum);
  }
  return least;
}

} // namespace bccsplat::bench

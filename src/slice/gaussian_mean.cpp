// SPDX-License-Identifier: Apache-2.0
// Goes through the layers of the volume and adds what each holds around every point.
#include "slice/gaussian_mean.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slice/extraction_gaussian.h"

namespace bccsplat {
namespace {

struct Sum {
  double value = 0, weight = 0;
};

// What turns distances in index units into those that the Gaussian is round in.
Vec4 scales_of(const Lattice4& lattice, const Vec4& bandwidth) {
  const Vec3 unit = lattice.lattice_unit();
  Vec4 scale;
  for (size_t a = 0; a < 4; ++a)
    scale[a] = (a < 3 ? 1 / unit[a] : lattice.layer_distance() / lattice.time_step) / bandwidth[a];
  return scale;
}

// One layer, as a point sees it.
struct LayerAround {
  const Lattice4& lattice;
  const BrickLayer& layer;
  const Vec4& scale;
  double frame; // of the layer

  void add(const Vec4& p, Sum& sum) const {
    const double t = (p[3] - frame) * scale[3], left = paper_reach * paper_reach - t * t;
    if (!(left > 0)) return;
    const int c = layer.coset();
    Vec3 at, step; // of the point in sites, and from site to site
    Int3 first, last;
    for (size_t a = 0; a < 3; ++a) {
      const double pitch = lattice.space_step[a] * (lattice.space.bcc ? 2 : 1);
      at[a] = (p[a] - lattice.plane_position(a, lattice.space.plane(c, 0))) / pitch;
      step[a] = pitch * scale[a];
      first[a] = static_cast<int32_t>(std::ceil(at[a] - std::sqrt(left) / step[a]));
      last[a] = static_cast<int32_t>(std::floor(at[a] + std::sqrt(left) / step[a]));
    }
    for (int32_t z = first[2]; z <= last[2]; ++z)
      for (int32_t y = first[1]; y <= last[1]; ++y) {
        const double dz = (z - at[2]) * step[2], dy = (y - at[1]) * step[1], off = t * t + dz * dz + dy * dy;
        if (!(off < paper_reach * paper_reach)) continue;
        const int32_t row = lattice.space.mirror(1, c, y), plane = lattice.space.mirror(2, c, z);
        for (int32_t x = first[0]; x <= last[0]; ++x) {
          const double dx = (x - at[0]) * step[0], r2 = off + dx * dx;
          if (!(r2 < paper_reach * paper_reach)) continue;
          const double w = std::exp(-paper_gaussian * r2);
          sum.value += w * layer.value(lattice.space.mirror(0, c, x), row, plane), sum.weight += w;
        }
      }
  }
};

} // namespace

Vec4 gaussian_reach(const Lattice4& lattice, const Vec4& bandwidth) {
  const Vec4 scale = scales_of(lattice, bandwidth);
  return {paper_reach / scale[0], paper_reach / scale[1], paper_reach / scale[2], paper_reach / scale[3]};
}

void gaussian_means(const SampleSource& source, int channel, const Vec4& bandwidth,
                    std::span<const Vec4> points, std::span<float> values, const Context& context) {
  if (points.empty()) return;
  const Lattice4& lattice = source.lattice();
  const Vec4 scale = scales_of(lattice, bandwidth);
  const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                               [](const Vec4& a, const Vec4& b) { return a[3] < b[3]; });
  const double reach = paper_reach / scale[3];
  const auto first = static_cast<int32_t>(std::ceil(((*low)[3] - reach) / lattice.time_step)) + lattice.lead;
  const auto last = static_cast<int32_t>(std::floor(((*high)[3] + reach) / lattice.time_step)) + lattice.lead;
  std::vector<Sum> sums(points.size());
  constexpr uint64_t block = 256;
  for (int32_t m = first; m <= last; ++m) {
    context.progress.advance(m - first, last - first + 1);
    const BrickLayer layer = source.read_layer(channel, lattice.mirror_layer(m), {}, context);
    const LayerAround around{lattice, layer, scale, lattice.layer_frame(m)};
    context.tasks.parallel_for((points.size() + block - 1) / block, [&](uint64_t b) {
      context.progress.check();
      for (uint64_t n = b * block; n < std::min<uint64_t>(points.size(), (b + 1) * block); ++n)
        around.add(points[n], sums[n]);
    });
  }
  for (size_t n = 0; n < points.size(); ++n)
    values[n] = sums[n].weight > 0 ? static_cast<float>(sums[n].value / sums[n].weight) : 0;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Finds missing samples, has them filled, and carries the holes over to masks and sites.
#include "fit/resample/holes.h"

#include <algorithm>
#include <cmath>

#include "base/sizes.h"
#include "fit/axis/filter.h"
#include "fit/axis/site_axis.h"
#include "formats/bcc4/coding/mask_runs.h"

namespace bccsplat {
namespace {

using Dims = std::array<int64_t, 3>;

constexpr int64_t margin = 4; // known samples around the missing ones that the fill starts from
} // namespace

bool HoleMap::at(int64_t x, int64_t y, int64_t z) const {
  const std::array<int64_t, 3> p{x, y, z};
  for (size_t a = 0; a < 3; ++a)
    if (p[a] < region.begin[a] || p[a] >= region.end[a]) return false;
  const auto row = (z - region.begin[2]) * region.length(1) + y - region.begin[1];
  return !missing.empty() && missing[row * region.length(0) + x - region.begin[0]];
}

HoleMap HoleMap::copy(MemoryBudget& budget) const {
  HoleMap map;
  if (missing.empty()) return map;
  map.memory = Reservation(budget, missing.size(), "missing data");
  map.region = region, map.missing = missing;
  return map;
}

HoleMap patch_holes(Frame& frame, const FrameScan& scan, const AxisFlags& turning, const FillReach& reach,
                    const Context& context) {
  HoleMap map;
  if (scan.nonfinite_region.empty()) return map;
  const int64_t around = reach.bounded() ? reach.samples() : margin, cell = reach.cell();
  AxisFlags whole{}; // axes that the map goes round
  for (size_t a = 0; a < 3; ++a) {
    const int64_t begin = std::max<int64_t>(scan.nonfinite_region.begin[a] - around, 0);
    map.region.begin[a] = begin / cell * cell;
    map.region.end[a] =
        std::min((scan.nonfinite_region.end[a] + around + cell - 1) / cell * cell, frame.dims()[a]);
    whole[a] = turning[a] && (map.region.begin[a] == 0 || map.region.end[a] == frame.dims()[a]);
    if (whole[a]) map.region.begin[a] = 0, map.region.end[a] = frame.dims()[a];
  }
  map.region = map.region.cut(frame.given());
  const uint64_t samples = map.region.samples();
  constexpr uint64_t kept = 5, working = 19; // bytes: values and mask; of the missing their list and their
                                             // next values, and the coarser levels
  map.memory = Reservation(context.memory, checked_mul(samples, kept), "missing data");
  const Reservation memory(context.memory, checked_mul(samples, working), "filling missing data");
  std::vector<float> values(samples);
  const int64_t row = map.region.length(0);
  frame.read(frame.boxes_in(map.region), map.region, values.data(), row, row * map.region.length(1));
  map.missing.resize(values.size());
  for (size_t i = 0; i < values.size(); ++i) map.missing[i] = !std::isfinite(values[i]);
  fill_missing(values, map.missing, {row, map.region.length(1), map.region.length(2)}, context, whole, reach);
  frame.patch(map.region, std::move(values));
  return map;
}

std::vector<std::byte> mask_runs(const HoleMap& holes, const Dims& dims, const Region& region) {
  MaskRunWriter out;
  const Region& all = holes.region;
  const Region r = all.cut(region);
  for (int64_t z = r.begin[2]; z < r.end[2]; ++z)
    for (int64_t y = r.begin[1]; y < r.end[1]; ++y) {
      const int64_t first = (z - all.begin[2]) * all.length(1) + y - all.begin[1];
      const uint8_t* const row = holes.missing.data() + first * all.length(0) - all.begin[0];
      const uint64_t voxel = (z * dims[1] + y) * dims[0];
      for (int64_t x = r.begin[0]; x < r.end[0]; ++x)
        if (row[x]) out.add(voxel + x, voxel + x + 1);
    }
  return out.finish();
}

namespace {

// Lines of samples side by side: `width` of them, n samples each, `stride` apart.
struct Lines {
  uint8_t* first;
  int64_t n, stride, width;
};

// Clears along lines what lies within `reach` of something clear. Beyond an open end there is nothing, beyond
// another one something clear.
void erode(const Lines& lines, int64_t reach, bool open_begin, bool open_end) {
  std::vector<int64_t> clear(lines.width, open_begin ? -reach - 1 : -1); // the last ones
  const auto pass = [&](int64_t i, const auto& decide) {
    uint8_t* row = lines.first + i * lines.stride;
    for (int64_t x = 0; x < lines.width; ++x) {
      int64_t& last = clear[x];
      if (!(row[x] & 1)) last = i;
      row[x] = decide(row[x], std::abs(i - last) > reach);
    }
  };
  // Bit 1: far enough from what is clear before it.
  for (int64_t i = 0; i < lines.n; ++i)
    pass(i, [](uint8_t v, bool far) { return static_cast<uint8_t>(v | (far ? 2 : 0)); });
  std::fill(clear.begin(), clear.end(), open_end ? lines.n + reach : lines.n);
  for (int64_t i = lines.n; i-- > 0;)
    pass(i, [](uint8_t v, bool far) { return static_cast<uint8_t>(far ? v >> 1 : 0); });
}

} // namespace

HoleMap deep_holes(const HoleMap& holes, const Dims& dims, const Dims& reach, const AxisFlags& turning,
                   const Context& context) {
  HoleMap deep;
  if (holes.missing.empty()) return deep;
  deep.memory = Reservation(context.memory, holes.missing.size(), "missing data");
  deep.region = holes.region, deep.missing = holes.missing;
  const Dims n{holes.region.length(0), holes.region.length(1), holes.region.length(2)};
  const Dims stride{1, n[0], n[0] * n[1]};
  for (size_t a = 0; a < 3; ++a) {
    const size_t b = a == 2 ? 1 : 2; // a task for each index along it
    const bool open_begin = !turning[a] && deep.region.begin[a] == 0,
               open_end = !turning[a] && deep.region.end[a] == dims[a];
    context.tasks.parallel_for(n[b], [&](uint64_t k) {
      context.progress.check();
      uint8_t* first = deep.missing.data() + static_cast<int64_t>(k) * stride[b];
      if (a > 0) return erode({first, n[a], stride[a], n[0]}, reach[a], open_begin, open_end);
      for (int64_t j = 0; j < n[1]; ++j)
        erode({first + j * stride[1], n[0], 1, 1}, reach[0], open_begin, open_end);
    });
  }
  return deep;
}

SiteMasks mark_sites(const HoleMap& holes, const Lattice4& lattice) {
  SiteMasks sites;
  if (holes.missing.empty()) return sites;
  for (int c = 0; c < lattice.space.cosets(); ++c) {
    const BrickLayer shape(lattice.space, c);
    auto& masks = sites[c];
    masks.resize(shape.brick_slots());
    // Sites that may be missing, and the sample each is nearest to.
    std::array<std::vector<std::pair<int32_t, int64_t>>, 3> near;
    for (size_t a = 0; a < 3; ++a) {
      const std::vector<double> positions = site_positions(lattice, c, a);
      for (size_t i = 0; i < positions.size(); ++i) {
        const int64_t beyond = lattice.turns(a) ? 1 : 0;
        const int64_t sample =
            lattice.turned_sample(a, nearest_sample(positions[i], lattice.dims[a] + beyond));
        if (sample >= holes.region.begin[a] && sample < holes.region.end[a])
          near[a].push_back({static_cast<int32_t>(i), sample});
      }
    }
    for (const auto& [k, z] : near[2])
      for (const auto& [j, y] : near[1])
        for (const auto& [i, x] : near[0]) {
          if (!holes.at(x, y, z)) continue;
          auto& mask = masks[shape.slot(i / brick_edge, j / brick_edge, k / brick_edge)];
          if (!mask) mask = std::make_unique<BrickMask>();
          auto& bits = (*mask)[k % brick_edge * brick_edge + j % brick_edge];
          bits = static_cast<uint16_t>(bits | 1u << (i % brick_edge));
        }
  }
  return sites;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Fills missing samples by a pyramid of means, relaxed on every level, and carries the holes over to the
// sites.
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
// Steps towards the mean of the neighbours on each level: more are smoother, each passes once over what is
// missing.
constexpr int relaxations = 12;

size_t volume(const Dims& n) { return static_cast<size_t>(n[0]) * n[1] * n[2]; }
size_t at(const Dims& n, int64_t x, int64_t y, int64_t z) { return (z * n[1] + y) * n[0] + x; }

struct Level {
  Dims dims;
  std::vector<float> value;
  std::vector<uint8_t> missing;
};

Level coarser(std::span<const float> value, std::span<const uint8_t> missing, const Dims& n) {
  Level c;
  for (size_t a = 0; a < 3; ++a) c.dims[a] = (n[a] + 1) / 2;
  c.value.resize(volume(c.dims));
  c.missing.resize(c.value.size());
  for (int64_t z = 0; z < c.dims[2]; ++z)
    for (int64_t y = 0; y < c.dims[1]; ++y)
      for (int64_t x = 0; x < c.dims[0]; ++x) {
        double sum = 0;
        int known = 0;
        for (int64_t k = 2 * z; k < std::min(2 * z + 2, n[2]); ++k)
          for (int64_t j = 2 * y; j < std::min(2 * y + 2, n[1]); ++j)
            for (int64_t i = 2 * x; i < std::min(2 * x + 2, n[0]); ++i)
              if (!missing[at(n, i, j, k)]) {
                sum += value[at(n, i, j, k)];
                ++known;
              }
        c.value[at(c.dims, x, y, z)] = known ? static_cast<float>(sum / known) : 0;
        c.missing[at(c.dims, x, y, z)] = known == 0;
      }
  return c;
}

// A full coarse level, linearly at the centre of fine cell (x, y, z).
float interpolate(const Level& c, const Dims& fine, const AxisFlags& turning) {
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Dims p;
    float weight = 1;
    for (size_t a = 0; a < 3; ++a) {
      const bool far = corner >> a & 1; // the coarse neighbour on the side of the fine cell
      const int64_t side = fine[a] % 2 == 0 ? -1 : 1;
      p[a] = fine[a] / 2 + (far ? side : 0);
      p[a] = turning[a] ? end_index(p[a], c.dims[a], true) : std::clamp<int64_t>(p[a], 0, c.dims[a] - 1);
      weight *= far ? 0.25f : 0.75f;
    }
    sum += weight * c.value[at(c.dims, p[0], p[1], p[2])];
  }
  return sum;
}

// Each missing sample becomes the mean of its neighbours inside the array; all at once, so the order does not
// matter.
void relax(std::span<float> value, const std::vector<size_t>& missing, const Dims& n,
           const AxisFlags& turning, const Context& context) {
  constexpr size_t part = 1 << 15;
  std::vector<float> next(missing.size());
  const auto parts = (missing.size() + part - 1) / part;
  const auto for_parts = [&](const auto& body) {
    context.tasks.parallel_for(parts, [&](uint64_t p) {
      context.progress.check();
      for (size_t m = p * part; m < std::min(missing.size(), (p + 1) * part); ++m) body(m);
    });
  };
  const auto row = static_cast<size_t>(n[0]), plane = row * n[1];
  for (int r = 0; r < relaxations; ++r) {
    for_parts([&](size_t m) {
      const size_t i = missing[m];
      const Dims p{static_cast<int64_t>(i % row), static_cast<int64_t>(i / row % static_cast<size_t>(n[1])),
                   static_cast<int64_t>(i / plane)};
      const Dims stride{1, n[0], n[0] * n[1]};
      float sum = 0;
      int count = 0;
      for (size_t a = 0; a < 3; ++a)
        for (const int64_t q : {p[a] - 1, p[a] + 1}) {
          if (!turning[a] && (q < 0 || q >= n[a])) continue;
          const int64_t by = end_index(q, n[a], true) - p[a];
          sum += value[static_cast<int64_t>(i) + by * stride[a]], ++count;
        }
      next[m] = count ? sum / static_cast<float>(count) : value[i];
    });
    for_parts([&](size_t m) { value[missing[m]] = next[m]; });
  }
}

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

void fill_missing(std::span<float> values, std::span<const uint8_t> missing, const Dims& dims,
                  const Context& context, const AxisFlags& turning) {
  std::vector<size_t> list;
  for (size_t i = 0; i < missing.size(); ++i)
    if (missing[i]) list.push_back(i);
  if (list.empty()) return;
  if (list.size() == missing.size()) {
    std::fill(values.begin(), values.end(), 0.0f);
    return;
  }
  Level coarse = coarser(values, missing, dims);
  fill_missing(coarse.value, coarse.missing, coarse.dims, context, turning);
  const auto row = static_cast<size_t>(dims[0]), plane = row * dims[1];
  for (const size_t i : list)
    values[i] = interpolate(coarse,
                            {static_cast<int64_t>(i % row), static_cast<int64_t>(i % plane / row),
                             static_cast<int64_t>(i / plane)},
                            turning);
  relax(values, list, dims, turning, context);
}

HoleMap patch_holes(Frame& frame, const FrameScan& scan, const AxisFlags& turning, const Context& context) {
  HoleMap map;
  AxisFlags whole{}; // axes that the map goes round
  if (scan.nonfinite == 0) return map;
  for (size_t a = 0; a < 3; ++a) {
    map.region.begin[a] = std::max<int64_t>(scan.nonfinite_region.begin[a] - margin, 0);
    map.region.end[a] = std::min(scan.nonfinite_region.end[a] + margin, frame.dims()[a]);
    whole[a] = turning[a] && (map.region.begin[a] == 0 || map.region.end[a] == frame.dims()[a]);
    if (whole[a]) map.region.begin[a] = 0, map.region.end[a] = frame.dims()[a];
  }
  // Values and mask, the list of the missing, their next values, and the coarser levels.
  map.memory = Reservation(context.memory, checked_mul(map.region.samples(), 24), "filling missing data");
  std::vector<float> values(map.region.samples());
  const int64_t row = map.region.length(0);
  frame.read(frame.boxes_in(map.region), map.region, values.data(), row, row * map.region.length(1));
  map.missing.resize(values.size());
  for (size_t i = 0; i < values.size(); ++i) map.missing[i] = !std::isfinite(values[i]);
  fill_missing(values, map.missing, {row, map.region.length(1), map.region.length(2)}, context, whole);
  frame.patch(map.region, std::move(values));
  return map;
}

std::vector<std::byte> mask_runs(const HoleMap& holes, const Dims& dims) {
  MaskRunWriter out;
  const Region& r = holes.region;
  const size_t row = r.length(0);
  size_t i = 0;
  for (int64_t z = r.begin[2]; z < r.end[2]; ++z)
    for (int64_t y = r.begin[1]; y < r.end[1]; ++y, i += row) {
      const uint64_t voxel = (z * dims[1] + y) * dims[0] + r.begin[0];
      for (size_t x = 0; x < row; ++x)
        if (holes.missing[i + x]) out.add(voxel + x, voxel + x + 1);
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

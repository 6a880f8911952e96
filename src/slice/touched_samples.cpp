// SPDX-License-Identifier: Apache-2.0
// Finds the rows of bricks of a layer that a hyperplane touches, and reads no others.
#include "slice/touched_samples.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

struct Interval {
  double low, high;
};

// An interval and its images beyond both ends of an axis, cut to what a slice may look at.
struct Images {
  std::array<Interval, 3> at;
  int count = 0;
};

Images images(const std::array<Interval, 3>& all, double low_limit, double high_limit) {
  Images r;
  for (const Interval& i : all) {
    const Interval cut{std::max(i.low, low_limit), std::min(i.high, high_limit)};
    if (cut.low <= cut.high) r.at[r.count++] = cut;
  }
  return r;
}

std::array<Interval, 3> mirrored(const Interval& own, const Interval& mirrors) {
  return {own, Interval{2 * mirrors.low - own.high, 2 * mirrors.low - own.low},
          Interval{2 * mirrors.high - own.high, 2 * mirrors.high - own.low}};
}

std::array<Interval, 3> turned(const Interval& own, double period) {
  return {own, Interval{own.low - period, own.high - period}, Interval{own.low + period, own.high + period}};
}

} // namespace

bool TouchedSamples::touches(int32_t layer, const Int3& begin, const Int3& end) const {
  const Lattice4& lattice = source_.lattice();
  const int coset = lattice.coset(layer);
  std::array<Images, 4> axes;
  for (size_t a = 0; a < 4; ++a) {
    Interval own;
    Interval mirrors{0, 0};
    const bool turns = lattice.turns(a);
    if (a < 3) {
      own = {lattice.plane_position(a, lattice.space.plane(coset, begin[a] * brick_edge)),
             lattice.plane_position(a, lattice.space.plane(coset, end[a] * brick_edge - 1))};
      mirrors = {lattice.plane_position(a, 0), lattice.plane_position(a, lattice.space.last[a])};
    } else {
      own.low = own.high = lattice.layer_frame(layer);
      mirrors = {lattice.layer_frame(0), lattice.layer_frame(lattice.last_layer)};
    }
    own.low -= reach_.samples[a], own.high += reach_.samples[a];
    const double beyond = reach_.mirrored[a] + reach_.half_thickness * std::fabs(hyperplane_[a]);
    axes[a] = images(turns ? turned(own, lattice.domain_end(a)) : mirrored(own, mirrors), -beyond,
                     lattice.domain_end(a) + beyond);
  }
  // The hyperplane's height over a box has its extremes at corners: centre +- half widths.
  for (int i = 0; i < axes[0].count * axes[1].count * axes[2].count * axes[3].count; ++i) {
    double centre = hyperplane_[4], half = reach_.half_thickness + 1e-9;
    int rest = i;
    for (size_t a = 0; a < 4; ++a) {
      const Interval& at = axes[a].at[rest % axes[a].count];
      rest /= axes[a].count;
      centre += hyperplane_[a] * (at.low + at.high) / 2;
      half += std::fabs(hyperplane_[a]) * (at.high - at.low) / 2;
    }
    if (std::fabs(centre) <= half) return true;
  }
  return false;
}

// Bricks are read in rows along x; rows with the same ends are read together.
std::vector<BrickBox> TouchedSamples::boxes(int32_t layer, const BrickBox& region) const {
  std::vector<BrickBox> out;
  const Int3 sites = lattice().space.dims(lattice().coset(layer));
  Int3 begin, end;
  for (size_t a = 0; a < 3; ++a) {
    begin[a] = std::max({0, region.begin[a], within_.begin[a]});
    end[a] = std::min({(sites[a] + brick_edge - 1) / brick_edge, region.end[a], within_.end[a]});
  }
  if (!touches(layer, begin, end)) return out;
  for (int z = begin[2]; z < end[2]; ++z) {
    if (!touches(layer, {begin[0], begin[1], z}, {end[0], end[1], z + 1})) continue;
    BrickBox box{{0, 0, z}, {0, 0, z + 1}};
    bool open = false;
    for (int y = begin[1]; y < end[1]; ++y) {
      int first = end[0], last = begin[0] - 1;
      for (int x = begin[0]; x < end[0]; ++x)
        if (touches(layer, {x, y, z}, {x + 1, y + 1, z + 1})) first = std::min(first, x), last = x;
      const bool same = open && first == box.begin[0] && last + 1 == box.end[0];
      if (open && !same) out.push_back(box);
      if (!same) box.begin = {first, y, z}, box.end = {last + 1, y + 1, z + 1};
      box.end[1] = y + 1;
      open = first <= last;
    }
    if (open) out.push_back(box);
  }
  return out;
}

BrickLayer TouchedSamples::read_layer(int channel, int32_t layer, const BrickBox& region,
                                      const Context& context) const {
  BrickLayer out(lattice().space, lattice().coset(layer));
  for (const BrickBox& box : boxes(layer, region)) {
    const BrickLayer part = source_.read_layer(channel, layer, box, context);
    for (int z = box.begin[2]; z < box.end[2]; ++z)
      for (int y = box.begin[1]; y < box.end[1]; ++y)
        for (int x = box.begin[0]; x < box.end[0]; ++x) {
          const size_t slot = out.slot(x, y, z);
          if (part.brick(slot)) out.set(slot, part.share(slot));
        }
  }
  return out;
}

void TouchedSamples::list_reads(std::span<const int32_t> layers, const BrickBox& region,
                                LayerReads& out) const {
  for (const int32_t m : layers)
    for (const BrickBox& box : boxes(m, region)) source_.list_reads(std::span(&m, 1), box, out);
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Boxes are taken in pieces that gather_box copies.
#include "volume/site_boxes.h"

#include <algorithm>
#include <cmath>

#include "field/footprint/patch.h"

namespace bccsplat {
namespace {

// Calls body(piece, scratch) for pieces of a box that are not all air, in `scratch` x fastest.
template<class Body>
void each_piece(const BrickLayer& layer, const SiteBox& box, std::vector<float>& scratch, const Body& body) {
  constexpr int most = SiteBox::max_rows;
  for (int z = 0; z < box.size[2]; z += most)
    for (int y = 0; y < box.size[1]; y += most)
      for (int x = 0; x < box.size[0]; x += most) {
        const Int3 at{x, y, z};
        SiteBox piece;
        size_t count = 1;
        for (size_t a = 0; a < 3; ++a) {
          piece.origin[a] = box.origin[a] + at[a], piece.size[a] = std::min(most, box.size[a] - at[a]);
          count *= static_cast<size_t>(piece.size[a]);
        }
        if (scratch.size() < count) scratch.resize(count);
        if (gather_box(layer, piece, scratch.data())) body(at, piece, std::span(scratch).first(count));
      }
}

void include(std::array<float, 2>& range, const std::array<float, 2>& other) {
  range = {std::min(range[0], other[0]), std::max(range[1], other[1])};
}

// The sites of a coset that a point of the box, lattice units, depends on.
std::array<Int3, 2> sites_in_reach(const Slice& slice, size_t coset, const std::array<Vec3, 2>& box) {
  const double pitch = coset_pitch(slice.lattice), radius = slice.kernel.space.radius;
  std::array<Int3, 2> sites;
  for (size_t a = 0; a < 3; ++a) {
    const auto [low, high] = std::minmax(box[0][a], box[1][a]);
    const double shift = 0.5 * static_cast<double>(coset);
    sites[0][a] = static_cast<int32_t>(std::ceil((low - radius) / pitch - shift));
    sites[1][a] = static_cast<int32_t>(std::floor((high + radius) / pitch - shift));
  }
  return sites;
}

// What corrections around the box may add, or set where the slice has holes.
void add_corrections(const SliceCorrections& corrections, const std::array<Vec3, 2>& box,
                     std::array<float, 2>& bounds) {
  // Each falls off to the next point of its grid.
  const auto near = [&](const SparseGrid::Brick& b) {
    for (size_t a = 0; a < 3; ++a) {
      const double begin = corrections.origin[a] + b.begin[a];
      if (begin - 1 > box[1][a] || begin + SparseGrid::edge < box[0][a]) return false;
    }
    return true;
  };
  std::array<float, 2> added{};
  for (const SparseGrid::Brick& b : corrections.add.bricks())
    if (near(b)) include(added, {b.low, b.high});
  bounds[0] += added[0], bounds[1] += added[1];
  for (const SparseGrid::Brick& b : corrections.set.bricks())
    if (near(b)) include(bounds, {b.low, b.high});
}

std::array<float, 2> label_bounds(const SliceLabels& labels, const std::array<Vec3, 2>& box) {
  std::array<Int3, 2> samples;
  for (size_t side = 0; side < 2; ++side)
    for (size_t a = 0; a < 3; ++a) samples[side][a] = labels.nearest(a, box[side][a]);
  float low = labels.value(samples[0]), high = low;
  for (int z = samples[0][2]; z <= samples[1][2]; ++z)
    for (int y = samples[0][1]; y <= samples[1][1]; ++y)
      for (int x = samples[0][0]; x <= samples[1][0]; ++x) {
        const float value = labels.value({x, y, z});
        low = std::min(low, value), high = std::max(high, value);
      }
  return {low, high};
}

} // namespace

void gather_sites(const BrickLayer& layer, const SiteBox& box, float* out, std::vector<float>& scratch) {
  const auto nx = static_cast<size_t>(box.size[0]), ny = static_cast<size_t>(box.size[1]);
  std::fill_n(out, nx * ny * static_cast<size_t>(box.size[2]), 0.0f);
  each_piece(layer, box, scratch, [&](const Int3& at, const SiteBox& piece, std::span<const float> from) {
    const auto length = static_cast<size_t>(piece.size[0]);
    for (int z = 0; z < piece.size[2]; ++z)
      for (int y = 0; y < piece.size[1]; ++y, from = from.subspan(length))
        std::copy_n(from.begin(), length,
                    out + (static_cast<size_t>(at[2] + z) * ny + static_cast<size_t>(at[1] + y)) * nx +
                        static_cast<size_t>(at[0]));
  });
}

std::array<float, 2> coefficient_range(const BrickLayer& layer, const std::array<Int3, 2>& sites,
                                       std::vector<float>& scratch) {
  SiteBox box{sites[0], {}};
  for (size_t a = 0; a < 3; ++a) box.size[a] = sites[1][a] - sites[0][a] + 1;
  std::array<float, 2> range{};
  each_piece(layer, box, scratch, [&](const Int3&, const SiteBox&, std::span<const float> values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    include(range, {*low, *high});
  });
  return range;
}

std::array<float, 2> value_bounds(const OpenSlice& slice, const std::array<Vec3, 2>& box,
                                  std::vector<float>& scratch) {
  const Slice& s = slice.slice;
  if (slice.extraction) return {static_cast<float>(slice.bounds()[0]), static_cast<float>(slice.bounds()[1])};
  if (s.labels) return label_bounds(*s.labels, box);
  const Affine3 to_lattice = s.lattice_to_slice.inverse();
  const std::array<Vec3, 2> of_lattice{to_lattice.point(box[0]), to_lattice.point(box[1])};
  std::array<float, 2> range{};
  for (size_t c = 0; c < static_cast<size_t>(s.lattice.cosets()); ++c)
    include(range, coefficient_range(s.coset[c], sites_in_reach(s, c, of_lattice), scratch));
  const auto most = static_cast<float>(largest_site_sum(s.lattice.bcc));
  std::array<float, 2> bounds{s.base + most * range[0], s.base + most * range[1]};
  if (s.corrections) add_corrections(*s.corrections, box, bounds);
  return bounds;
}

} // namespace bccsplat

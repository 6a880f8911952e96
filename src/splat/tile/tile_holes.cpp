// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/tile_holes.h"

#include <algorithm>
#include <optional>

namespace bccsplat {
namespace {

constexpr int smallest_rectangle = 4; // pixels along an edge

// A lattice plane through a slice: one sheet of a view.
class HolesOfSheet {
 public:
  HolesOfSheet(const Slice& slice, const SheetView& view, const SheetArgs& s, uint8_t* hole)
      : slice_(slice), view_(view), s_(s), hole_(hole), k_(s.segment.k) {
    const double scale = view.scale(k_);
    const Affine3& to = slice.lattice_to_slice;
    if (slice.mask)
      mask_.emplace(*slice.mask, to.point(view.sample(0, 0, k_)), to.vector(scale * view.ex),
                    to.vector(scale * view.ey));
  }

  // Returns what is missing in a rectangle of the tile, as far as it is told without a look at each pixel.
  [[nodiscard]] Missing within(const PixelRect& r) const {
    const std::array<double, 2> i{static_cast<double>(s_.tile.x + r.x0),
                                  static_cast<double>(s_.tile.x + r.x1 - 1)},
        j{static_cast<double>(s_.tile.y + r.y0), static_cast<double>(s_.tile.y + r.y1 - 1)};
    const Missing masked = mask_ ? mask_->within(i, j) : Missing::none;
    return masked == Missing::none && !slice_.holes_by_mask ? sites_within(i, j) : masked;
  }

  // Marks a rectangle of which `missing` is known.
  void mark(const PixelRect& r, Missing missing) {
    if (missing != Missing::some) return fill(r, missing == Missing::all ? 1 : 0);
    if (r.x1 - r.x0 <= smallest_rectangle && r.y1 - r.y0 <= smallest_rectangle) return mark_pixels(r);
    PixelRect first = r, second = r;
    if (r.x1 - r.x0 > r.y1 - r.y0)
      first.x1 = second.x0 = (r.x0 + r.x1) / 2;
    else
      first.y1 = second.y0 = (r.y0 + r.y1) / 2;
    mark(first, within(first));
    mark(second, within(second));
  }

 private:
  void fill(const PixelRect& r, uint8_t value) {
    for (int y = r.y0; y < r.y1; ++y) std::fill_n(hole_ + s_.tile.pixel(r.x0, y), r.x1 - r.x0, value);
  }

  void mark_pixels(const PixelRect& r) {
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x) {
        const double i = s_.tile.x + x, j = s_.tile.y + y;
        const size_t p = s_.tile.pixel(x, y);
        hole_[p] =
            segment_weight(s_, p) > 0 && ((mask_ && mask_->missing(i, j)) ||
                                          (!slice_.holes_by_mask && slice_.is_hole(view_.sample(i, j, k_))));
      }
  }

  // Tells of the sites around the points, as lattices of hosts mark them.
  [[nodiscard]] Missing sites_within(const std::array<double, 2>& i, const std::array<double, 2>& j) const {
    const Lattice3& lattice = slice_.lattice;
    const double step = (lattice.bcc ? 2 : 1) * lattice.plane_distance(); // between sites of a coset
    Vec3 low, high;
    for (size_t a = 0; a < 3; ++a) low[a] = high[a] = view_.sample(i[0], j[0], k_)[a];
    for (const Vec3& p :
         {view_.sample(i[1], j[0], k_), view_.sample(i[0], j[1], k_), view_.sample(i[1], j[1], k_)})
      for (size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
    for (int c = 0; c < lattice.cosets(); ++c) {
      const BrickLayer& layer = slice_.coset[c];
      Int3 first, last;
      for (size_t a = 0; a < 3; ++a) {
        // One site more on either side, and no end: beyond it stand mirror images of sites close to it.
        const double from = low[a] / step - 1.5, to = high[a] / step + 1.5;
        const int32_t bricks = layer.brick_dims()[a], sites = layer.dims()[a];
        const double nearest = std::max({from, 0.0}), mirrored = from < 0 ? -from + 1 : 0;
        const double below = to > sites - 1 ? 2.0 * (sites - 1) - to - 1 : sites - 1.0;
        // Beyond the end of a periodic axis lie those at its other end: then all of it is looked at.
        if (lattice.periodic[a] && (from < 0 || to > sites - 1)) {
          first[a] = 0, last[a] = bricks - 1;
          continue;
        }
        first[a] = static_cast<int32_t>(std::clamp(std::min(nearest, below), 0.0, sites - 1.0)) / brick_edge;
        last[a] =
            std::min(bricks - 1,
                     static_cast<int32_t>(std::clamp(std::max(to, mirrored), 0.0, sites - 1.0)) / brick_edge);
      }
      for (int32_t z = first[2]; z <= last[2]; ++z)
        for (int32_t y = first[1]; y <= last[1]; ++y)
          for (int32_t x = first[0]; x <= last[0]; ++x)
            if (const Brick* b = layer.brick(x, y, z); b && b->hole) return Missing::some;
    }
    return Missing::none;
  }

  const Slice& slice_;
  const SheetView& view_;
  const SheetArgs& s_;
  uint8_t* hole_;
  double k_;
  std::optional<MaskPlane> mask_;
};

} // namespace

Missing find_holes(const Slice& slice, const SheetView& view, const SheetArgs& s, uint8_t* hole) {
  const PixelRect seen = s.tile.seen.within(s.tile.width, s.tile.height);
  if (seen.empty()) return Missing::none;
  HolesOfSheet holes(slice, view, s, hole);
  const Missing missing = holes.within(seen);
  if (missing == Missing::some) holes.mark(seen, missing);
  return missing;
}

} // namespace bccsplat

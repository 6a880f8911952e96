// SPDX-License-Identifier: Apache-2.0
// Looks for each value between the sheets that are there, refines what it finds by the field itself, and lays
// the hits of an interval over each other in order of depth. Intervals follow each other along the rays, so
// that a pixel that is finished asks for nothing more.
#include "splat/tile/tile_surfaces.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

// A root may lie this far outside of its ray's part of the domain, sheets: rays are rounded to floats.
constexpr double outside_tolerance = 1e-5;

// The second of two crossings in an interval that ends at sheet number `end`, of which `in` is the first.
Crossing way_out(const Crossing& in, double end) {
  Crossing out = in;
  out.low = in.high, out.high = end, out.value_low = in.value_high, out.value_high = in.value_low;
  return out;
}

} // namespace

TileSurfaces::TileSurfaces(const TileJob& job, const PlannedTile& tile, TileMemory& memory,
                           const SurfaceField& field, const SheetSource& source, const PixelPlanes& pixel)
    : scene_(*job.main), options_(*job.options), plan_(job.objects.front().plan), tile_(tile), m_(memory),
      field_(field), source_(source), pixel_(pixel), view_(*scene_.view),
      loops_(options_.reference_loops ? reference_sheet_loops() : simd_sheet_loops()), time_(*scene_.slice),
      stop_(static_cast<float>(options_.opacity_stop)) {
  const bool all = options_.with_deep && options_.opacity_stop >= 1;
  for (const IsoSurface& s : options_.surfaces)
    surfaces_.push_back({s.value - scene_.slice->base, static_cast<float>(s.value),
                         static_cast<float>(s.opacity), surface_color(s, *scene_.table), all || s.opacity < 1,
                         s.color.has_value()});
  found_.resize(surfaces_.size());
  if (scene_.paint) paint_.emplace(*scene_.paint->slice);
  m_.hits.clear();
}

int TileSurfaces::draw(int64_t first, int64_t end, DrawStats& stats) {
  CrossingArgs c;
  if (!look_at(first, end, stats, c)) return 0;
  find_crossings(c);
  const bool any = std::any_of(found_.begin(), found_.end(), [](const Found& f) { return f.end > f.begin; });
  int closed = 0;
  for (int n = 0; any && n < c.count; ++n) {
    hits_.clear();
    for (uint32_t s = 0; s < surfaces_.size(); ++s) refine(c, s, n);
    if (surfaces_.size() > 1)
      std::stable_sort(hits_.begin(), hits_.end(), [](const Hit& a, const Hit& b) {
        return a.pixel != b.pixel ? a.pixel < b.pixel : a.point.k < b.point.k;
      });
    for (const Hit& hit : hits_) closed += add(hit);
  }
  return closed;
}

// Describes the planes that crossings are looked for in; returns false where nothing is on them.
bool TileSurfaces::look_at(int64_t first, int64_t end, DrawStats& stats, CrossingArgs& c) const {
  const bool skip = !(options_.disable_skips & skip_empty_sheets);
  bool filled = false;
  for (int64_t k = first; k < end; ++k) {
    const bool this_one = source_.filled(k) || source_.filled(k - 1);
    if (skip && !this_one) ++stats.sheets_skipped;
    filled |= this_one;
  }
  if (first >= end || (skip && !filled)) return false;
  c.count = static_cast<int>(end - first), c.k = static_cast<float>(first);
  c.width = tile_.width, c.height = tile_.height, c.pitch = m_.pixel_pitch;
  c.plane_pitch = source_.plane_pitch();
  c.alpha = pixel_.alpha, c.enter = pixel_.enter, c.leave = pixel_.leave;
  c.stop = stop_;
  if (skip) c.seen = {};
  for (int64_t k = first - 2; k <= end; ++k) {
    const int64_t sheet = std::max(k, view_.first_sheet());
    c.plane[k - first + 2] = source_.plane(sheet, 0);
    if (skip) c.seen.include(source_.touched(sheet));
  }
  return true;
}

void TileSurfaces::find_crossings(CrossingArgs& c) {
  const size_t room = tile_.width * tile_.height * CrossingArgs::most;
  size_t used = 0;
  for (size_t s = 0; s < surfaces_.size(); ++s) {
    if (m_.crossings.size() < used + room) m_.crossings.resize(used + room);
    c.target = static_cast<float>(surfaces_[s].target);
    c.found = m_.crossings.data() + used;
    found_[s] = {used, used + loops_.crossings(c)};
    used = found_[s].end;
  }
}

// Returns whether a sample is on the base's side of the surface only because points beyond it are left out.
bool TileSurfaces::lacks_points(double k, int x, int y, float value, float target) const {
  return !plan_.inside.cells.empty() && (value < target) == (target > 0) &&
         plan_.inside.contains(view_.sample(tile_.x + x, tile_.y + y, k));
}

// Appends the hits of one interval, at pixels that no earlier interval has finished.
void TileSurfaces::refine(const CrossingArgs& c, uint32_t surface, int interval) {
  const Surface& s = surfaces_[surface];
  const auto all =
      std::span(m_.crossings).subspan(found_[surface].begin, found_[surface].end - found_[surface].begin);
  const auto k = static_cast<double>(c.k) + interval;
  const auto* const plane = &c.plane[interval];
  const auto target = static_cast<float>(s.target);
  std::vector<Crossing> crossings, grazes;
  for (const SheetCrossing& found : all) {
    const int x = found.x, y = found.y;
    if (found.interval != interval || !(c.alpha[y * c.pitch + x] < c.stop)) continue;
    const std::ptrdiff_t at = y * c.plane_pitch + x;
    const float before = plane[1][at], value = plane[2][at];
    if (lacks_points(k - 1, x, y, before, target) || lacks_points(k, x, y, value, target)) continue;
    (found.grazes ? grazes : crossings)
        .push_back({static_cast<double>(tile_.x + x), static_cast<double>(tile_.y + y), k - 1, k, before,
                    value, 0.5 * (value - plane[0][at]), 0.5 * (plane[3][at] - before),
                    static_cast<uint32_t>(y * c.pitch + x)});
  }
  for (const Crossing& g : find_grazes(field_, view_, s.target, grazes)) {
    crossings.push_back(g);
    if (s.both_ways) crossings.push_back(way_out(g, k));
  }
  const auto points = refine_crossings(field_, view_, s.target, crossings, root_tolerance);
  const size_t before = hits_.size();
  for (size_t n = 0; n < points.size(); ++n)
    hits_.push_back({crossings[n].number, surface, crossings[n].i, crossings[n].j, points[n], s.color});
  if (paint_ && !s.own_color) paint(std::span(hits_).subspan(before));
}

// Gives hits the colours of another field's values.
void TileSurfaces::paint(std::span<Hit> hits) const {
  const SplatScene& by = *scene_.paint;
  const Affine3 to_paint = by.view->lattice_to_world.inverse();
  std::vector<Vec3> places, gradients(hits.size());
  std::vector<float> values(hits.size());
  for (const Hit& hit : hits)
    places.push_back(to_paint.point(view_.lattice_to_world.point(hit.point.position)));
  if (!by.slice->labels) field_at(*paint_, places, values, gradients);
  for (size_t n = 0; n < hits.size(); ++n) {
    const float value = by.slice->labels ? by.slice->labels->at(by.slice->lattice_to_slice.point(places[n]))
                                         : by.slice->base + values[n];
    hits[n].color = by.table->entry[static_cast<size_t>(by.table->index(value))];
  }
}

// Lays a surface behind what its pixel has; returns whether that finishes it.
bool TileSurfaces::add(const Hit& hit) {
  const size_t p = hit.pixel;
  if (!(pixel_.alpha[p] < stop_) || (options_.with_deep && m_.deep.full(p))) return false;
  if (hit.point.k < pixel_.enter[p] - outside_tolerance || hit.point.k > pixel_.leave[p] + outside_tolerance)
    return false;
  if (scene_.slice->has_holes && scene_.slice->is_hole(hit.point.position)) return false;
  const Surface& s = surfaces_[hit.surface];
  Shading lit{{1, 1, 1}, {}};
  if (options_.shading)
    lit = shade(*scene_.lights, hit.point.gradient, to_viewer(view_, hit.i, hit.j), s.target);
  const std::array<float, 3> seen = lit_color(hit.color, lit);
  const float part = (1 - pixel_.alpha[p]) * s.opacity;
  if (!(pixel_.alpha[p] > 0)) pixel_.depth[p] = static_cast<float>(hit.point.k);
  pixel_.red[p] += part * seen[0], pixel_.green[p] += part * seen[1], pixel_.blue[p] += part * seen[2];
  pixel_.alpha[p] += part;
  if (pixel_.value) pixel_.value[p] += part * s.value;
  if (pixel_.time) pixel_.time[p] += part * static_cast<float>(time_.at(hit.point.position));
  const auto k = static_cast<float>(hit.point.k);
  if (options_.with_hits) m_.hits.push_back({hit.pixel, hit.surface, k});
  if (options_.with_deep) return m_.deep.add_surface(pixel_, p, k, stop_);
  return pixel_.alpha[p] >= stop_;
}

} // namespace bccsplat

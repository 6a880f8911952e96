// SPDX-License-Identifier: Apache-2.0
// Splats the points of one tile gap by gap and takes finished sheets out of the ring. A brick is transformed
// when the front reaches it; its points wait in bins, one per gap, so that every sheet is complete as soon as
// the last gap that reaches it is drawn. How sheets are raised is in sheet_source_raise.cpp.
#include "splat/tile/sheet_source.h"

#include <algorithm>
#include <utility>

#include "base/grid.h"
#include "kernel/cc_kernel.h"

namespace bccsplat {

void clear_around(const PixelRect& before, const PixelRect& now, float* plane, int pitch) {
  for (int y = before.y0; y < before.y1; ++y) {
    const bool again = y >= now.y0 && y < now.y1;
    const auto clear = [row = plane + plane_offset(0, y, pitch)](int x0, int x1) {
      if (x0 < x1) std::fill(row + x0, row + x1, 0.0f);
    };
    clear(before.x0, again ? std::min(before.x1, now.x0) : before.x1);
    if (again) clear(std::max(before.x0, now.x1), before.x1);
  }
}

SheetSource::SheetSource(const SheetSourceArgs& args, const PlannedTile& tile, SheetMemory& memory,
                         DrawStats& stats)
    : scene_(*args.scene), plan_(*args.plan), kernel_(*args.kernel),
      loops_(args.reference_loops ? reference_loops() : simd_loops()), tile_(tile), m_(memory), stats_(stats),
      quantities_(args.gradients ? 4 : 1), kept_(args.kept), use_(args.use) {
  m_.size_planes(plan_, tile);
  ring_touched_.resize(plan_.ring.sheets);
  pitch_ = m_.plane_pitch;
  if (!tile.corrections.empty()) corrections_.emplace(scene_, plan_, tile);
}

void SheetSource::begin_sheets(int64_t first_sheet, int64_t last_sheet) {
  next_sheet_ = first_sheet;
  if (plan_.raise.depth_taps > 0) {
    const auto of_ring = [&](int64_t sheet) {
      return plan_.raise.z.at(static_cast<int>(std::clamp(sheet, first_raised(), last_raised())));
    };
    last_sheet = of_ring(last_sheet) + plan_.raise.depth_taps - 1;
    first_sheet = of_ring(first_sheet);
  }
  first_gap_ = std::max(plan_.gaps.first, first_sheet - plan_.ring.after);
  last_gap_ = std::min(plan_.gaps.last, last_sheet + plan_.ring.before);
  next_gap_ = first_gap_;
  if (use_ == KeptSheets::Use::keep) kept_->begin_sheets(first_gap_ - plan_.ring.before);
}

void SheetSource::end_sheets() {
  stats_.brick_visits += tile_.bricks.size();
  stats_.visits_unread += tile_.bricks.size() - next_brick_;
}

void SheetSource::complete_sheets(int64_t k, const OpenPixels* open, StageClock::time_point& clock) {
  if (scene_.slice->scattered) {
    for (; next_sheet_ <= k; ++next_sheet_) scatter_sheet(next_sheet_);
    add_lap(clock, stats_.ms_splat);
    return;
  }
  const auto finish_ring = [&](int64_t of_ring) {
    for (; next_gap_ <= of_ring + plan_.ring.before; ++next_gap_) splat_gap(next_gap_, open, clock);
  };
  if (plan_.raise.depth_taps == 0) {
    finish_ring(k);
    return;
  }
  for (; next_sheet_ <= k; ++next_sheet_) {
    if (!raised(next_sheet_)) {
      filled_[next_sheet_] = false;
      continue;
    }
    finish_ring(plan_.raise.z.at(static_cast<int>(next_sheet_)) + plan_.raise.depth_taps - 1);
    blend_sheet(next_sheet_);
    correct_sheet(next_sheet_);
  }
}

// Makes a sheet of points that stand on no lattice, which are looked up where the sheet is.
void SheetSource::scatter_sheet(int64_t k) {
  prepare_sheets();
  const SheetView& view = *scene_.view;
  const auto number = static_cast<double>(k);
  float* const plane = m_.plane_origin(k, 0);
  plane_touched_[k] = whole_vectors({0, 0, m_.width, m_.height});
  std::fill_n(plane, plane_size(m_.plane_pitch, m_.height), 0.0f);
  filled_[k] = scene_.slice->scattered->splat({view.sample(0, 0, number), view.scale(number) * view.ex,
                                               view.scale(number) * view.ey, tile_.x - plan_.sheets.border,
                                               tile_.y - plan_.sheets.border, m_.width, m_.height,
                                               m_.plane_pitch, plane});
}

void SheetSource::splat_gap(int64_t s, const OpenPixels* open, StageClock::time_point& clock) {
  if (use_ == KeptSheets::Use::take) {
    take_kept_sheet(s - plan_.ring.before);
    if (plan_.raise.depth_taps == 0) correct_sheet(s - plan_.ring.before);
    return;
  }
  if (s <= last_gap_) {
    while (next_brick_ < tile_.bricks.size() && plan_.bricks[tile_.bricks[next_brick_]].first_gap <= s) {
      activate_brick(tile_.bricks[next_brick_++], open);
      add_lap(clock, stats_.ms_transform);
    }
    if (prepared_) {
      const size_t bin = bin_of(s);
      SplatRecord* const records = m_.bins[bin].data();
      if (m_.bin_end[bin] != records) {
        size_t count = m_.bin_end[bin] - records;
        if (open && open->mostly_closed()) count = drop_hidden_points(s, records, count, *open);
        if (count > 0) last_filled_ = s + plan_.ring.after;
        splat_bin(s, records, count);
        mark_touched_samples(s, records, count);
        m_.bin_end[bin] = records;
        add_lap(clock, stats_.ms_splat);
      }
    }
  }
  const int64_t k = s - plan_.ring.before; // is complete
  (plan_.raise.depth_taps > 0 ? stack_filled_ : filled_)[k] = k <= last_filled_;
  if (use_ == KeptSheets::Use::keep) {
    KeptTile::Sheet& sheet = kept_->add_sheet();
    sheet.filled = k <= last_filled_, sheet.touched = ring_touched_[slot(k)];
  }
  if (k <= last_filled_) extract_sheet(k);
  if (plan_.raise.depth_taps == 0) correct_sheet(k);
}

// Adds the corrections that reach a finished sheet of the picture, which they fill where nothing else does.
void SheetSource::correct_sheet(int64_t k) {
  if (!corrections_ || !corrections_->reach(k)) return;
  prepare_sheets();
  PixelRect& touched = plane_touched_[k];
  float* const plane = m_.plane_origin(k, 0);
  if (!filled_[k]) clear_around(std::exchange(touched, {0, 0, 0, 0}), {0, 0, 0, 0}, plane, m_.plane_pitch);
  filled_[k] = true;
  const PixelRect changed = corrections_->add(k, {plane, m_.plane_pitch, tile_.x - plan_.sheets.border,
                                                  tile_.y - plan_.sheets.border, m_.width, m_.height});
  if (changed.empty()) return;
  if (touched.empty()) touched = changed;
  touched.include(changed);
  touched = whole_vectors(touched);
}

// Leaves sheet k, which was kept, as splat_gap() would.
void SheetSource::take_kept_sheet(int64_t k) {
  const KeptTile::Sheet& sheet = kept_->sheet(k);
  (plan_.raise.depth_taps > 0 ? stack_filled_ : filled_)[k] = sheet.filled;
  if (!sheet.filled) return;
  prepare_sheets();
  ring_touched_[slot(k)] = sheet.touched;
  ++stats_.sheets_taken;
  extract_sheet(k);
}

void SheetSource::prepare_sheets() {
  if (std::exchange(prepared_, true)) return;
  m_.prepare(plan_, tile_, quantities_ == 4);
  if (plan_.raise.fan.taps > 0) prepare_fan();
}

void SheetSource::activate_brick(uint32_t planned, const OpenPixels* open) {
  const PlannedBrick& b = plan_.bricks[planned];
  const SplatBrick& points = scene_.points->bricks[b.brick];
  if (open && open->hidden(b.rect)) {
    stats_.points_occluded += b.count;
    ++stats_.visits_hidden;
    return;
  }
  prepare_sheets();
  TransformArgs t;
  t.position = (b.picked ? plan_.picked.position.data() : scene_.points->position.data()) + points.first;
  t.coefficient =
      (b.picked ? plan_.picked.coefficient.data() : scene_.points->coefficient.data()) + points.first;
  t.count = b.count, t.axes = &b.axes;
  if (!b.picked) t.cells = b.cells;
  t.isotropic = plan_.gaps.isotropic;
  t.gaps = plan_.gaps.tables();
  t.first_gap = first_gap_, t.last_gap = last_gap_;
  t.tile = {.x = tile_.ring_x, .y = tile_.ring_y, .width = m_.ring_width, .height = m_.ring_height};
  if (open && !open->all_open(b.rect)) t.tile.open_sum = open->sums(), t.tile.around = open->around();
  if (plan_.raise.fan.taps > 0) t.tile.fan = &fan_;
  t.bin_end = m_.bin_end.data(), t.bin_mask = m_.bin_mask();
  const int64_t from = std::max(first_gap_, b.first_gap), to = std::min(last_gap_, b.last_gap);
  for (int64_t s = from; s <= to; ++s) m_.make_room(bin_of(s), b.count + 1);
  const size_t trash = m_.bins.size() - 1;
  m_.bin_end[trash] = m_.bins[trash].data();
  m_.make_room(trash, b.count + 16);
  const TransformCounts counts = loops_.transform(t);
  stats_.points_invisible += counts.invisible;
  stats_.points_splatted += counts.accepted;
  stats_.points_occluded += counts.occluded;
}

// Drops the points that only closed pixels would see, for pixels have closed since they were transformed.
size_t SheetSource::drop_hidden_points(int64_t s, SplatRecord* records, size_t count,
                                       const OpenPixels& open) {
  const size_t n = plan_.gaps.index(s);
  const int columns = plan_.gaps.columns[n], rows = plan_.gaps.rows[n];
  const Scales scales = gap_scales(plan_, s, s);
  size_t left = 0;
  for (size_t i = 0; i < count; ++i) {
    const SplatRecord& p = records[i];
    const int x = p.x + tile_.ring_x, y = p.y + tile_.ring_y;
    std::array<int, 4> rect{x, y, x + columns, y + rows};
    if (plan_.raise.fan.taps > 0) {
      const auto [x0, x1] = fan_pixels(plan_.raise.fan, plan_.raise.fan.x, scales, {rect[0], rect[2]});
      const auto [y0, y1] = fan_pixels(plan_.raise.fan, plan_.raise.fan.y, scales, {rect[1], rect[3]});
      rect = {x0, y0, x1, y1};
    }
    if (!open.hidden(rect)) records[left++] = p;
  }
  stats_.points_occluded += count - left;
  stats_.points_splatted -= count - left;
  return left;
}

void SheetSource::splat_bin(int64_t s, const SplatRecord* records, size_t count) {
  const size_t n = plan_.gaps.index(s);
  const GapLanes lanes = plan_.gaps.lanes(s, plan_.ring);
  SplatArgs a;
  a.record = records, a.count = count;
  a.lanes = &lanes, a.kernel = &kernel_;
  a.depth2 = static_cast<float>(plan_.gaps.depth2);
  a.isotropic = plan_.gaps.isotropic, a.spare = plan_.ring.whole_windows;
  a.columns = plan_.gaps.columns[n], a.rows = plan_.gaps.rows[n], a.half = plan_.gaps.half_x[n];
  for (size_t q = 0; q < quantities_; ++q) a.ring[q] = m_.ring_origin(q);
  a.groups = plan_.ring.groups, a.group_floats = m_.group_floats;
  a.pitch = m_.ring_pitch, a.width = m_.ring_width, a.height = m_.ring_height;
  loops_.splat(a);
  stats_.contributions += count * plan_.ring.sheets * a.columns * a.rows;
}

// Marks the samples that the points of a gap may touch, on all sheets within their reach.
void SheetSource::mark_touched_samples(int64_t s, const SplatRecord* records, size_t count) {
  if (count == 0) return;
  PixelRect starts;
  for (size_t n = 0; n < count; ++n) {
    const SplatRecord& p = records[n];
    starts.include({p.x, p.y, p.x, p.y});
  }
  const size_t n = plan_.gaps.index(s);
  const PixelRect touched =
      PixelRect{starts.x0, starts.y0, starts.x1 + plan_.gaps.columns[n], starts.y1 + plan_.gaps.rows[n]}
          .within(m_.ring_width, m_.ring_height);
  for (int64_t k = s - plan_.ring.before; k <= s + plan_.ring.after; ++k)
    ring_touched_[slot(k)].include(touched);
}

PixelRect SheetSource::whole_vectors(const PixelRect& r) {
  constexpr int vector = 16;
  if (r.empty()) return {0, 0, 0, 0};
  return {r.x0 / vector * vector, r.y0, (r.x1 + vector - 1) / vector * vector, r.y1};
}

// Takes a plane out of the ring, or of what was kept. Before, the plane is zero outside of `holds`,
// afterwards outside of what `holds` is then.
void SheetSource::extract_plane(int64_t k, size_t quantity, float* plane, int pitch, PixelRect& holds) {
  const size_t from = slot(k);
  const PixelRect now = whole_vectors(ring_touched_[from]);
  clear_around(std::exchange(holds, now), now, plane, pitch);
  if (use_ == KeptSheets::Use::take) {
    const float* from_kept = kept_->sheet(k).samples[quantity].get();
    const size_t width = now.x1 - now.x0;
    for (int y = now.y0; y < now.y1; ++y, from_kept += width)
      std::copy_n(from_kept, width, plane + plane_offset(now.x0, y, pitch));
    return;
  }
  ExtractArgs e;
  e.lane = static_cast<int>(from & 3);
  e.pitch = m_.ring_pitch, e.width = now.x1 - now.x0, e.height = now.y1 - now.y0;
  e.ring = m_.ring_origin(quantity) + (from >> 2) * m_.group_floats +
           plane_offset(now.x0, now.y0, m_.ring_pitch) * 4;
  e.plane = plane + plane_offset(now.x0, now.y0, pitch);
  e.plane_pitch = pitch;
  loops_.extract(e);
  if (use_ == KeptSheets::Use::keep) keep_plane(k, quantity, plane, pitch, now);
}

void SheetSource::keep_plane(int64_t k, size_t quantity, const float* plane, int pitch,
                             const PixelRect& rect) {
  const size_t width = rect.x1 - rect.x0;
  auto& samples = kept_->sheet(k).samples[quantity];
  samples = kept_->room(width * (rect.y1 - rect.y0));
  if (!samples) return;
  float* to = samples.get();
  for (int y = rect.y0; y < rect.y1; ++y, to += width)
    std::copy_n(plane + plane_offset(rect.x0, y, pitch), width, to);
}

// Takes a finished sheet out of the ring: to the stack it is blended from, to samples that are raised, or to
// pixels.
void SheetSource::extract_sheet(int64_t k) {
  const PixelRect touched = ring_touched_[slot(k)];
  if (plan_.raise.depth_taps > 0) {
    extract_plane(k, 0, m_.stack[k].data(), m_.sample_pitch, stack_held_[k]);
    stack_touched_[k] = touched;
  } else if (plan_.raise.taps > 0) {
    extract_plane(k, 0, m_.samples.data(), m_.sample_pitch, samples_held_);
    raise_sheet(k, touched);
  } else {
    const PixelRect before = plane_touched_[k];
    for (size_t q = 0; q < quantities_; ++q) {
      plane_touched_[k] = before;
      extract_plane(k, q, m_.plane_origin(k, q), m_.plane_pitch, plane_touched_[k]);
    }
    if (scene_.slice->kernel.normalised) normalise_sheet(k);
  }
  ring_touched_[slot(k)] = {};
}

// Divides a sheet by the lattice sum of the weights, for kernels that ask for it.
void SheetSource::normalise_sheet(int64_t k) {
  const SheetView& view = *scene_.view;
  const Slice& slice = *scene_.slice;
  float* plane = m_.plane_origin(k, 0);
  for (int y = 0; y < m_.height; ++y)
    for (int x = 0; x < m_.width; ++x) {
      float& v = plane[y * m_.plane_pitch + x];
      if (v == 0) continue;
      const Vec3 p = view.sample(tile_.x - plan_.sheets.border + x, tile_.y - plan_.sheets.border + y,
                                 static_cast<double>(k));
      v /= static_cast<float>(lattice_sum(slice.kernel, slice.lattice.bcc, p[0], p[1], p[2]));
    }
}

const float* SheetSource::plane(int64_t k, size_t quantity) const {
  return filled(k) ? m_.plane_origin(k, quantity) + plan_.sheets.border * pitch_ + plan_.sheets.border
                   : zero_plane();
}

PixelRect SheetSource::plane_touched(int64_t k) const { return filled(k) ? plane_touched_[k] : PixelRect{}; }

PixelRect SheetSource::touched(int64_t k) const {
  const PixelRect r = plane_touched(k);
  if (r.empty()) return {};
  const int border = plan_.sheets.border;
  return PixelRect{r.x0 - border, r.y0 - border, r.x1 - border, r.y1 - border}.within(tile_.width,
                                                                                      tile_.height);
}

const float* SheetSource::zero_plane() const {
  return m_.zero_plane.data() + plane_margin + plan_.sheets.border * pitch_ + plan_.sheets.border;
}

} // namespace bccsplat

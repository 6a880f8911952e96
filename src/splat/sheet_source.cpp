#include "splat/sheet_source.h"

#include <algorithm>
#include <utility>

#include "kernel/cc_kernel.h"

namespace bccsplat {

void lap(StageClock::time_point& from, double& sum) {
  const auto now = StageClock::now();
  sum += std::chrono::duration<double, std::milli>(now - from).count();
  from = now;
}

SheetSource::SheetSource(const SheetSourceArgs& args, const PlannedTile& tile, TileMemory& memory,
                         SplatStats& stats)
    : scene_(*args.scene), plan_(*args.plan), kernel_(*args.kernel),
      kernels_(args.scalar ? scalar_kernels() : simd_kernels()), tile_(tile), m_(memory), stats_(stats),
      quantities_(args.gradients ? 4 : 1) {
  m_.size_planes(plan_, tile.width, tile.height);
  ring_touched_.resize(static_cast<size_t>(plan_.sheets));
  pitch_ = m_.plane_pitch;
}

void SheetSource::begin(int64_t first_sheet, int64_t last_sheet) {
  first_slab_ = std::max(plan_.first_slab, first_sheet - plan_.after);
  last_slab_ = std::min(plan_.last_slab, last_sheet + plan_.before);
  next_slab_ = first_slab_;
}

void SheetSource::complete(int64_t k, const OpenPixels* open, StageClock::time_point& clock) {
  const int64_t last = k + plan_.before;
  for (; next_slab_ <= last; ++next_slab_) slab(next_slab_, open, clock);
}

void SheetSource::slab(int64_t s, const OpenPixels* open, StageClock::time_point& clock) {
  if (s <= last_slab_) {
    while (next_brick_ < tile_.bricks.size() && plan_.bricks[tile_.bricks[next_brick_]].first_slab <= s) {
      activate(tile_.bricks[next_brick_++], open);
      lap(clock, stats_.ms_transform);
    }
    if (prepared_) {
      const size_t bin = bin_of(s);
      SplatRecord* const records = m_.bins[bin].data();
      if (m_.bin_end[bin] != records) {
        auto count = static_cast<size_t>(m_.bin_end[bin] - records);
        if (open && open->mostly_closed()) count = drop_hidden(s, records, count, *open);
        if (count > 0) last_filled_ = s + plan_.after;
        splat_bin(s, records, count);
        touch(s, records, count);
        m_.bin_end[bin] = records;
        lap(clock, stats_.ms_splat);
      }
    }
  }
  const int64_t k = s - plan_.before; // is complete
  filled_[static_cast<size_t>(k & 7)] = k <= last_filled_;
  if (k <= last_filled_) extract(k);
}

void SheetSource::activate(uint32_t planned, const OpenPixels* open) {
  const PlannedBrick& b = plan_.bricks[planned];
  const SplatBrick& points = scene_.points->bricks[b.brick];
  if (open && open->hidden(b.rect)) {
    stats_.points_occluded += points.count;
    return;
  }
  if (!prepared_) {
    m_.prepare_sheets(plan_, tile_.width, tile_.height, quantities_ == 4);
    prepared_ = true;
  }
  TransformArgs t;
  t.position = scene_.points->position.data() + points.first;
  t.coefficient = scene_.points->coefficient.data() + points.first;
  t.count = points.count;
  t.frame = &b.frame;
  t.isotropic = plan_.isotropic;
  t.lateral = plan_.lateral.data();
  t.half_x = plan_.half_x.data(), t.half_y = plan_.half_y.data();
  t.columns = plan_.columns.data(), t.rows = plan_.rows.data();
  t.base_slab = plan_.first_slab;
  t.first_slab = first_slab_, t.last_slab = last_slab_;
  t.tile_x = tile_.x - plan_.border, t.tile_y = tile_.y - plan_.border;
  t.width = m_.width, t.height = m_.height;
  t.bin_end = m_.bin_end.data(), t.bin_mask = m_.bin_mask();
  const int64_t from = std::max(first_slab_, b.first_slab), to = std::min(last_slab_, b.last_slab);
  for (int64_t s = from; s <= to; ++s) m_.make_room(bin_of(s), points.count + 1);
  const size_t trash = m_.bins.size() - 1;
  m_.bin_end[trash] = m_.bins[trash].data();
  m_.make_room(trash, points.count + 16);
  if (open) t.open_sum = open->sums(), t.around = open->border();
  t.cells = b.cells;
  const TransformCounts counts = kernels_.transform(t);
  stats_.points_invisible += counts.invisible;
  stats_.points_splatted += counts.accepted;
  stats_.points_occluded += counts.occluded;
}

// Takes out the points that only closed pixels would see: pixels have closed since the points were
// transformed.
size_t SheetSource::drop_hidden(int64_t s, SplatRecord* records, size_t count, const OpenPixels& open) {
  const auto n = static_cast<size_t>(s - plan_.first_slab);
  const int columns = plan_.columns[n], rows = plan_.rows[n];
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    const SplatRecord& p = records[i];
    const int x = p.x + tile_.x - plan_.border, y = p.y + tile_.y - plan_.border;
    if (!open.hidden({x, y, x + columns, y + rows})) records[kept++] = p;
  }
  stats_.points_occluded += count - kept;
  stats_.points_splatted -= count - kept;
  return kept;
}

void SheetSource::splat_bin(int64_t s, const SplatRecord* records, size_t count) {
  const auto n = static_cast<size_t>(s - plan_.first_slab);
  const SlabLanes lanes = plan_.lanes(s);
  SplatArgs a;
  a.record = records, a.count = count;
  a.lanes = &lanes, a.kernel = &kernel_;
  a.depth2 = static_cast<float>(plan_.depth2);
  a.isotropic = plan_.isotropic, a.spare = plan_.spare;
  a.columns = plan_.columns[n], a.rows = plan_.rows[n], a.half = plan_.half_x[n];
  for (size_t q = 0; q < quantities_; ++q) a.ring[q] = m_.ring_origin(q);
  a.groups = plan_.groups, a.group_floats = m_.group_floats;
  a.pitch = m_.ring_pitch, a.width = m_.width, a.height = m_.height;
  kernels_.splat(a);
  stats_.contributions += count * static_cast<uint64_t>(plan_.sheets) * static_cast<uint64_t>(a.columns) *
                          static_cast<uint64_t>(a.rows);
}

// Notes which pixels of the sheets within reach the points of a slab touch.
void SheetSource::touch(int64_t s, const SplatRecord* records, size_t count) {
  if (count == 0) return;
  PixelRect starts;
  for (size_t n = 0; n < count; ++n) {
    const SplatRecord& p = records[n];
    starts.include({p.x, p.y, p.x, p.y});
  }
  const auto n = static_cast<size_t>(s - plan_.first_slab);
  const PixelRect touched =
      PixelRect{starts.x0, starts.y0, starts.x1 + plan_.columns[n], starts.y1 + plan_.rows[n]}.within(
          m_.width, m_.height);
  for (int64_t k = s - plan_.before; k <= s + plan_.after; ++k) ring_touched_[slot(k)].include(touched);
}

void SheetSource::extract(int64_t k) {
  const size_t from = slot(k);
  constexpr int vector = 16;
  PixelRect now = ring_touched_[from];
  ring_touched_[from] = {};
  if (now.empty()) now = {0, 0, 0, 0};
  now.x0 = now.x0 / vector * vector, now.x1 = (now.x1 + vector - 1) / vector * vector;
  const PixelRect before = std::exchange(plane_touched_[static_cast<size_t>(k & 7)], now);
  ExtractArgs e;
  e.lane = static_cast<int>(from & 3);
  e.pitch = m_.ring_pitch, e.width = now.x1 - now.x0, e.height = now.y1 - now.y0;
  e.plane_pitch = m_.plane_pitch;
  for (size_t q = 0; q < quantities_; ++q) {
    float* const plane = m_.plane_origin(k, q);
    for (int y = before.y0; y < before.y1; ++y) {
      const bool again = y >= now.y0 && y < now.y1;
      const auto clear = [row = plane + static_cast<std::ptrdiff_t>(y) * m_.plane_pitch](int x0, int x1) {
        if (x0 < x1) std::fill(row + x0, row + x1, 0.0f);
      };
      clear(before.x0, again ? std::min(before.x1, now.x0) : before.x1);
      if (again) clear(std::max(before.x0, now.x1), before.x1);
    }
    e.ring = m_.ring_origin(q) + (from >> 2) * m_.group_floats +
             (static_cast<std::ptrdiff_t>(now.y0) * m_.ring_pitch + now.x0) * 4;
    e.plane = plane + static_cast<std::ptrdiff_t>(now.y0) * m_.plane_pitch + now.x0;
    kernels_.extract(e);
  }
  if (scene_.slice->kernel.normalised) normalise(k);
}

// Divides a sheet by the lattice sum of the weights (kernels that ask for it).
void SheetSource::normalise(int64_t k) {
  const SheetView& view = *scene_.view;
  const Slice& slice = *scene_.slice;
  float* plane = m_.plane_origin(k, 0);
  for (int y = 0; y < m_.height; ++y)
    for (int x = 0; x < m_.width; ++x) {
      float& v = plane[y * m_.plane_pitch + x];
      if (v == 0) continue;
      const Vec3 p =
          view.sample(tile_.x - plan_.border + x, tile_.y - plan_.border + y, static_cast<double>(k));
      v /= static_cast<float>(lattice_sum(slice.kernel, slice.lattice.bcc, p[0], p[1], p[2]));
    }
}

const float* SheetSource::plane(int64_t k, size_t quantity) const {
  return filled(k) ? m_.plane_origin(k, quantity) + plan_.border * pitch_ + plan_.border : zero();
}

PixelRect SheetSource::touched(int64_t k) const {
  if (!filled(k)) return {};
  const PixelRect& r = plane_touched_[static_cast<size_t>(k & 7)];
  if (r.empty()) return {};
  const int border = plan_.border;
  return PixelRect{r.x0 - border, r.y0 - border, r.x1 - border, r.y1 - border}.within(tile_.width,
                                                                                      tile_.height);
}

const float* SheetSource::zero() const {
  return m_.zero_plane.data() + plane_margin + plan_.border * pitch_ + plan_.border;
}

} // namespace bccsplat

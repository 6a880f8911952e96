// SPDX-License-Identifier: Apache-2.0
// Has the fields of a picture sent and their looks set, the picture drawn, and hands it on in bands of rows.
#include "gpu/gpu_drawer.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/grid.h"
#include "draw/stage_clock.h"
#include "gpu/gpu_covers.h"
#include "gpu/gpu_picture.h"
#include "gpu/gpu_rows.h"
#include "gpu/trail_apart.h"
#include "gpu/value_change.h"

namespace bccsplat {

void GpuDrawer::use(std::shared_ptr<GpuDevice> device) {
  if (device == device_) return;
  scene_.reset();
  device_ = std::move(device);
  if (device_) scene_.emplace(*device_);
}

bool GpuDrawer::covers(Shots shots) const { return device_ && !not_on_gpu(shots); }

namespace {

// A band of finished rows: pixels from `first` on.
class Band {
 public:
  Band(const Shot& shot, const GpuPixels& pixels, size_t first, int y, int rows) {
    tile.y = y, tile.width = tile.pitch = shot.view->width, tile.height = rows;
    const size_t count = plane_size(tile.width, rows);
    for (auto& plane : planes_) plane.resize(count);
    for (size_t p = 0; p < count; ++p)
      for (size_t c = 0; c < colors; ++c) planes_[c][p] = pixels.color[first + p][c];
    tile.red = planes_[0].data(), tile.green = planes_[1].data(), tile.blue = planes_[2].data();
    tile.alpha = planes_[alpha].data(), tile.depth = planes_[depth].data();
    if (shot.options.with_value) tile.value = planes_[value].data();
    if (shot.options.with_time) tile.time = planes_[time].data();
    if (!pixels.more.empty()) add_more(shot, pixels, first);
  }
  TilePixels tile;

 private:
  enum Number : uint8_t { alpha = 3, colors, depth = colors, value, time, all };
  void add_more(const Shot& shot, const GpuPixels& pixels, size_t first) {
    const bool lit =
        shot.options.mode == RenderMode::composite || shot.options.mode == RenderMode::isosurface;
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), far = 1e29f;
    for (size_t p = 0; p < planes_[depth].size(); ++p) {
      const auto& [k, of_value, of_time, is_known] = pixels.more[first + p];
      const bool known = lit ? planes_[alpha][p] > 0 : is_known > 0;
      planes_[depth][p] = k < far ? k : std::numeric_limits<float>::infinity();
      planes_[value][p] = known ? of_value : nan;
      planes_[time][p] = known && of_time < far ? of_time : nan;
    }
  }
  std::array<std::vector<float>, all> planes_;
};

void emit_bands(const Shot& shot, const GpuPixels& pixels, const Context& context,
                const std::function<void(const TilePixels&)>& emit) {
  constexpr int rows = 64;
  const int width = shot.view->width, height = shot.view->height;
  context.tasks.parallel_for(static_cast<uint64_t>((height + rows - 1) / rows), [&](uint64_t n) {
    const int y = static_cast<int>(n) * rows;
    emit(Band(shot, pixels, plane_index(0, y, width), y, std::min(rows, height - y)).tile);
  });
}

} // namespace

// Jobs on the GPU's thread: those of a call, between which others may come.
GpuPixels GpuDrawer::draw_objects(std::span<const GpuObject> objects, const Shot& shot, TrailCombine combine,
                                  const std::vector<float>& ends, const Context& context, DrawStats& stats) {
  const GpuFields& found = scene_->find(objects, context, stats);
  const auto change_of = [&](const Shot& of, const Slice& slice) {
    return asks_for_change(of) ? change_at_sites(slice, context) : 0;
  };
  std::vector<double> change;
  if (shot.trail) // of which all stills are classified like the slice
    change.resize(objects.size(), change_of(objects.front().shot, *shot.slice));
  else
    for (const GpuObject& o : objects) change.push_back(change_of(o.shot, *o.shot.slice));
  const std::vector<ClassTable> tables = object_tables(objects, change);
  stats.preintegrated = !tables.front().integrals.empty();
  scene_->set(objects, tables);
  const KernelForm form = objects_form(objects);
  ShaderKind kind = objects_kind(objects, combine, tables);
  PictureBlock block = picture_block(objects.front().shot, tables.front(), found.field.front().bricks, form);
  std::vector<Vec4f> rows;
  if (objects.size() == 1 && !shot.trail) { // as a picture of one field
    kind.objects = 0;
  } else {
    for (size_t n = 0; n < objects.size(); ++n) {
      const PictureBlock own = picture_block(objects[n].shot, tables[n], found.field[n].bricks, form);
      const std::vector<Vec4f> row = object_row(objects[n], own, found.place(n), found.table_row[n]);
      rows.insert(rows.end(), row.begin(), row.end());
    }
    block.counts[2] = static_cast<int32_t>(objects.size());
    if (!ends.empty()) block.picture[3] = 1;
  }
  const Reservation memory(context.memory, picture_bytes(shot), "a picture by the GPU");
  std::optional<GpuPicture> picture;
  const EndOnGpu end{*device_, picture};
  device_->run([&] {
    picture.emplace(device_->programs(), kind, block, *found.sites, *found.classes, ends,
                    shot.target ? shot.target->depth_texture : 0, rows);
  });
  return draw_all_rows(*device_, *picture, shot, context);
}

GpuPixels GpuDrawer::draw_shots(Shots shots, const Context& context, DrawStats& stats) {
  const Shot& first = *shots.front();
  return draw_objects(instance_objects(shots), first, TrailCombine::physical, packed_ends(*first.view),
                      context, stats);
}

GpuPixels GpuDrawer::draw_trail(const Shot& shot, const Context& context, DrawStats& stats) {
  const std::vector<float> ends = packed_ends(*shot.view);
  if (shot.options.mode != RenderMode::isosurface)
    return draw_objects(trail_objects(shot, true), shot, shot.trail->combine, ends, context, stats);
  Shot apart = shot;
  apart.trail = nullptr, apart.options.with_depth = true;
  const Shot* const slice = &apart;
  const GpuPixels front = draw_shots(Shots(&slice, 1), context, stats);
  GpuPixels behind = draw_objects(trail_objects(shot, false), shot, TrailCombine::physical,
                                  ends_at(front, *shot.view, ends), context, stats);
  add_surface(front, shot.options, behind);
  return behind;
}

namespace {

void count_sites(const Slice& slice, DrawStats& stats) {
  // To count the points of a moment takes as long as to merge it.
  stats.points_total += static_cast<uint64_t>(slice.coset.moment() ? slice.sites() : slice.points());
}

uint64_t sheets_of(const Shot& shot) {
  const auto [first, last] = sheet_range(*shot.slice, *shot.view);
  return static_cast<uint64_t>(std::max(last - first + 1, int64_t{0}));
}

} // namespace

DrawStats GpuDrawer::draw(Shots shots, const Context& context,
                          const std::function<void(const TilePixels&)>& emit) {
  const auto start = std::chrono::steady_clock::now();
  (void)device_->info(); // fails before anything is made
  DrawStats stats;
  const Shot& first = *shots.front();
  const GpuPixels pixels =
      first.trail ? draw_trail(first, context, stats) : draw_shots(shots, context, stats);
  if (!first.target) emit_bands(first, pixels, context, emit);
  for (const Shot* shot : shots)
    count_sites(*shot->slice, stats), stats.sheets = std::max(stats.sheets, sheets_of(*shot));
  stats.ms_shade = ms_since(start);
  return stats;
}

} // namespace bccsplat

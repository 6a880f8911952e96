// SPDX-License-Identifier: Apache-2.0
// Keeps the sites of slices on the GPU, and with them the table and the cells of the last picture, as long as
// they stay the same; hands the finished picture on in bands of rows.
#include "gpu/gpu_drawer.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/grid.h"
#include "draw/stage_clock.h"
#include "gpu/gpu_kept.h"
#include "gpu/gpu_picture.h"
#include "gpu/gpu_rows.h"
#include "gpu/trail_apart.h"
#include "gpu/value_change.h"

namespace bccsplat {

struct GpuDrawer::Kept {
  SliceMark mark;
  FieldBricks bricks; // without their values
  uint64_t bytes = 0; // on the GPU
  std::optional<GpuSites> sites;
  std::optional<GpuClasses> classes;
  GpuClassKey key;
  // What a moment is merged of: its layers, which may have been dropped and sent again, and their weights.
  GpuMomentKey moment_key;
  std::vector<const GpuLayer*> now;
  std::vector<float> weights;
  std::optional<GpuMoment> moment;
  void merge(GpuPrograms& programs);
};

// Merges the layers of a moment; of a job.
void GpuDrawer::Kept::merge(GpuPrograms& programs) {
  if (!sites) {
    moment.emplace(bricks, now);
    const GpuBricks& like = *now.front()->sites;
    sites.emplace(bricks, GpuBricks(nullptr, moment->bricks(), like.edge(), like.in_buffer()));
  }
  moment->merge(programs, now, weights, sites->sites);
}

GpuDrawer::GpuDrawer() = default;
GpuDrawer::~GpuDrawer() { drop_all(); }

void GpuDrawer::use(std::shared_ptr<GpuDevice> device) {
  if (device == device_) return;
  forget();
  device_ = std::move(device);
}

bool GpuDrawer::covers(Shots shots) const { return device_ && !not_on_gpu(shots); }

void GpuDrawer::forget() {
  drop_all();
  too_large_ = 0;
}

void GpuDrawer::drop_all() {
  for (auto& kept : kept_) drop(kept);
  if (device_) objects_.drop(*device_), layers_.drop_all(*device_);
}

void GpuDrawer::drop(std::unique_ptr<Kept>& kept) {
  if (!kept) return;
  device_->release(kept->bytes);
  if (kept->sites) device_->clear([&] { kept.reset(); });
  kept.reset();
}

GpuDrawer::Kept& GpuDrawer::keep(std::unique_ptr<Kept> fresh) {
  drop(kept_[1]);
  if (!device_->has_room(fresh->bytes)) drop(kept_[0]);
  const uint64_t bytes = std::exchange(fresh->bytes, 0);
  device_->reserve(bytes);
  fresh->bytes = bytes;
  kept_[1] = std::exchange(kept_[0], std::move(fresh));
  return *kept_[0];
}

GpuDrawer::Kept& GpuDrawer::find_merged(const Slice& slice, const Context& context, DrawStats& stats) {
  slice.coset.make(context);
  const SliceMark mark = mark_of(slice);
  if (kept_[0] && kept_[0]->mark == mark) return *kept_[0];
  if (kept_[1] && kept_[1]->mark == mark) {
    std::swap(kept_[0], kept_[1]);
    return *kept_[0];
  }
  auto fresh = std::make_unique<Kept>();
  fresh->mark = mark;
  fresh->bricks = make_field_bricks(slice, brick_border(slice.kernel.space, slice.lattice.bcc), context);
  fresh->bytes = fresh->bricks.bytes();
  stats.bytes_sent += fresh->bytes;
  return keep(std::move(fresh));
}

GpuDrawer::Kept& GpuDrawer::find_moment(const Slice& slice, const MomentPlan& moment, const Context& context,
                                        DrawStats& stats) {
  const int border = brick_border(slice.kernel.space, slice.lattice.bcc);
  const auto layers = layers_.find(slice, moment, {&moment}, border, *device_, context, stats);
  const GpuMomentKey key = key_of(moment, layers);
  std::vector<MomentLayer> of;
  for (const GpuLayer* layer : layers) of.push_back({layer->coset, &layer->bricks});
  // Corrections are a moment's own.
  const SliceMark mark = slice.corrections ? mark_without_bricks(slice) : SliceMark{};
  const auto same = [&](const std::unique_ptr<Kept>& kept) {
    return kept && kept->moment_key == key && kept->mark == mark;
  };
  if (same(kept_[1])) std::swap(kept_[0], kept_[1]);
  if (!same(kept_[0])) {
    auto fresh = std::make_unique<Kept>();
    fresh->moment_key = key, fresh->mark = mark;
    fresh->bricks = moment_bricks(slice, border, of, key.most);
    const auto bricks =
        uint64_t{*std::max_element(fresh->bricks.brick_at.begin(), fresh->bricks.brick_at.end())} + 1;
    const auto edge = static_cast<uint64_t>(fresh->bricks.edge);
    fresh->bytes = bricks * (sizeof(float) * edge * edge * edge + sizeof(uint32_t) * layers.size());
    const uint64_t fixes = sizeof(float) * fresh->bricks.fixes.value.size();
    fresh->bytes += fixes, stats.bytes_sent += fixes;
    (void)keep(std::move(fresh));
  }
  kept_[0]->now = layers, kept_[0]->weights.clear();
  for (const MomentPlan::Part& part : moment.parts()) kept_[0]->weights.push_back(part.weight);
  return *kept_[0];
}

GpuDrawer::Kept& GpuDrawer::find(const Slice& slice, const Context& context, DrawStats& stats) {
  const MomentPlan* const moment = slice.coset.moment();
  if (!moment || slice.has_holes || moment->series() == too_large_) return find_merged(slice, context, stats);
  try {
    return find_moment(slice, *moment, context, stats);
  } catch (const GpuFailure& e) {
    if (e.for_good()) throw;
  }
  drop_all(), too_large_ = moment->series(); // layers need more than a moment alone
  return find_merged(slice, context, stats);
}

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
GpuPixels GpuDrawer::draw_pixels(const Shot& shot, const ClassTable& table, Kept& kept,
                                 const Context& context) {
  const std::vector<Vec4f> texels = table_texels(table);
  GpuClassKey key = key_of(shot, table, texels);
  const bool other = !kept.classes || !(kept.key == key);
  const std::vector<uint8_t> unseen = other ? unseen_by(shot, table, kept.bricks) : std::vector<uint8_t>();
  const std::vector<float> ends = packed_ends(*shot.view);
  const Reservation memory(context.memory, picture_bytes(shot), "a picture by the GPU");
  std::optional<GpuPicture> picture;
  const EndOnGpu end{*device_, picture};
  device_->run([&] {
    if (!kept.moment_key.layers.empty())
      kept.merge(device_->programs());
    else if (!kept.sites)
      kept.sites.emplace(kept.bricks, device_->programs().info());
    if (other) kept.classes.emplace(texels, kept.bricks, unseen), kept.key = std::move(key);
    picture.emplace(device_->programs(), shader_kind(shot, table), picture_block(shot, table, kept.bricks),
                    *kept.sites, *kept.classes, ends, shot.target ? shot.target->depth_texture : 0);
  });
  kept.bricks.drop_values();
  return draw_all_rows(*device_, *picture, shot, context);
}

GpuPixels GpuDrawer::draw_slice(const Shot& shot, const Context& context, DrawStats& stats) {
  Kept& kept = find(*shot.slice, context, stats);
  const double change = asks_for_change(shot) ? change_at_sites(*shot.slice, context) : 0;
  const ClassTable table = gpu_table(shot, change);
  GpuPixels pixels = draw_pixels(shot, table, kept, context);
  stats.preintegrated = !table.integrals.empty();
  return pixels;
}

GpuPixels GpuDrawer::draw_objects(std::span<const GpuObject> objects, const Shot& shot, TrailCombine combine,
                                  const std::vector<float>& ends, const Context& context, DrawStats& stats) {
  const auto change_of = [&](const Shot& of, const Slice& slice) {
    return asks_for_change(of) ? change_at_sites(slice, context) : 0;
  };
  std::vector<double> change;
  if (shot.trail) // of which all stills are classified like the slice
    change.resize(objects.size(), change_of(objects.front().shot, *shot.slice));
  else
    for (const GpuObject& o : objects) change.push_back(change_of(o.shot, *o.shot.slice));
  return objects_.draw(objects, shot, combine, ends, change, *device_, layers_, context, stats);
}

GpuPixels GpuDrawer::draw_trail(const Shot& shot, const Context& context, DrawStats& stats) {
  if (!drawn_apart(shot)) {
    for (auto& kept : kept_) drop(kept);
    return draw_objects(trail_objects(shot, true), shot, shot.trail->combine, packed_ends(*shot.view),
                        context, stats);
  }
  Shot apart = shot;
  apart.trail = nullptr, apart.options.with_depth = true;
  const GpuPixels front = draw_slice(apart, context, stats);
  const bool post = shot.trail->combine == TrailCombine::post;
  const std::vector<float> ends = packed_ends(*shot.view);
  GpuPixels behind = draw_objects(trail_objects(shot, false), shot, TrailCombine::physical,
                                  post ? ends : ends_at(front, *shot.view, ends), context, stats);
  if (post)
    lay_over(front, behind);
  else
    add_surface(front, shot.options, behind);
  return behind;
}

GpuPixels GpuDrawer::draw_instances(Shots shots, const Context& context, DrawStats& stats) {
  for (auto& kept : kept_) drop(kept);
  const Shot& first = *shots.front();
  return draw_objects(instance_objects(shots), first, TrailCombine::physical, packed_ends(*first.view),
                      context, stats);
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
  if (shots.size() == 1 && !first.trail) objects_.drop(*device_);
  const GpuPixels pixels = shots.size() > 1 ? draw_instances(shots, context, stats)
                           : first.trail    ? draw_trail(first, context, stats)
                                            : draw_slice(first, context, stats);
  if (!first.target) emit_bands(first, pixels, context, emit);
  for (const Shot* shot : shots)
    count_sites(*shot->slice, stats), stats.sheets = std::max(stats.sheets, sheets_of(*shot));
  stats.ms_shade = ms_since(start);
  return stats;
}

} // namespace bccsplat

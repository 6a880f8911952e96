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
#include "gpu/gpu_picture.h"

namespace bccsplat {

// What the classes of a picture are made of.
struct GpuClassKey {
  RenderMode mode = RenderMode::composite;
  std::vector<Vec4f> texels;
  float low = 0, scale = 0;
  std::vector<IsoSurface> surfaces;
  uint32_t disable_skips = 0;
  double step = 0;
  bool operator==(const GpuClassKey&) const = default;
};

// By what a slice is known again: another one may later stand at the same place.
struct SliceMark {
  const Slice* slice = nullptr;
  uint64_t bricks = 0; // of their places
  const void *corrections = nullptr, *mask = nullptr;
  double frame = 0, milliseconds = 0;
  std::array<double, 2> bounds{};
  bool operator==(const SliceMark&) const = default;
};

struct GpuDrawer::Kept {
  SliceMark mark;
  FieldBricks bricks; // without their values
  double change = 0;
  uint64_t bytes = 0; // on the GPU
  std::optional<GpuSites> sites;
  std::optional<GpuClasses> classes;
  GpuClassKey key;
  // Of a moment: its layers, which may have been dropped and sent again since, and what it is merged by.
  std::vector<GpuLayerKey> layers;
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

bool GpuDrawer::covers(const Shot& shot) const { return device_ && !not_on_gpu(shot); }

void GpuDrawer::forget() {
  drop_all();
  too_large_ = 0;
}

void GpuDrawer::drop_all() {
  for (auto& kept : kept_) drop(kept);
  if (device_) layers_.drop_all(*device_);
}

void GpuDrawer::drop(std::unique_ptr<Kept>& kept) {
  if (!kept) return;
  device_->release(kept->bytes);
  if (kept->sites) device_->clear([&] { kept.reset(); });
  kept.reset();
}

namespace {

SliceMark mark_of(const Slice& slice) {
  uint64_t hash = 0;
  for (const BrickLayer& layer : slice.coset)
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      constexpr uint64_t factor = 0x9e3779b97f4a7c15;
      constexpr int half = 32;
      hash = (hash ^ reinterpret_cast<uintptr_t>(layer.brick(s))) * factor;
      hash ^= hash >> half;
    }
  return {&slice,      hash, slice.corrections.get(), slice.mask.get(), slice.frame, slice.milliseconds,
          slice.bounds};
}

} // namespace

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
  fresh->change = change_at_sites(slice);
  fresh->bytes = fresh->bricks.bytes();
  stats.bytes_sent += fresh->bytes;
  return keep(std::move(fresh));
}

double GpuDrawer::change_of(const Slice& slice, const MomentPlan& moment, const Context& context) {
  if (series_ == moment.series()) return change_;
  slice.coset.make(context);
  change_ = change_at_sites(slice), series_ = moment.series();
  return change_;
}

GpuDrawer::Kept& GpuDrawer::find_moment(const Slice& slice, const MomentPlan& moment, const Context& context,
                                        DrawStats& stats) {
  const int border = brick_border(slice.kernel.space, slice.lattice.bcc);
  const auto layers = layers_.find(slice, moment, border, *device_, context, stats);
  std::vector<GpuLayerKey> keys;
  std::vector<MomentLayer> of;
  for (const GpuLayer* layer : layers)
    keys.push_back(layer->key), of.push_back({layer->coset, &layer->bricks});
  if (kept_[1] && kept_[1]->layers == keys) std::swap(kept_[0], kept_[1]);
  if (!kept_[0] || kept_[0]->layers != keys) {
    auto fresh = std::make_unique<Kept>();
    fresh->layers = keys;
    fresh->bricks = moment_bricks(slice, border, of, moment.largest_weight());
    fresh->change = change_of(slice, moment, context);
    const auto bricks =
        uint64_t{*std::max_element(fresh->bricks.brick_at.begin(), fresh->bricks.brick_at.end())} + 1;
    const auto edge = static_cast<uint64_t>(fresh->bricks.edge);
    fresh->bytes = bricks * (sizeof(float) * edge * edge * edge + sizeof(uint32_t) * keys.size());
    (void)keep(std::move(fresh));
  }
  kept_[0]->now = layers, kept_[0]->weights.clear();
  for (const MomentPlan::Part& part : moment.parts()) kept_[0]->weights.push_back(part.weight);
  return *kept_[0];
}

GpuDrawer::Kept& GpuDrawer::find(const Slice& slice, const Context& context, DrawStats& stats) {
  const MomentPlan* const moment = slice.coset.moment();
  if (!moment || slice.corrections || slice.has_holes || moment->series() == too_large_)
    return find_merged(slice, context, stats);
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

// The host's depths of a picture, packed.
std::vector<float> packed_ends(const SheetView& view) {
  std::vector<float> out;
  if (!view.ends.distance) return out;
  constexpr float far = 1e30f; // instead of infinity, of which GPUs need not know
  for (int j = 0; j < view.height; ++j)
    for (int i = 0; i < view.width; ++i) out.push_back(std::clamp(view.ends.at(i, j), -far, far));
  return out;
}

// Takes a picture off the GPU, on the thread that its objects belong to.
struct EndOnGpu {
  GpuDevice& device;
  std::optional<GpuPicture>& picture;
  ~EndOnGpu() {
    if (picture) device.clear([this] { picture.reset(); });
  }
};

GpuClassKey key_of(const Shot& shot, const ClassTable& table, const std::vector<Vec4f>& texels) {
  return {shot.options.mode,          texels,         table.low, table.scale, shot.options.surfaces,
          shot.options.disable_skips, shot.view->step};
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
  const Reservation memory(
      context.memory, (2 * sizeof(Vec4f) + sizeof(float)) * plane_size(shot.view->width, shot.view->height),
      "a picture by the GPU");
  std::optional<GpuPicture> picture;
  const EndOnGpu end{*device_, picture};
  device_->run([&] {
    if (!kept.sites && kept.layers.empty()) kept.sites.emplace(kept.bricks, device_->programs().info());
    if (!kept.layers.empty()) kept.merge(device_->programs());
    if (other) kept.classes.emplace(texels, kept.bricks, unseen), kept.key = std::move(key);
    picture.emplace(device_->programs(), shader_kind(shot, table), picture_block(shot, table, kept.bricks),
                    *kept.sites, *kept.classes, ends, shot.target ? shot.target->depth_texture : 0);
  });
  kept.bricks.drop_values();
  const int height = shot.view->height, rows = picture->rows_at_once();
  for (int row = 0; row < height; row += rows) {
    context.progress.report(static_cast<double>(row) / height);
    device_->run([&] { picture->draw_rows(row, std::min(rows, height - row)); });
  }
  GpuPixels pixels;
  const ShotOptions& o = shot.options;
  device_->run([&] {
    if (shot.target)
      picture->lay_over(device_->programs(), *shot.target);
    else
      pixels = picture->read(o.with_depth || o.with_value || o.with_time);
  });
  return pixels;
}

DrawStats GpuDrawer::draw(const Shot& shot, const Context& context,
                          const std::function<void(const TilePixels&)>& emit) {
  const auto start = std::chrono::steady_clock::now();
  (void)device_->info(); // fails before anything is made
  DrawStats stats;
  Kept& kept = find(*shot.slice, context, stats);
  const ClassTable table = gpu_table(shot, kept.change);
  const GpuPixels pixels = draw_pixels(shot, table, kept, context);
  if (!shot.target) emit_bands(shot, pixels, context, emit);
  // To count the points of a moment takes as long as to merge it.
  const bool merged = kept.layers.empty();
  stats.points_total = static_cast<uint64_t>(merged ? shot.slice->points() : shot.slice->sites());
  stats.preintegrated = !table.integrals.empty();
  stats.ms_shade = ms_since(start);
  const auto [first, last] = sheet_range(*shot.slice, *shot.view);
  stats.sheets = static_cast<uint64_t>(std::max(last - first + 1, int64_t{0}));
  return stats;
}

} // namespace bccsplat

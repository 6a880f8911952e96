// SPDX-License-Identifier: Apache-2.0
// The sites of all objects are in one buffer or texture, object after object: those of moments are merged
// there of the layers that are on the GPU, those of other slices are sent.
#include "gpu/gpu_objects.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "gpu/gpu_kept.h"
#include "gpu/gpu_rows.h"

namespace bccsplat {
// One object on the GPU.
struct KeptObject {
  SliceMark mark;     // of a slice that was sent
  GpuMomentKey key;   // of a moment
  FieldBricks bricks; // without their values, once these were sent
  size_t count = 0;   // bricks
  std::vector<const GpuLayer*> now;
  std::vector<float> weights;
  std::optional<GpuMoment> moment;
};

namespace {

const MomentPlan* moment_of(const GpuObject& object) { return object.shot.slice->coset.moment(); }

NeededMoments moments_of(std::span<const GpuObject> objects) {
  NeededMoments out;
  for (const GpuObject& o : objects)
    if (const MomentPlan* m = moment_of(o)) out.push_back(m);
  return out;
}

// How many bricks there are, the one of zeros included.
size_t count_of(const FieldBricks& bricks) {
  return size_t{*std::max_element(bricks.brick_at.begin(), bricks.brick_at.end())} + 1;
}

} // namespace

struct GpuObjects::Kept {
  std::vector<KeptObject> object;
  ObjectBricks placed;
  uint64_t bytes = 0; // on the GPU
  std::optional<GpuSites> sites;
  std::optional<GpuClasses> classes;
  std::vector<GpuClassKey> keys;
  std::vector<int> table_row; // where each object's table begins

  // A job of the GPU: brings the sites there, and merges moments.
  void send(GpuDevice& device);
  void set_classes(std::span<const GpuObject> objects, std::span<const ClassTable> tables, GpuDevice& device);
};

GpuObjects::GpuObjects() = default;
GpuObjects::~GpuObjects() = default;

void GpuObjects::drop(GpuDevice& device) {
  if (!kept_) return;
  device.release(kept_->bytes);
  device.clear([&] { kept_.reset(); });
}

namespace {

// What is kept of an object, before anything is sent of it; a slice's values are sent with the others'.
KeptObject describe(const GpuObject& object, const NeededMoments& needed, GpuDevice& device,
                    GpuLayers& layers, const Context& context, DrawStats& stats) {
  KeptObject out;
  const Slice& slice = *object.shot.slice;
  const MomentPlan* const moment = moment_of(object);
  if (!moment) {
    out.mark = mark_of(slice);
    return out;
  }
  const int border = brick_border(slice.kernel.space, slice.lattice.bcc);
  out.now = layers.find(slice, *moment, needed, border, device, context, stats);
  out.key = key_of(*moment, out.now);
  for (const MomentPlan::Part& part : moment->parts()) out.weights.push_back(part.weight);
  return out;
}

void make_bricks(const GpuObject& object, const Context& context, KeptObject& kept) {
  const Slice& slice = *object.shot.slice;
  const int border = brick_border(slice.kernel.space, slice.lattice.bcc);
  if (kept.now.empty()) {
    kept.bricks = make_field_bricks(slice, border, context);
  } else {
    std::vector<MomentLayer> of;
    for (const GpuLayer* layer : kept.now) of.push_back({layer->coset, &layer->bricks});
    kept.bricks = moment_bricks(slice, border, of, moment_of(object)->largest_weight());
  }
  kept.count = count_of(kept.bricks);
}

bool same_objects(const std::vector<KeptObject>& a, const std::vector<KeptObject>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const KeptObject& x, const KeptObject& y) {
    return x.mark == y.mark && x.key == y.key;
  });
}

ObjectBricks place_all(const std::vector<KeptObject>& objects) {
  std::vector<const FieldBricks*> bricks;
  std::vector<size_t> counts;
  for (const KeptObject& o : objects) bricks.push_back(&o.bricks), counts.push_back(o.count);
  return place_objects(bricks, counts);
}

} // namespace

GpuObjects::Kept& GpuObjects::find(std::span<const GpuObject> objects, GpuDevice& device, GpuLayers& layers,
                                   const Context& context, DrawStats& stats) {
  const NeededMoments needed = moments_of(objects);
  std::vector<KeptObject> wanted;
  for (const GpuObject& o : objects) wanted.push_back(describe(o, needed, device, layers, context, stats));
  if (kept_ && same_objects(kept_->object, wanted)) {
    for (size_t n = 0; n < wanted.size(); ++n)
      kept_->object[n].now = std::move(wanted[n].now),
      kept_->object[n].weights = std::move(wanted[n].weights);
    return *kept_;
  }
  drop(device);
  auto fresh = std::make_unique<Kept>();
  for (size_t n = 0; n < objects.size(); ++n) make_bricks(objects[n], context, wanted[n]);
  fresh->object = std::move(wanted), fresh->placed = place_all(fresh->object);
  uint64_t bytes = 0;
  const auto edge = static_cast<uint64_t>(fresh->placed.all.edge);
  for (const KeptObject& o : fresh->object) {
    const uint64_t sites = sizeof(float) * edge * edge * edge * o.count;
    bytes += sites + sizeof(uint32_t) * o.count * o.key.layers.size();
    stats.bytes_sent += o.key.layers.empty() ? sites : 0;
  }
  device.reserve(bytes);
  fresh->bytes = bytes;
  kept_ = std::move(fresh);
  return *kept_;
}

void GpuObjects::Kept::send(GpuDevice& device) {
  if (!sites) {
    const auto edge = static_cast<uint64_t>(placed.all.edge);
    const bool fit =
        GpuBricks::fit_buffer(sizeof(float) * edge * edge * edge * placed.count, device.programs().info()) &&
        std::all_of(object.begin(), object.end(),
                    [](const KeptObject& o) { return o.now.empty() || o.now.front()->sites->in_buffer(); });
    sites.emplace(placed.all, GpuBricks(nullptr, placed.count, placed.all.edge, fit));
    for (size_t n = 0; n < object.size(); ++n)
      if (KeptObject& o = object[n]; o.key.layers.empty())
        sites->sites.set(placed.places[n].first, o.bricks.value.data(), o.count), o.bricks.drop_values();
  }
  for (size_t n = 0; n < object.size(); ++n) {
    KeptObject& o = object[n];
    if (o.key.layers.empty()) continue;
    if (!o.moment) o.moment.emplace(o.bricks, o.now);
    (void)o.moment->merge(device.programs(), o.now, o.weights, sites->sites, placed.places[n].first);
  }
}

void GpuObjects::Kept::set_classes(std::span<const GpuObject> objects, std::span<const ClassTable> tables,
                                   GpuDevice& device) {
  std::vector<GpuClassKey> wanted;
  for (size_t n = 0; n < objects.size(); ++n)
    wanted.push_back(key_of(objects[n].shot, tables[n], table_texels(tables[n])));
  if (classes && wanted == keys) return;
  std::vector<Vec4f> texels;
  std::vector<uint8_t> unseen;
  table_row.clear();
  for (size_t n = 0; n < objects.size(); ++n) {
    const bool again = n > 0 && wanted[n].texels == wanted[n - 1].texels; // stills of one function
    table_row.push_back(again ? table_row.back() : static_cast<int>(texels.size()) / bccsplat::table_row);
    if (!again) texels.insert(texels.end(), wanted[n].texels.begin(), wanted[n].texels.end());
    place_cells(placed, n, object[n].bricks.cells, unseen_by(objects[n].shot, tables[n], object[n].bricks),
                unseen);
  }
  device.run([&] { classes.emplace(texels, placed.all, unseen); });
  keys = std::move(wanted);
}

GpuPixels GpuObjects::draw(std::span<const GpuObject> objects, const Shot& shot, TrailCombine combine,
                           const std::vector<float>& ends, std::span<const double> change, GpuDevice& device,
                           GpuLayers& layers, const Context& context, DrawStats& stats) {
  Kept& kept = find(objects, device, layers, context, stats);
  const std::vector<ClassTable> tables = object_tables(objects, change);
  stats.preintegrated = !tables.front().integrals.empty();
  try {
    device.run([&] { kept.send(device); });
    kept.set_classes(objects, tables, device);
  } catch (...) { // or the next picture would take what is not there for sent
    drop(device);
    throw;
  }
  const KernelForm form = objects_form(objects);
  std::vector<Vec4f> rows;
  std::optional<PictureBlock> block;
  for (size_t n = 0; n < objects.size(); ++n) {
    const PictureBlock own = picture_block(objects[n].shot, tables[n], kept.object[n].bricks, form);
    const std::vector<Vec4f> row = object_row(objects[n], own, kept.placed.places[n], kept.table_row[n]);
    rows.insert(rows.end(), row.begin(), row.end());
    if (!block) block = own;
  }
  block->counts[2] = static_cast<int32_t>(objects.size());
  if (!ends.empty()) block->picture[3] = 1;
  const Reservation memory(context.memory, picture_bytes(shot), "a picture by the GPU");
  std::optional<GpuPicture> picture;
  const EndOnGpu end{device, picture};
  device.run([&] {
    picture.emplace(device.programs(), objects_kind(objects, combine, tables), *block, *kept.sites,
                    *kept.classes, ends, shot.target ? shot.target->depth_texture : 0, rows);
  });
  return draw_all_rows(device, *picture, shot, context);
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Fields are told by marks of their slices, or by the layers of their moments. The sites of moments are
// merged where they are, of layers that are there, those of other slices are sent.
#include "gpu/gpu_scene.h"

#include <algorithm>
#include <set>
#include <utility>

namespace bccsplat {
namespace {

constexpr size_t most_layers = 12; // that are kept; moments of more keep as many as they have

int border_of(const Slice& slice) { return brick_border(slice.kernel.space, slice.lattice.bcc); }

uint64_t brick_bytes(const FieldBricks& like) {
  const auto edge = static_cast<uint64_t>(like.edge);
  return sizeof(float) * edge * edge * edge;
}

template<class Moments> bool needs(const Moments& moments, const GpuLayerKey& key) {
  return std::any_of(moments.begin(), moments.end(), [&](const MomentPlan* m) {
    return key.first == m->series() &&
           std::any_of(m->parts().begin(), m->parts().end(),
                       [&](const MomentPlan::Part& p) { return p.layer == key.second; });
  });
}

template<class Moments> size_t count_layers(const Moments& moments) {
  std::set<GpuLayerKey> keys;
  for (const MomentPlan* m : moments)
    for (const MomentPlan::Part& p : m->parts()) keys.emplace(m->series(), p.layer);
  return keys.size();
}

bool same_fields(const std::unique_ptr<GpuFields>& kept, const std::vector<GpuField>& wanted) {
  return kept &&
         std::equal(kept->field.begin(), kept->field.end(), wanted.begin(), wanted.end(),
                    [](const GpuField& a, const GpuField& b) { return a.mark == b.mark && a.key == b.key; });
}

void make_bricks(const Slice& slice, const Context& context, GpuField& field) {
  if (field.now.empty()) {
    field.bricks = make_field_bricks(slice, border_of(slice), context);
  } else {
    std::vector<MomentLayer> of;
    for (const GpuLayer* layer : field.now) of.push_back({layer->coset, &layer->bricks});
    field.bricks = moment_bricks(slice, border_of(slice), of, field.key.most);
  }
  field.count = size_t{*std::max_element(field.bricks.brick_at.begin(), field.bricks.brick_at.end())} + 1;
}

ObjectBricks place_all(const std::vector<GpuField>& fields) {
  std::vector<const FieldBricks*> bricks;
  std::vector<size_t> counts;
  for (const GpuField& f : fields) bricks.push_back(&f.bricks), counts.push_back(f.count);
  return place_objects(bricks, counts);
}

// A job of the GPU: brings the sites of fields there, and merges moments.
void send(GpuFields& f, GpuDevice& device) {
  if (!f.sites) {
    size_t count = 0;
    bool in_buffer = true;
    for (const GpuField& one : f.field) {
      count += one.count;
      in_buffer = in_buffer && (one.now.empty() || one.now.front()->sites->in_buffer());
    }
    in_buffer = in_buffer && GpuBricks::fit_buffer(brick_bytes(f.all()) * count, device.programs().info());
    f.sites.emplace(f.all(), GpuBricks(nullptr, count, f.all().edge, in_buffer));
    for (size_t n = 0; n < f.field.size(); ++n) {
      GpuField& one = f.field[n];
      if (one.now.empty()) f.sites->sites.set(f.place(n).first, one.bricks.value.data(), one.count);
      one.bricks.drop_values();
    }
  }
  for (size_t n = 0; n < f.field.size(); ++n) {
    GpuField& one = f.field[n];
    if (one.now.empty()) continue;
    if (!one.moment) one.moment.emplace(one.bricks, one.now);
    (void)one.moment->merge(device.programs(), one.now, one.weights, f.sites->sites, f.place(n).first);
  }
}

void set_classes(GpuFields& f, std::span<const GpuObject> objects, std::span<const ClassTable> tables,
                 GpuDevice& device) {
  std::vector<GpuClassKey> wanted;
  for (size_t n = 0; n < objects.size(); ++n)
    wanted.push_back(key_of(objects[n].shot, tables[n], table_texels(tables[n])));
  if (f.classes && wanted == f.keys) return;
  std::vector<Vec4f> texels;
  std::vector<uint8_t> unseen;
  f.table_row.clear();
  for (size_t n = 0; n < objects.size(); ++n) {
    const bool again = n > 0 && wanted[n].texels == wanted[n - 1].texels; // stills of one function
    f.table_row.push_back(again ? f.table_row.back() : static_cast<int>(texels.size()) / table_row);
    if (!again) texels.insert(texels.end(), wanted[n].texels.begin(), wanted[n].texels.end());
    std::vector<uint8_t> own = unseen_by(objects[n].shot, tables[n], f.field[n].bricks);
    if (f.several())
      place_cells(f.placed, n, f.field[n].bricks.cells, own, unseen);
    else
      unseen = std::move(own);
  }
  device.run([&] { f.classes.emplace(texels, f.all(), unseen); });
  f.keys = std::move(wanted);
}

} // namespace

const MomentPlan* GpuScene::moment_of(const Slice& slice, bool alone) const {
  const MomentPlan* const moment = slice.coset.moment();
  if (!moment || slice.has_holes || (alone && moment->series() == too_large_)) return nullptr;
  return moment;
}

const GpuFields& GpuScene::find(std::span<const GpuObject> objects, const Context& context,
                                DrawStats& stats) {
  const bool alone = objects.size() == 1;
  const MomentPlan* const moment = moment_of(*objects.front().shot.slice, alone);
  try {
    find_fields(objects, context, stats);
    return *kept_[0];
  } catch (const GpuFailure& e) {
    if (e.for_good() || !alone || !moment) throw;
  }
  drop_all(), too_large_ = moment->series(); // layers need more than a moment alone
  find_fields(objects, context, stats);
  return *kept_[0];
}

// Leaves the fields as the latest kept.
void GpuScene::find_fields(std::span<const GpuObject> objects, const Context& context, DrawStats& stats) {
  Moments needed;
  for (const GpuObject& o : objects)
    if (const MomentPlan* m = moment_of(*o.shot.slice, objects.size() == 1)) needed.push_back(m);
  std::vector<GpuField> wanted;
  for (const GpuObject& o : objects)
    wanted.push_back(
        describe(*o.shot.slice, moment_of(*o.shot.slice, objects.size() == 1), needed, context, stats));
  if (same_fields(kept_[1], wanted)) std::swap(kept_[0], kept_[1]);
  if (same_fields(kept_[0], wanted)) {
    for (size_t n = 0; n < wanted.size(); ++n)
      kept_[0]->field[n].now = std::move(wanted[n].now),
      kept_[0]->field[n].weights = std::move(wanted[n].weights);
    return;
  }
  auto fresh = std::make_unique<GpuFields>();
  for (size_t n = 0; n < objects.size(); ++n) {
    GpuField& one = wanted[n];
    make_bricks(*objects[n].shot.slice, context, one);
    const uint64_t sites = brick_bytes(one.bricks) * one.count,
                   marks = one.bricks.bytes() - one.bricks.site_bytes();
    fresh->bytes += sites + marks + sizeof(uint32_t) * one.count * one.now.size();
    stats.bytes_sent += marks + (one.now.empty() ? sites : 0);
  }
  fresh->field = std::move(wanted);
  if (fresh->several()) fresh->placed = place_all(fresh->field);
  keep(std::move(fresh));
}

void GpuScene::set(std::span<const GpuObject> objects, std::span<const ClassTable> tables) {
  try {
    device_.run([&] { send(*kept_[0], device_); });
    set_classes(*kept_[0], objects, tables, device_);
  } catch (...) { // or the next picture would take what is not there for sent
    drop(kept_[0]);
    throw;
  }
}

GpuField GpuScene::describe(const Slice& slice, const MomentPlan* moment, const Moments& needed,
                            const Context& context, DrawStats& stats) {
  GpuField out;
  if (!moment) {
    slice.coset.make(context);
    out.mark = mark_of(slice);
    return out;
  }
  if (slice.corrections) out.mark = mark_without_bricks(slice); // they are a moment's own
  out.now = find_layers(slice, *moment, needed, context, stats);
  out.key = key_of(*moment, out.now);
  for (const MomentPlan::Part& part : moment->parts()) out.weights.push_back(part.weight);
  return out;
}

std::vector<const GpuLayer*> GpuScene::find_layers(const Slice& slice, const MomentPlan& moment,
                                                   const Moments& needed, const Context& context,
                                                   DrawStats& stats) {
  std::vector<const GpuLayer*> out;
  for (const MomentPlan::Part& part : moment.parts()) {
    const GpuLayerKey key{moment.series(), part.layer};
    auto found = std::find_if(layers_.begin(), layers_.end(), [&](const auto& l) { return l->key == key; });
    if (found == layers_.end()) {
      auto made = send_layer(slice, moment, part, needed, context); // which may drop others
      layers_.insert(layers_.begin(), std::move(made));
      ++stats.layers_sent, stats.bytes_sent += layers_.front()->bytes;
    } else {
      std::rotate(layers_.begin(), found, found + 1);
    }
    out.push_back(layers_.front().get());
  }
  return out;
}

std::unique_ptr<GpuLayer> GpuScene::send_layer(const Slice& slice, const MomentPlan& moment,
                                               const MomentPlan::Part& part, const Moments& needed,
                                               const Context& context) {
  auto layer = std::make_unique<GpuLayer>();
  layer->key = {moment.series(), part.layer}, layer->coset = static_cast<size_t>(part.coset);
  const FieldBricks like = no_bricks(slice, border_of(slice));
  layer->bricks = part.of.values ? make_layer_bricks(*part.of.values, like, context)
                                 : make_layer_bricks(part.of.compact->as_values(), like, context);
  const uint64_t bytes = layer->bricks.value.size() * sizeof(float);
  make_room(needed, bytes);
  device_.reserve(bytes);
  layer->bytes = bytes;
  try {
    device_.run([&] {
      // Sites of a series are in buffers where those of a moment with every brick fit one.
      const bool in_buffer =
          GpuBricks::fit_buffer(brick_bytes(like) * (like.brick_at.size() + 1), device_.programs().info());
      layer->sites.emplace(layer->bricks.value.data(), bytes / brick_bytes(like), like.edge, in_buffer);
    });
  } catch (...) {
    device_.release(bytes);
    throw;
  }
  layer->bricks.drop_values();
  return layer;
}

void GpuScene::make_room(const Moments& needed, uint64_t bytes) {
  const size_t most = std::max(most_layers, count_layers(needed));
  for (size_t n = layers_.size(); n-- > 0 && (!device_.has_room(bytes) || layers_.size() >= most);) {
    if (needs(needed, layers_[n]->key)) continue;
    device_.release(layers_[n]->bytes);
    device_.clear([&] { layers_[n].reset(); });
    layers_.erase(layers_.begin() + static_cast<std::ptrdiff_t>(n));
  }
  for (size_t n = kept_.size(); n-- > 0 && !device_.has_room(bytes);) drop(kept_[n]);
}

// Several fields are kept for one picture alone: they may be a hundred.
void GpuScene::keep(std::unique_ptr<GpuFields> fresh) {
  drop(kept_[1]);
  if (kept_[0] && (kept_[0]->several() || !device_.has_room(fresh->bytes))) drop(kept_[0]);
  const uint64_t bytes = std::exchange(fresh->bytes, 0);
  device_.reserve(bytes);
  fresh->bytes = bytes;
  kept_[1] = std::exchange(kept_[0], std::move(fresh));
}

void GpuScene::drop(std::unique_ptr<GpuFields>& kept) {
  if (!kept) return;
  device_.release(kept->bytes);
  if (kept->sites) device_.clear([&] { kept.reset(); });
  kept.reset();
}

void GpuScene::drop_all() {
  for (auto& kept : kept_) drop(kept);
  for (const auto& layer : layers_) device_.release(layer->bytes);
  if (!layers_.empty()) device_.clear([&] { layers_.clear(); });
  layers_.clear();
}

} // namespace bccsplat

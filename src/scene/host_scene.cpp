// SPDX-License-Identifier: Apache-2.0
// Settles, for each instance, which moment, level and box a view shows of it; keeps the slices that are cut
// for that; and draws one instance as a picture of its slice, several together (together.h). What
// a budget makes of it is in host_scene_budget.cpp.
#include "scene/host_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "draw/deep.h"
#include "draw/stage_clock.h"
#include "scene/default_look.h"
#include "scene/host_scene_parts.h"
#include "scene/picture_needs.h"
#include "scene/together.h"
#include "volume/labels.h"

namespace bccsplat {
namespace {

// Part of a volume that a box is worth cutting for: what moves a little does not cut anew.
constexpr double worth_cutting = 0.7;

// A place in the world without points: the whole volume.
Slice place_of(const Instance& instance) {
  const Lattice4& lattice = instance.volume->info().lattice;
  Slice place;
  for (size_t a = 0; a < 3; ++a) place.domain_end[a] = lattice.domain_end(a), place.basis[a][a] = 1;
  place.slice_to_world = instance.placement.after(instance.volume->affine());
  return place;
}

bool covers(const std::optional<IndexBox>& has, const std::optional<IndexBox>& wanted) {
  if (!has) return true;
  if (!wanted) return false;
  for (size_t a = 0; a < 3; ++a)
    if (has->begin[a] > wanted->begin[a] || has->end[a] < wanted->end[a]) return false;
  return true;
}

double share_of(const IndexBox& box, const Lattice4& lattice) {
  double share = 1;
  for (size_t a = 0; a < 3; ++a)
    if (lattice.domain_end(a) > 0) share *= (box.end[a] - box.begin[a]) / lattice.domain_end(a);
  return share;
}

// Returns the frame that an instance shows at a time of the scene; none: it shows nothing.
std::optional<double> frame_at(const Instance& instance, double time) {
  const TimeAxis& times = instance.volume->times();
  const double first = times.first(), last = times.last();
  if (!(last > first)) return 0;
  double t = instance.time_offset + instance.time_scale * time;
  if (instance.outside == Outside::loop)
    t = first + (t - first) - (last - first) * std::floor((t - first) / (last - first));
  else if (instance.outside == Outside::hold)
    t = std::clamp(t, first, last);
  const double rounding = 1e-9 * (last - first);
  if (!(t >= first - rounding && t <= last + rounding)) return std::nullopt;
  return times.index_of(std::clamp(t, first, last));
}

TransferFunction function_of(const Instance& instance, const Slice& slice, const RenderOptions& options) {
  TransferFunction f = instance.function
                           ? *instance.function
                           : default_function(*instance.volume, instance.channel, slice, options);
  // Extinction is per unit distance.
  if (instance.density != 1)
    f.unit_distance = (f.unit_distance > 0 ? f.unit_distance : mean_voxel(slice)) / instance.density;
  return f;
}

ScenePaint paint_of(const Instance& instance, const SceneCut& cut, const RenderOptions& options) {
  RenderOptions composite = options;
  composite.mode = RenderMode::composite;
  const Slice& slice = cut.color->open.slice;
  return {&slice, &cut.color->kept->points, &cut.color->kept->levels,
          instance.color_function
              ? *instance.color_function
              : default_function(*instance.volume, *instance.color_channel, slice, composite)};
}

} // namespace

void clear(Image& image) {
  const auto fill = [&](const Plane& plane, float value) {
    for (int y = 0; plane.pixels && y < image.height; ++y)
      std::fill_n(plane.at(0, y), static_cast<size_t>(image.width) * plane.components, value);
  };
  fill(image.rgba, 0);
  fill(image.depth, std::numeric_limits<float>::infinity());
  fill(image.value, std::numeric_limits<float>::quiet_NaN());
  fill(image.time, std::numeric_limits<float>::quiet_NaN());
  if (image.deep) {
    *image.deep = {};
    image.deep->first.assign(static_cast<size_t>(image.width) * image.height + 1, 0);
  }
}

HostScene::HostScene() : frame_(std::make_unique<Frame>()) {}
HostScene::~HostScene() = default;

uint64_t HostScene::add(const Instance& instance) {
  auto placed = std::make_unique<Placed>();
  placed->instance = instance;
  const std::scoped_lock lock(changing_);
  instances_.emplace(next_, std::move(placed));
  ++version_;
  return next_++;
}

void HostScene::set(uint64_t id, const Instance& instance) {
  Placed& placed = find(id);
  const bool other = !instance.cut_like(placed.instance);
  {
    const std::scoped_lock lock(changing_);
    placed.instance = instance;
  }
  if (other) placed.fine.reset(), placed.coarse.reset();
  ++version_;
}

void HostScene::remove(uint64_t id) {
  (void)find(id);
  const std::scoped_lock lock(changing_);
  instances_.erase(id);
  ++version_;
}

void HostScene::set_clips(std::vector<SceneClip> clips) {
  const std::scoped_lock lock(changing_);
  clips_ = std::move(clips), ++version_;
}

const Instance& HostScene::instance(uint64_t id) const { return find(id).instance; }

HostScene::Placed& HostScene::find(uint64_t id) const {
  const auto found = instances_.find(id);
  if (found == instances_.end()) fail(Code::not_found, "scene: there is no instance ", id);
  return *found->second;
}

std::vector<Vec3> HostScene::corners() const {
  std::vector<Vec3> corners;
  for (const auto& [id, placed] : instances_) {
    if (placed->instance.hidden) continue;
    const Slice place = place_of(placed->instance);
    for (const Vec3& corner : world_corners(place, drawn_box(place))) corners.push_back(corner);
  }
  if (corners.empty()) fail(Code::wrong_state, "scene: it has no instance that is not hidden");
  return corners;
}

WorldBox HostScene::bounds() const { return box_around(corners()); }

Camera HostScene::fit(bool perspective, double rotate_x, double rotate_y, int width, int height) const {
  return fit_camera(corners(), perspective, rotate_x, rotate_y, static_cast<uint32_t>(width),
                    static_cast<uint32_t>(height));
}

Sight HostScene::sight_of(const ScenePicture& picture, int width, int height) const {
  Camera fitted;
  if (picture.view.is_default()) {
    const auto [whole_width, whole_height] = picture.view.picture_size(width, height);
    fitted = fit(false, default_rotate_x, default_rotate_y, whole_width, whole_height);
  }
  return picture.view.sight(fitted, width, height);
}

Sight HostScene::sight_of(uint64_t id, const Sight& sight) const {
  const Placed& placed = find(id);
  Sight own = sight;
  const Slice place = place_of(placed.instance);
  own.sheets_meet = place.slice_to_world.point(place.centre());
  const Affine3 to_volume = placed.instance.placement.inverse();
  for (const SceneClip& c : clips_)
    if (c.instance == 0 || c.instance == id)
      own.clip.push_back(c.of_volume ? c.plane.seen_through(to_volume) : c.plane);
  return own;
}

std::vector<HostScene::Need> HostScene::needs(const Sight& sight, const RenderOptions& options, double at,
                                              int width, int height) const {
  std::vector<Need> out;
  for (const auto& [id, placed] : instances_) {
    const Instance& instance = placed->instance;
    if (instance.hidden) continue;
    const std::optional<double> frame = frame_at(instance, at);
    if (!frame) continue;
    Need need;
    need.id = id, need.placed = placed.get(), need.frame = *frame, need.sight = sight_of(id, sight);
    const PictureNeeds found = picture_needs(*instance.volume, instance.channel, place_of(instance),
                                             need.sight, width, height, options);
    if (!found.seen) continue;
    need.level = static_cast<uint32_t>(found.level);
    // A box of uneven axes would be sampled anew for each: the whole is kept.
    if (instance.volume->axes()->any()) {
      out.push_back(std::move(need));
      continue;
    }
    if (share_of(found.box, instance.volume->lattice(0)) < worth_cutting) need.box = found.box;
    out.push_back(std::move(need));
  }
  return out;
}

bool CutPart::place(const Affine3& placement) {
  if (is_at(placement)) return false;
  open.slice.slice_to_world = placement.after(slice_to_world);
  kept->levels.place(open.slice.slice_to_world);
  return true;
}

SliceRequest HostScene::Need::request(uint32_t channel, const std::array<double, 2>& interval) const {
  const Instance& instance = placed->instance;
  HypersliceOptions cut;
  cut.interval = interval;
  cut.time_length = std::cbrt(std::fabs(instance.volume->affine().determinant()));
  cut.box = box;
  if (instance.volume->axes()->any()) cut.even = instance.volume->axes();
  return request_slice(*instance.volume, channel, nullptr, level, Hyperplane(0, 0, 0, 1, -frame), cut);
}

bool HostScene::Need::met_by(const std::unique_ptr<SceneCut>& cut) const {
  return cut && cut->frame == frame && cut->open.level == level && covers(cut->open.cut.box, box);
}

bool HostScene::Need::ready(const std::unique_ptr<SceneCut>& cut) const {
  const Instance& instance = placed->instance;
  return met_by(cut) && cut->is_at(instance.placement) && (!instance.trail || cut->trail);
}

// Cuts all that is drawn of an instance.
std::unique_ptr<SceneCut> HostScene::cut_anew(const Need& need, const Context& context, SceneStats& stats) {
  const Instance& instance = need.placed->instance;
  const OpenVolume& volume = *instance.volume;
  const uint64_t before = volume.reader()->bytes_read();
  auto made = std::make_unique<SceneCut>(cut_slice(volume, need.request(instance.channel), context));
  made->frame = need.frame;
  if (instance.mask_channel)
    show_labels_only(made->open.slice, volume, *instance.mask_channel, instance.mask_labels, need.frame,
                     need.box, context);
  if (instance.color_channel)
    made->color.emplace(cut_slice(volume, need.request(*instance.color_channel), context));
  stats.bytes_read += volume.reader()->bytes_read() - before;
  ++stats.cut;
  return made;
}

void HostScene::cut(const Need& need, std::unique_ptr<SceneCut>& into, const Context& context,
                    SceneStats& stats) const {
  const auto start = std::chrono::steady_clock::now();
  const Instance& instance = need.placed->instance;
  if (!need.met_by(into)) {
    into.reset(); // before the next one takes memory
    into = cut_anew(need, context, stats);
  }
  const bool moved = into->place(instance.placement);
  if (into->color) (void)into->color->place(instance.placement);
  if (moved) into->drawers.forget(), into->trail.reset(); // what they keep is of the slice in its place
  if (instance.trail && !into->trail) {
    const uint64_t before = instance.volume->reader()->bytes_read();
    into->trail = make_trail(*instance.volume, into->open, instance.trail->options, context);
    stats.bytes_read += instance.volume->reader()->bytes_read() - before;
  }
  stats.ms_cut += ms_since(start);
}

void HostScene::draw(const ScenePicture& picture, std::span<const Need> shown, CutOf cut_of,
                     const Context& context, Image& image, SceneStats& stats) const {
  const auto start = std::chrono::steady_clock::now();
  const auto scene_of = [&](const Need& need) {
    SceneCut& cut = *(need.placed->*cut_of);
    Scene scene;
    scene.slice = &cut.open.slice, scene.points = &cut.kept->points, scene.levels = &cut.kept->levels;
    scene.sight = need.sight;
    scene.function = function_of(need.placed->instance, cut.open.slice, picture.options);
    scene.lights = lights_;
    scene.lights.noise = noise_of(*need.placed->instance.volume, cut.open, picture.gradient_noise);
    scene.noise_of_ripple = !picture.gradient_noise;
    if (cut.color) scene.paint = paint_of(need.placed->instance, cut, picture.options);
    if (cut.trail) show_trail(*cut.trail, need.placed->instance.trail->look, scene);
    scene.drawers = picture.drawers ? picture.drawers : &cut.drawers;
    return scene;
  };
  if (shown.empty()) {
    clear(image);
    if (picture.options.target) draw_nothing(*picture.options.target, *picture.options.gpu);
    image.tell_all_drawn();
  } else if (shown.size() == 1) {
    const Scene scene = scene_of(shown.front());
    Picture single(scene, picture.options, context, image); // refused, an image stays as it was
    if (image.deep) *image.deep = {};                       // gives its memory back first
    stats.picture = single.draw();
  } else {
    std::vector<Scene> scenes;
    for (const Need& need : shown) {
      scenes.push_back(scene_of(need));
      scenes.back().sight->sheets_meet = shown.front().sight.sheets_meet;
    }
    stats.picture = render_together(scenes, picture.options, context, image);
  }
  stats.ms_draw += ms_since(start);
}

SceneStats HostScene::render(const ScenePicture& picture, const Context& context, Image& image) {
  const auto start = std::chrono::steady_clock::now();
  SceneStats stats;
  Sight sight = sight_of(picture, image.width, image.height);
  const HostEnds ends(picture.view, sight, image.width, image.height, context.memory);
  const std::vector<Need> shown = needs(sight, picture.options, time_, image.width, image.height);
  stats.drawn = static_cast<uint32_t>(shown.size());
  for (const Need& need : shown)
    stats.level = &need == &shown.front() ? need.level : std::min(stats.level, need.level);
  if (picture.budget_ms > 0) {
    draw_within(picture, sight, shown, start, context, image, stats);
  } else {
    for (const Need& need : shown) cut(need, need.placed->fine, context, stats);
    draw(picture, shown, &Placed::fine, context, image, stats);
    stats.drew = true;
    frame_->forget();
    frame_->complete_ms = ms_since(start);
  }
  stats.ms_total = ms_since(start);
  return stats;
}

std::vector<HostScene::Prefetch> HostScene::prefetch_requests(const ScenePicture& picture, double at,
                                                              int width, int height) const {
  const std::scoped_lock lock(changing_);
  const Sight sight = sight_of(picture, width, height);
  std::vector<Prefetch> out;
  for (const Need& need : needs(sight, picture.options, at, width, height)) {
    const Instance& instance = need.placed->instance;
    if (instance.trail)
      out.push_back({need.id, need.request(instance.channel, instance.trail->options.interval)});
    out.push_back({need.id, need.request(instance.channel)});
    if (instance.color_channel) out.push_back({need.id, need.request(*instance.color_channel)});
    if (instance.mask_channel)
      out.push_back(
          {need.id, request_labels(*instance.volume, *instance.mask_channel, need.frame, need.box)});
  }
  return out;
}

} // namespace bccsplat

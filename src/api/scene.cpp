// SPDX-License-Identifier: Apache-2.0
// The scene functions of the C API.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "api/handles.h"
#include "api/host_view.h"
#include "api/numbers.h"
#include "api/ranges.h"
#include "api/render_options.h"
#include "api/structs.h"
#include "base/byte_range.h"
#include "scene/host_scene.h"
#include "volume/read_ranges.h"

using namespace bccsplat;
using namespace bccsplat::api;

struct bccsplat_scene : Object<Kind::scene> {
  mutable Users users;
  Ref<bccsplat_device> device;
  std::map<uint64_t, Ref<bccsplat_volume>> volumes; // of instances; outlive them
  mutable std::mutex volumes_mutex;                 // of them and of which instances there are
  HostScene scene;
};

namespace {

constexpr double largest_budget = 1e9; // milliseconds
constexpr double largest_density = 1e6;

Affine3 read_placement(const double (&m)[16]) {
  if (std::all_of(std::begin(m), std::end(m), [](double v) { return v == 0; })) return {};
  require_numbers(m, "bccsplat_instance.placement");
  Affine3 out;
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) out.linear[r][c] = m[4 * r + c];
    out.offset[r] = m[4 * r + 3];
  }
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
    fail(Code::invalid_argument,
         "bccsplat_instance.placement: its last row must be 0 0 0 1; it is row-major");
  if (!(std::fabs(out.determinant()) > 0) || !std::isfinite(1 / out.determinant()))
    fail(Code::invalid_argument, "bccsplat_instance.placement is singular");
  return out;
}

// Reads which other channels colour and mask an instance.
void read_beside(const bccsplat_instance& in, const bccsplat_volume& volume, Instance& out) {
  if (in.set_mask & ~(BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL | BCCSPLAT_INSTANCE_SET_MASK_CHANNEL))
    fail(Code::invalid_argument, "bccsplat_instance.set_mask has bits that this library does not know");
  if (in.set_mask & BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL) {
    (void)volume.file.channel(in.color_channel);
    out.color_channel = in.color_channel;
    if (in.color_function) out.color_function = read_function(in.color_function);
  }
  if (!(in.set_mask & BCCSPLAT_INSTANCE_SET_MASK_CHANNEL)) return;
  (void)volume.file.channel(in.mask_channel);
  out.mask_channel = in.mask_channel;
  if (in.mask_label_count > 0) require(in.mask_labels, "bccsplat_instance.mask_labels");
  for (uint32_t n = 0; n < in.mask_label_count; ++n) {
    require_number(in.mask_labels[n], "bccsplat_instance.mask_labels");
    out.mask_labels.push_back(in.mask_labels[n]);
  }
}

Instance read_instance(const bccsplat_instance* instance, const bccsplat_volume& volume) {
  const auto in = read_struct(instance, "bccsplat_instance");
  Instance out;
  out.volume = &volume.file;
  (void)volume.file.channel(in.channel);
  out.channel = in.channel;
  out.placement = read_placement(in.placement);
  require_number(in.time_scale, "bccsplat_instance.time_scale");
  require_number(in.time_offset, "bccsplat_instance.time_offset");
  if (in.time_scale != 0) out.time_scale = in.time_scale;
  out.time_offset = in.time_offset;
  require_choice(in.outside, BCCSPLAT_OUTSIDE_LOOP, "bccsplat_instance.outside");
  if (in.outside == BCCSPLAT_OUTSIDE_HOLD) out.outside = Outside::hold;
  if (in.outside == BCCSPLAT_OUTSIDE_LOOP) out.outside = Outside::loop;
  out.hidden = in.hidden != 0;
  if (in.transfer_function) out.function = read_function(in.transfer_function);
  require_zero_or(in.density, 1 / largest_density, largest_density, "bccsplat_instance.density");
  if (in.density != 0) out.density = in.density;
  read_beside(in, volume, out);
  if (!in.trail) return out;
  if (AskedTrail asked = read_trail(in.trail); asked.any()) out.trail = std::move(asked);
  if (out.trail && out.mask_channel)
    fail(Code::unsupported,
         "bccsplat_instance.trail: a trail shows all of its moments; leave mask_channel out");
  return out;
}

// What a picture is asked to be, with the progress that its host is told.
struct AskedPicture {
  ScenePicture picture;
  Token token;
  Progress progress;
  FinishedPixels::Tell tell_tiles;

  AskedPicture(const bccsplat_device& device, const bccsplat_view* view,
               const bccsplat_render_options* options, double budget_ms = 0)
      : AskedPicture(device, view, options, budget_ms, read_struct(options, "bccsplat_render_options")) {}

 private:
  AskedPicture(const bccsplat_device& device, const bccsplat_view* view,
               const bccsplat_render_options* options, double budget_ms, const bccsplat_render_options& in)
      : token(read_token(in.cancel_token)),
        progress(progress_callback(budget_ms > 0 ? nullptr : in.progress, in.progress_user)),
        tell_tiles(tile_callback(in)) {
    picture.budget_ms = budget_ms;
    picture.view = read_view(view);
    picture.options = read_render_options(options, device);
    if (in.set_mask & BCCSPLAT_RENDER_SET_GRADIENT_NOISE) picture.gradient_noise = in.gradient_noise;
    watch(progress, token);
    progress.throw_if_cancelled();
  }
};

} // namespace

namespace {

// What a picture will read, and of which volume.
struct Read {
  uint64_t instance;
  Ref<bccsplat_volume> volume;
  SliceRequest request;
};
std::vector<Read> reads_of(const bccsplat_scene* scene, const ScenePicture& picture, uint32_t width,
                           uint32_t height, double time) {
  require(scene, "scene");
  require_pixels(width, height, "scene");
  require_number(time, "time");
  const std::scoped_lock lock(scene->volumes_mutex);
  std::vector<Read> reads;
  for (HostScene::Prefetch& p :
       scene->scene.prefetch_requests(picture, time, static_cast<int>(width), static_cast<int>(height)))
    reads.push_back({p.instance, scene->volumes.at(p.instance), std::move(p.request)});
  return reads;
}

// What fails on its way leaves a frame that is no picture of the view before. With a budget it keeps what it
// had until rows of it are there, and what is refused was not begun.
SceneStats render(bccsplat_scene& scene, AskedPicture& asked, bccsplat_frame& frame) {
  const FinishedPixels finished(asked.picture.view.background, asked.tell_tiles, asked.progress, frame.image);
  try {
    return scene.scene.render(asked.picture, scene.device->context(asked.progress), frame.image);
  } catch (const Error& e) {
    constexpr std::array refusals{Code::invalid_argument, Code::unsupported,    Code::not_found,
                                  Code::wrong_state,      Code::limit_exceeded, Code::out_of_domain};
    const bool refused = std::find(refusals.begin(), refusals.end(), e.code()) != refusals.end();
    if (finished.any() || (asked.picture.budget_ms == 0 && !refused))
      frame.attributes.clear(), frame.camera.reset();
    throw;
  }
}

} // namespace

extern "C" {

bccsplat_status bccsplat_scene_create(bccsplat_device* device, bccsplat_scene** scene) {
  return guard([&] {
    require(scene, "scene");
    *scene = nullptr;
    require(device, "device");
    auto s = std::make_unique<bccsplat_scene>();
    s->device = Ref(device);
    *scene = s.release();
  });
}

void bccsplat_scene_retain(bccsplat_scene* scene) { retain(scene); }
void bccsplat_scene_release(bccsplat_scene* scene) { release(scene); }

bccsplat_status bccsplat_scene_add(bccsplat_scene* scene, const bccsplat_volume* volume,
                                   const bccsplat_instance* instance, uint64_t* id) {
  return guard([&] {
    const Alone alone(scene, "scene");
    require(volume, "volume"), require(id, "id");
    if (volume->device.get() != scene->device.get())
      fail(Code::invalid_handle, "scene: the volume belongs to another device");
    const Instance in = read_instance(instance, *volume);
    const Ref<bccsplat_volume> held(const_cast<bccsplat_volume*>(volume));
    const std::scoped_lock lock(scene->volumes_mutex);
    const uint64_t number = scene->scene.add(in);
    scene->volumes.emplace(number, held);
    *id = number;
  });
}

bccsplat_status bccsplat_scene_set_instance(bccsplat_scene* scene, uint64_t id,
                                            const bccsplat_instance* instance) {
  return guard([&] {
    const Alone alone(scene, "scene");
    (void)scene->scene.instance(id);
    scene->scene.set(id, read_instance(instance, *scene->volumes.at(id).get()));
  });
}

bccsplat_status bccsplat_scene_remove(bccsplat_scene* scene, uint64_t id) {
  return guard([&] {
    const Alone alone(scene, "scene");
    Ref<bccsplat_volume> last; // is released without the lock
    const std::scoped_lock lock(scene->volumes_mutex);
    scene->scene.remove(id);
    last = scene->volumes.at(id);
    scene->volumes.erase(id);
  });
}

bccsplat_status bccsplat_scene_set_time(bccsplat_scene* scene, double time) {
  return guard([&] {
    const Alone alone(scene, "scene");
    require_number(time, "time");
    scene->scene.set_time(time);
  });
}

bccsplat_status bccsplat_scene_set_clips(bccsplat_scene* scene, const bccsplat_clip* clips, uint64_t count) {
  return guard([&] {
    const Alone alone(scene, "scene");
    std::vector<SceneClip> out;
    for (const Clip& c : read_clips(clips, count)) out.push_back({c.plane, c.of_volume, c.instance});
    scene->scene.set_clips(std::move(out));
  });
}

bccsplat_status bccsplat_scene_set_lights(bccsplat_scene* scene, const bccsplat_lights* lights) {
  return guard([&] {
    const Alone alone(scene, "scene");
    scene->scene.set_lights(read_lights(lights));
  });
}

bccsplat_status bccsplat_scene_get_bounds(const bccsplat_scene* scene, double bounds[6]) {
  return guard([&] {
    const Shared shared(scene, "scene");
    require(bounds, "bounds");
    const WorldBox box = scene->scene.bounds();
    std::copy(box.low.begin(), box.low.end(), bounds);
    std::copy(box.high.begin(), box.high.end(), bounds + 3);
  });
}

bccsplat_status bccsplat_scene_fit_camera(const bccsplat_scene* scene, int32_t projection,
                                          double rotate_x_degrees, double rotate_y_degrees, uint32_t width,
                                          uint32_t height, bccsplat_camera* camera) {
  return guard([&] {
    const Shared shared(scene, "scene");
    require_choice(projection, BCCSPLAT_PROJECTION_PERSPECTIVE, "projection");
    require_pixels(width, height, "scene");
    require_number(rotate_x_degrees, "rotate_x_degrees", largest_turn);
    require_number(rotate_y_degrees, "rotate_y_degrees", largest_turn);
    write_camera(scene->scene.fit(projection == BCCSPLAT_PROJECTION_PERSPECTIVE, rotate_x_degrees,
                                  rotate_y_degrees, static_cast<int>(width), static_cast<int>(height)),
                 camera);
  });
}

bccsplat_status bccsplat_scene_render(bccsplat_scene* scene, const bccsplat_view* view, bccsplat_frame* frame,
                                      const bccsplat_render_options* options, double budget_ms,
                                      bccsplat_scene_status* status) {
  return guard([&] {
    const Alone alone(scene, "scene");
    require(frame, "frame");
    check_output(status, "status");
    if (frame->device.get() != scene->device.get())
      fail(Code::invalid_handle, "scene: the frame belongs to another device");
    require_range(budget_ms, 0, largest_budget, "budget_ms");
    AskedPicture asked(*scene->device.get(), view, options, budget_ms);
    if (asked.picture.view.camera) hint_at_camera(*scene->device.get(), *asked.picture.view.camera);
    hint_at_options(*scene->device.get(), asked.picture.options);
    if (frame->gl_drawers && budget_ms > 0)
      fail(Code::unsupported, "scene: a picture in a texture is drawn at once; budget_ms must be 0");
    use_target(asked.picture.options, *frame, asked.picture.view);
    asked.picture.drawers = frame->gl_drawers.get();
    const SceneStats stats = render(*scene, asked, *frame);
    scene->device->tell_gpu(stats.picture.gpu_failed);
    if (stats.drew) {
      frame->attributes.clear(), frame->camera.reset();
      if (asked.picture.view.camera && asked.picture.view.picture[0] == 0)
        frame->camera = resolve_camera(*asked.picture.view.camera);
    }
    if (status) {
      bccsplat_scene_status out{};
      out.complete = stats.complete, out.progress = stats.complete ? 1 : stats.progress;
      out.drawn = stats.drawn, out.cut = stats.cut, out.level = stats.level;
      out.bytes_read = stats.bytes_read;
      out.backend = drawn_by(stats.picture);
      out.ms_cut = stats.ms_cut, out.ms_draw = stats.ms_draw, out.ms_total = stats.ms_total;
      write_struct(status, out, "status");
    }
    asked.progress.report(1);
  });
}

bccsplat_status bccsplat_scene_prefetch(const bccsplat_scene* scene, const bccsplat_view* view,
                                        uint32_t width, uint32_t height,
                                        const bccsplat_render_options* options, double time) {
  return guard([&] {
    // It may run beside everything else: an idle thread reads ahead while another one draws.
    require(scene, "scene");
    AskedPicture asked(*scene->device.get(), view, options);
    for (const Read& read : reads_of(scene, asked.picture, width, height, time))
      prefetch_slice(read.volume->file, read.request, scene->device->context(asked.progress));
    asked.progress.report(1);
  });
}

bccsplat_status bccsplat_scene_get_ranges(const bccsplat_scene* scene, const bccsplat_view* view,
                                          uint32_t width, uint32_t height,
                                          const bccsplat_render_options* options, double time, uint64_t id,
                                          uint32_t flags, uint64_t* ranges, uint64_t capacity,
                                          uint64_t* count) {
  return guard([&] {
    check_ranges(flags, ranges, capacity);
    require(scene, "scene");
    AskedPicture asked(*scene->device.get(), view, options);
    const std::vector<Read> reads = reads_of(scene, asked.picture, width, height, time);
    {
      const std::scoped_lock lock(scene->volumes_mutex);
      if (!scene->volumes.contains(id)) fail(Code::not_found, "scene: there is no instance ", id);
    }
    std::vector<ByteRange> found;
    for (const Read& read : reads) {
      if (read.instance != id) continue;
      const std::vector<ByteRange> more =
          read_ranges(read.volume->file, read.request, (flags & BCCSPLAT_RANGES_MISSING) != 0,
                      scene->device->context(asked.progress));
      found.insert(found.end(), more.begin(), more.end());
    }
    merge_ranges(found, 0);
    asked.progress.report(1);
    write_ranges(found, ranges, capacity, count);
  });
}

} // extern "C"

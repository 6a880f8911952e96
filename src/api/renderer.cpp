// SPDX-License-Identifier: Apache-2.0
// A renderer keeps what the host has set and what can be used again (sheets, the trail), makes a scene of it
// for each picture, and may be cancelled from another thread. Camera and options are read in
// render_options.cpp.
#include <algorithm>
#include <cmath>
#include <optional>

#include "api/handles.h"
#include "api/host_view.h"
#include "api/numbers.h"
#include "api/render_options.h"
#include "api/structs.h"
#include "scene/default_look.h"
#include "scene/picture.h"
#include "scene/trail.h"

using namespace bccsplat;
using namespace bccsplat::api;

struct bccsplat_renderer : Object<Kind::renderer> {
  mutable Users users;
  Ref<bccsplat_device> device;
  Ref<bccsplat_slice> slice;
  HostView view;
  std::vector<HalfSpace> clips;
  std::optional<TransferFunction> function;
  Lights lights;
  RenderOptions options;
  std::optional<double> gradient_noise; // value per mean voxel; none: as the file tells
  AskedTrail asked_trail;
  bool has_trail = false;
  std::optional<Trail> trail; // made at the first picture, kept until slice or trail change
  Drawers drawers;            // what they keep is of this slice
  bccsplat_progress_fn progress = nullptr;
  void* progress_user = nullptr;
  FinishedPixels::Tell tell_tiles;
  Token token;
  struct Stats : RenderStats {
    uint64_t bytes_read = 0;
    uint32_t volume_level = 0;
  };
  std::optional<Stats> stats;

  // The progress of the render under way, for cancel() from other threads.
  std::mutex running_mutex;
  Progress* running = nullptr;
};

namespace {

// Tells the log where another level of the slice was drawn than last time.
void tell_level(const bccsplat_renderer& renderer, int level) {
  if (level == (renderer.stats ? renderer.stats->level : 0)) return;
  renderer.device->log(BCCSPLAT_LOG_INFO,
                       level == 0 ? "render: the slice itself is drawn"
                                  : concat("render: pixels are large, a slice of ", int64_t{1} << level,
                                           " times the lattice distance is drawn"));
}

// Refuses a slice that no affine takes to the world.
void require_even(const bccsplat_slice& slice) {
  if (slice.volume->file.axes()->any() && !slice.open.cut.even)
    fail(Code::unsupported, "render: the volume's axes are unevenly spaced: draw a slice that was made with ",
         "bccsplat_slice_options.space BCCSPLAT_SPACE_EVEN");
}

void add_trail(bccsplat_renderer& renderer, Scene& scene, const Context& context) {
  if (!renderer.trail) {
    const bccsplat_slice& slice = *renderer.slice.get();
    renderer.trail = make_trail(slice.volume->file, slice.open, renderer.asked_trail.options, context);
  }
  show_trail(*renderer.trail, renderer.asked_trail.look, scene);
}

// Returns what the picture shows, for the attributes of an EXR.
std::vector<std::pair<std::string, std::string>> describe_picture(const bccsplat_slice& slice,
                                                                  const RenderStats& stats) {
  std::string plane;
  for (const double v : slice.open.slice.hyperplane.coefficients())
    plane += (plane.empty() ? "" : " ") + concat(v);
  return {{"bccsplat/version",
           concat(BCCSPLAT_VERSION_MAJOR, '.', BCCSPLAT_VERSION_MINOR, '.', BCCSPLAT_VERSION_PATCH)},
          {"bccsplat/hyperplane", plane},
          {"bccsplat/kernel", slice.open.slice.kernel.name},
          {"bccsplat/sheetStep", concat(stats.sheet_step)}};
}

} // namespace

extern "C" {

bccsplat_status bccsplat_slice_fit_camera(const bccsplat_slice* slice, int32_t projection,
                                          double rotate_x_degrees, double rotate_y_degrees, uint32_t width,
                                          uint32_t height, bccsplat_camera* camera) {
  return guard([&] {
    require(slice, "slice");
    require_choice(projection, BCCSPLAT_PROJECTION_PERSPECTIVE, "projection");
    if (width == 0 || height == 0) fail(Code::invalid_argument, "camera: the image has no pixels");
    require_number(rotate_x_degrees, "rotate_x_degrees", largest_turn);
    require_number(rotate_y_degrees, "rotate_y_degrees", largest_turn);
    const bool perspective = projection == BCCSPLAT_PROJECTION_PERSPECTIVE;
    const Camera c =
        fit_camera(slice->open.slice, perspective, rotate_x_degrees, rotate_y_degrees, width, height);
    write_camera(c, camera);
  });
}

bccsplat_status bccsplat_renderer_create(bccsplat_device* device, bccsplat_renderer** renderer) {
  return guard([&] {
    require(renderer, "renderer");
    *renderer = nullptr;
    require(device, "device");
    auto r = std::make_unique<bccsplat_renderer>();
    r->device = Ref(device);
    use_device(r->options, *device);
    *renderer = r.release();
  });
}

void bccsplat_renderer_retain(bccsplat_renderer* renderer) { retain(renderer); }
void bccsplat_renderer_release(bccsplat_renderer* renderer) { release(renderer); }

bccsplat_status bccsplat_renderer_set_slice(bccsplat_renderer* renderer, const bccsplat_slice* slice) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    if (slice) require(slice, "slice");
    if (slice && slice->volume->device.get() != renderer->device.get())
      fail(Code::invalid_handle, "renderer: the slice belongs to another device");
    if (slice && renderer->slice.get() == slice) return;
    renderer->trail.reset();
    renderer->drawers.forget();
    renderer->slice = slice ? Ref(const_cast<bccsplat_slice*>(slice)) : Ref<bccsplat_slice>();
  });
}

bccsplat_status bccsplat_renderer_set_trail(bccsplat_renderer* renderer, const bccsplat_trail* trail) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    if (!trail) {
      renderer->trail.reset();
      renderer->has_trail = false;
      return;
    }
    AskedTrail asked = read_trail(trail);
    renderer->trail.reset();
    renderer->has_trail = asked.any();
    renderer->asked_trail = std::move(asked);
  });
}

bccsplat_status bccsplat_renderer_set_camera(bccsplat_renderer* renderer, const bccsplat_camera* camera) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    HostView view;
    if (camera) view.camera = read_camera(camera), hint_at_camera(*renderer->device.get(), *view.camera);
    renderer->view = view;
  });
}

bccsplat_status bccsplat_renderer_set_view(bccsplat_renderer* renderer, const bccsplat_view* view) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    renderer->view = read_view(view);
    if (renderer->view.camera) hint_at_camera(*renderer->device.get(), *renderer->view.camera);
  });
}

bccsplat_status bccsplat_renderer_set_clips(bccsplat_renderer* renderer, const bccsplat_clip* clips,
                                            uint64_t count) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    renderer->clips = read_world_clips(clips, count);
  });
}

bccsplat_status bccsplat_renderer_set_transfer_function(bccsplat_renderer* renderer,
                                                        const bccsplat_transfer_function* function) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    renderer->function = function ? std::optional(read_function(function)) : std::nullopt;
  });
}

bccsplat_status bccsplat_renderer_set_lights(bccsplat_renderer* renderer, const bccsplat_lights* lights) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    renderer->lights = read_lights(lights);
  });
}

bccsplat_status bccsplat_renderer_set_options(bccsplat_renderer* renderer,
                                              const bccsplat_render_options* options) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    const auto in = read_struct(options, "bccsplat_render_options");
    Token token = read_token(in.cancel_token);
    renderer->options = read_render_options(options, *renderer->device.get());
    renderer->token = std::move(token);
    renderer->gradient_noise =
        in.set_mask & BCCSPLAT_RENDER_SET_GRADIENT_NOISE ? std::optional(in.gradient_noise) : std::nullopt;
    renderer->progress = in.progress, renderer->progress_user = in.progress_user;
    renderer->tell_tiles = tile_callback(in);
    hint_at_options(*renderer->device.get(), renderer->options);
  });
}

bccsplat_status bccsplat_renderer_render(bccsplat_renderer* renderer, bccsplat_frame* frame) {
  return guard([&] {
    const Alone alone(renderer, "renderer");
    require(frame, "frame");
    if (!renderer->slice) fail(Code::wrong_state, "renderer: set a slice first");
    require_even(*renderer->slice.get());
    if (frame->device.get() != renderer->device.get())
      fail(Code::invalid_handle, "renderer: the frame belongs to another device");
    Progress progress(progress_callback(renderer->progress, renderer->progress_user));
    watch(progress, renderer->token);
    progress.throw_if_cancelled();
    const auto run = [&](Progress* p) {
      const std::scoped_lock lock(renderer->running_mutex);
      renderer->running = p;
    };
    struct Running {
      decltype(run)& set;
      ~Running() { set(nullptr); }
    };
    run(&progress);
    const Running until_end{run};
    const Context context = renderer->device->context(progress);
    const bccsplat_slice& slice = *renderer->slice.get();
    if (slice.open.extraction && renderer->has_trail)
      fail(Code::unsupported, "render: slices of extracted points have no trail; use another method");
    const uint64_t read_before = slice.volume->file.reader()->bytes_read();
    const int width = frame->image.width, height = frame->image.height;
    const HostView& view = renderer->view;
    const Camera fitted = fitted_camera(view, slice.open.slice, width, height);
    Sight sight = view.sight(fitted, width, height);
    sight.clip = renderer->clips;
    const HostEnds ends(view, sight, width, height, renderer->device->memory);
    Scene scene;
    scene.slice = &slice.open.slice;
    scene.levels = &slice.kept.levels;
    scene.sight = sight;
    scene.function = renderer->function ? *renderer->function
                                        : default_function(slice.volume->file, slice.open.channel,
                                                           slice.open.slice, renderer->options);
    scene.lights = renderer->lights;
    scene.points = &slice.kept.points;
    scene.drawers = &renderer->drawers;
    if (renderer->has_trail) add_trail(*renderer, scene, context);
    RenderOptions options = renderer->options;
    use_target(options, *frame, view);
    if (frame->gl_drawers) scene.drawers = frame->gl_drawers.get();
    scene.lights.noise = noise_of(slice.volume->file, slice.open, renderer->gradient_noise);
    scene.noise_of_ripple = !renderer->gradient_noise;
    Picture picture(scene, options, context, frame->image); // refused, a frame stays as it was
    frame->deep = {};                                       // gives its memory back first
    frame->attributes.clear(), frame->camera.reset();
    const FinishedPixels finished(view.background, renderer->tell_tiles, progress, frame->image);
    const RenderStats stats = picture.draw();
    frame->attributes = describe_picture(slice, stats);
    if (!view.matrices && view.picture[0] == 0) frame->camera = resolve_camera(view.camera.value_or(fitted));
    tell_level(*renderer, stats.level);
    renderer->device->tell_gpu(stats.gpu_failed);
    renderer->stats = {stats, slice.volume->file.reader()->bytes_read() - read_before, slice.open.level};
    progress.report(1);
  });
}

bccsplat_status bccsplat_renderer_cancel(bccsplat_renderer* renderer) {
  return guard([&] {
    require(renderer, "renderer");
    const std::scoped_lock lock(renderer->running_mutex);
    if (renderer->running) renderer->running->cancel();
  });
}

bccsplat_status bccsplat_renderer_get_stats(const bccsplat_renderer* renderer, bccsplat_render_stats* stats) {
  return guard([&] {
    const Shared shared(renderer, "renderer");
    if (!renderer->stats) fail(Code::wrong_state, "renderer: nothing was rendered yet");
    const bccsplat_renderer::Stats& s = *renderer->stats;
    const DrawStats& drawn = s.drawn;
    bccsplat_render_stats out{};
    out.threads = s.threads;
    out.ms_transform = drawn.ms_transform, out.ms_splat = drawn.ms_splat, out.ms_shade = drawn.ms_shade;
    out.ms_total = s.ms_total, out.cpu_ms = drawn.ms();
    out.points_total = drawn.points_total, out.points_after_cull = drawn.points_after_cull;
    out.points_splatted = drawn.points_splatted, out.points_occluded = drawn.points_occluded;
    out.tiles = drawn.tiles, out.sheets = drawn.sheets, out.sheet_step = s.sheet_step;
    out.coarse_level = s.level, out.preintegrated = drawn.preintegrated;
    out.sheets_reused = drawn.sheets_taken;
    out.bricks_total = drawn.bricks_total, out.bricks_invisible = drawn.bricks_invisible;
    out.bricks_outside = drawn.bricks_outside;
    out.brick_visits = drawn.brick_visits, out.visits_hidden = drawn.visits_hidden;
    out.visits_unread = drawn.visits_unread;
    out.points_invisible = drawn.points_invisible, out.sheets_skipped = drawn.sheets_skipped;
    out.bytes_read = s.bytes_read, out.level = s.volume_level;
    out.backend = drawn_by(s);
    write_struct(stats, out, "stats");
  });
}

} // extern "C"

// SPDX-License-Identifier: Apache-2.0
// bcc4 render: pictures of slices.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "readers/sequence.h"
#include "tool/annotate/annotation.h"
#include "tool/annotate/bars.h"
#include "tool/annotate/font.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"
#include "tool/view/asked_trail.h"
#include "tool/view/camera_choice.h"
#include "tool/view/exposure.h"
#include "tool/view/fitted_view.h"
#include "tool/view/host_things.h"
#include "tool/view/picture_cut.h"
#include "tool/view/picture_layout.h"
#include "tool/view/picture_output.h"
#include "tool/view/picture_sequence.h"
#include "tool/view/picture_shape.h"
#include "tool/view/planes.h"
#include "tool/view/render_arguments.h"
#include "tool/view/render_function.h"
#include "tool/view/render_stats.h"
#include "tool/view/scene_picture.h"
#include "tool/view/shown_values.h"
#include "tool/view/slice_choice.h"
#include "tool/view/time_slice.h"
#include "tool/view/xray_exposure.h"

namespace bcc4 {
namespace {

constexpr uint32_t least_annotated = 160; // pixels a side

using Clock = std::chrono::steady_clock;
double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

bccsplat_render_options render_options(const RenderArguments& a, const bccsplat_look& look) {
  auto o = sized<bccsplat_render_options>();
  o.mode = a.mode;
  o.set_mask = BCCSPLAT_RENDER_SET_ISO;
  o.iso_value = look.iso_value;
  if (a.iso.size() == 1) o.iso_value = a.iso.front().value;
  o.surfaces = a.iso.data(), o.surface_count = static_cast<uint32_t>(a.iso.size());
  o.opacity_stop = a.opacity_stop.value_or(0);
  o.quality = a.quality;
  o.preintegrate = a.preintegrate;
  o.smooth_edges = a.smooth_edges;
  o.backend = a.backend;
  if (a.no_shading) o.shading = BCCSPLAT_SHADING_OFF;
  if (a.gradient_noise)
    o.set_mask |= BCCSPLAT_RENDER_SET_GRADIENT_NOISE, o.gradient_noise = *a.gradient_noise;
  o.sheet_step = a.step.value_or(0);
  o.reference = a.reference;
  o.deep_tolerance = a.deep_tolerance.value_or(0);
  if (a.repeat > 1) o.disable_skips = BCCSPLAT_SKIP_UNCHANGED; // whole pictures are timed
  o.cancel_token = interrupt_token();
  return o;
}

void write_text(const std::string& path, const std::string& text) {
  OutputFile file(path, true);
  file.write(std::as_bytes(std::span(text)));
  file.finish();
}

// Copies a picture into a part of another one.
void put(const Image& from, const Image& to, const Pane& pane) {
  auto source = sized<bccsplat_plane>(), target = sized<bccsplat_plane>();
  check(bccsplat_frame_get_channel(from.get(), BCCSPLAT_FRAME_RGBA, &source), "--layout");
  check(bccsplat_frame_get_channel(to.get(), BCCSPLAT_FRAME_RGBA, &target), "--layout");
  const auto row_of = [](const bccsplat_plane& p, size_t row) {
    return p.pixels + row * (p.row_bytes / sizeof(float));
  };
  for (size_t y = 0; y < pane.size.height; ++y)
    std::copy_n(row_of(source, y), size_t{4} * pane.size.width,
                row_of(target, pane.y + y) + size_t{4} * pane.x);
}

struct Scene {
  const RenderArguments& a;
  const Device& device;
  const Volume& volume;
  uint32_t channel;
  CameraChoice camera;
  const HostThings& host;
  PictureCutter cutter;
  std::optional<FittedView> fitted;
  Renderer renderer;
  std::optional<TransferFunction> function; // none: the library's own
  bool function_is_set;
  std::vector<TransferFunction> trail_functions; // none: the slice's; one for all sub-intervals, or for each
  std::array<double, 2> trail;                   // the interval that is set
  double open_ms;
  PictureOutput& output;
  double least_background;              // of an X-ray
  std::optional<XrayExposure> exposure; // of the first picture
  std::optional<Annotation> annotation;
  bccsplat_channel_info info;
  const std::vector<Picture>& pictures;
  bccsplat_render_options options;     // of a scene
  std::optional<ScenePictures> beside; // none: one channel of one volume, which the renderer draws
  const PictureLayout& layout;
  std::optional<Planes> planes; // none: the volume alone

  [[nodiscard]] bccsplat_camera view(const Slice& slice, const Picture& picture) {
    const bccsplat_camera view = camera.file ? turned(camera.file->cameras[picture.camera], picture.turn)
                                             : fitted->camera(slice, picture);
    return zoomed(view, a.zoom.value_or(1));
  }

  // Planes over time have the look of the first one's own values, which may be far from those of the series.
  void look_at_plane(const Slice& slice, const Picture& picture) {
    FunctionChoice choice = slice_function(a);
    if (function_is_set || picture.where.is_time_slice || !by_look(choice)) return;
    if (a.mode == BCCSPLAT_MODE_ISOSURFACE || a.mode == BCCSPLAT_MODE_XRAY) return;
    const bccsplat_look look = make_look(slice, a.look, a.mode);
    choice.always = true;
    function = transfer_function(choice, info, look);
    dump_function();
    if (annotation) annotate(look, look.iso_value);
  }

  // Writes the function where that is asked for.
  void dump_function() const {
    if (function && !a.dump_tf.empty())
      write_text(a.dump_tf, paraview_json(*function, a.colormap.empty() ? "bcc4" : a.colormap));
  }

  // Prepares what is written into pictures, in the colours that are drawn.
  void annotate(const bccsplat_look& look, double iso_value) {
    const auto painted = beside ? beside->color_channel() : std::nullopt;
    std::vector<std::array<double, 4>> colors = painted    ? beside->colors()
                                                : function ? function->colors
                                                           : colors_of(look);
    const bool of_labels = !painted && look.kind == BCCSPLAT_KIND_LABELS && colors == colors_of(look);
    annotation.emplace(a, volume, painted.value_or(channel), std::move(colors), of_labels, iso_value,
                       pictures);
  }

  // A look's opacities are in proportion to what rays cross of a slice.
  void set_function(const bccsplat_slice_info& slice) {
    if (!function) return;
    const double distance = function->unit_distance;
    if (by_look(slice_function(a))) function->unit_distance = distance_of_look(volume_info(volume), slice);
    if (function_is_set && function->unit_distance == distance) return;
    function_is_set = true;
    const bccsplat_transfer_function t = as_struct(*function);
    check(bccsplat_renderer_set_transfer_function(renderer.get(), &t),
          a.tf.empty() ? "transfer function" : a.tf);
  }

  // Sets what a picture is made of.
  void prepare(const PictureCut& cut, const bccsplat_view& seen, const Picture& picture) {
    const Lighting lighting(a.beside, cut.camera);
    const bccsplat_lights lights = lighting.as_struct();
    if (beside) return beside->set_lights(lights);
    check(bccsplat_renderer_set_lights(renderer.get(), &lights), "--light");
    check(bccsplat_renderer_set_slice(renderer.get(), cut.slice.get()), "");
    look_at_plane(cut.slice, picture);
    set_function(cut.info);
    check(bccsplat_renderer_set_view(renderer.get(), &seen),
          a.view_matrix.empty() ? a.camera : a.view_matrix);
  }

  // Sets the trails of a moment; what is set anew is made anew.
  void set_trails(const Cut& where) {
    const bool index = a.which.index || a.frames.has_value();
    const std::array<double, 2> before = trail;
    if (a.trail) trail = trail_interval(*a.trail, index, volume, where);
    if (beside) return beside->set_trails(where, index, trail);
    if (trail != before)
      check(bccsplat_renderer_set_trail(renderer.get(), AskedTrail(a, trail, trail_functions).get()),
            "--trail");
  }

  [[nodiscard]] bccsplat_render_stats render(const Image& image) const {
    check(bccsplat_renderer_render(renderer.get(), image.get()), "render");
    auto stats = sized<bccsplat_render_stats>();
    check(bccsplat_renderer_get_stats(renderer.get(), &stats), "");
    return stats;
  }

  // Makes one picture, and hands it on.
  RenderTimes draw(const Picture& picture, size_t number) {
    RenderTimes times;
    times.open_ms = open_ms;
    Image image = layout.has_volume() ? draw_volume(picture, number, times) : Image();
    if (planes) image = with_planes(picture, std::move(image));
    output.take(image, picture, exposure_seconds(volume, picture.where, trail));
    return times;
  }

  // Makes the sheet of planes and, where there is one, of the volume's picture.
  [[nodiscard]] Image with_planes(const Picture& picture, Image of_volume) {
    Image sheet = blank(layout.whole, BCCSPLAT_FRAME_RGBA);
    if (of_volume) put(of_volume, sheet, layout.volume);
    // A map's plane does not depend on what is seen.
    std::array<double, 3> middle{};
    if (layout.kind != BCCSPLAT_LAYOUT_FLAT)
      middle = fitted->middle(picture, [&] {
        Cut coarse = picture.where;
        coarse.level = volume_info(volume).level_count;
        return cut_slice(volume, coarse, channel);
      });
    planes->draw(sheet, picture.where, middle);
    return sheet;
  }

  [[nodiscard]] Image blank(const PictureSize& size, uint32_t channels) const {
    bccsplat_frame* created = nullptr;
    check(bccsplat_frame_create(device.get(), size.width, size.height, channels, &created), "");
    return Image(created);
  }

  // Renders the volume's picture, --repeat times.
  [[nodiscard]] Image draw_volume(const Picture& picture, size_t number, RenderTimes& times) {
    const PictureCut cut = cutter.cut(picture.where, [&](const Slice& s) { return view(s, picture); });
    times.slice = cut.info;
    times.kernel = times.slice.kernel;
    const bccsplat_view seen = host.view(cut.camera);
    prepare(cut, seen, picture);
    set_trails(picture.where);
    uint32_t channels = BCCSPLAT_FRAME_RGBA;
    if (a.deep)
      channels |= BCCSPLAT_FRAME_DEEP;
    else if (lower(picture.path).ends_with(".exr"))
      channels |= BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE | BCCSPLAT_FRAME_TIME;
    Image image = blank({camera.size[0], camera.size[1]}, channels);
    for (int i = 0; i < a.repeat; ++i) {
      stop_if_interrupted();
      times.renders.push_back(beside ? beside->draw(picture.where.time, seen, image, options)
                                     : render(image));
    }
    if (a.mode == BCCSPLAT_MODE_XRAY && !lower(picture.path).ends_with(".exr"))
      expose_xray(image.get(), cut.camera, times.slice, least_background, !a.background, exposure);
    if (annotation)
      annotation->draw(image, number, cut.camera, cut.domain, exposure,
                       trail_bar(a, volume, picture.where, trail));
    return image;
  }
};

// Whether there is a font, and room for letters.
void prepare_annotation(RenderArguments& a, const std::array<uint32_t, 2>& size) {
  if (!a.title.empty() && !a.annotate) a.annotate.emplace();
  if (!a.title.empty()) a.annotate->title = true;
  if (!a.annotate) return;
  require_font();
  if (std::min(size[0], size[1]) < least_annotated)
    fail_usage("--annotate: a picture of ", size[0], " x ", size[1], " has no room for letters; --size ",
               least_annotated, "x", least_annotated, " or more");
}

// Tells what nobody chose, and how to choose.
void tell_look(const RenderArguments& a, const bccsplat_look& look) {
  const bool iso = a.mode == BCCSPLAT_MODE_ISOSURFACE;
  if (a.common.quiet || !a.tf.empty() || a.range || a.mode == BCCSPLAT_MODE_XRAY || (iso && !a.iso.empty()))
    return;
  const std::string words =
      iso ? concat("the surface at ", short_number(look.iso_value, 3), " is drawn; --iso to change")
          : concat(look_in_words(look), "; --tf, --range or --look to change");
  std::fprintf(stderr, "bcc4: %s: %s\n", a.file.c_str(), words.c_str());
}

// Makes and tells the look of a channel. Several surfaces are told apart by the colours of their values; one
// has one.
bccsplat_look look_of_channel(const RenderArguments& a, const Volume& volume, uint32_t channel) {
  const bccsplat_look look =
      make_look(volume, channel, a.look, a.iso.size() > 1 ? BCCSPLAT_MODE_COMPOSITE : a.mode);
  tell_look(a, look);
  return look;
}

// One function for each sub-interval, one for all, or none: the slice's.
std::vector<TransferFunction> functions_of_trail(const RenderArguments& a, const bccsplat_channel_info& info,
                                                 const bccsplat_look& look) {
  std::vector<TransferFunction> functions;
  for (const FunctionChoice& choice : trail_functions(a))
    functions.push_back(transfer_function(choice, info, look).value());
  if (functions.empty())
    if (auto dense = function_of_dense_trail(slice_function(a), look)) functions.push_back(std::move(*dense));
  return functions;
}

// A surface that is nowhere leaves the picture empty.
void warn_of_no_surface(const RenderArguments& a, const bccsplat_channel_info& c) {
  for (const bccsplat_iso_surface& s : a.iso)
    if (s.value < c.range[0] || s.value > c.range[1])
      std::fprintf(stderr, "bcc4: warning: --iso %s: the values are %s to %s\n", concat(s.value).c_str(),
                   concat(c.range[0]).c_str(), concat(c.range[1]).c_str());
}

// A function that shows none of the values leaves the picture empty.
void warn_of_nothing(const RenderArguments& a, const TransferFunction& seen, const bccsplat_channel_info& c) {
  if (a.mode == BCCSPLAT_MODE_ISOSURFACE || a.mode == BCCSPLAT_MODE_XRAY) return;
  if (const auto why = shows_nothing(seen.opacities, c))
    std::fprintf(stderr, "bcc4: warning: %s\n", why->c_str());
}

// A series of which no moment was chosen shows the frame that shows most, in a film, on a sheet or in
// numbered pictures all of them, after a word on that.
void choose_moment(const Volume& volume, RenderArguments& a, uint32_t shows_most, bool moving_camera) {
  const SliceChoiceArguments& w = a.which;
  const bccsplat_volume_info v = volume_info(volume);
  if (v.dims[3] == 1 || w.time || w.index || w.plane || w.point || w.basis || w.sweep || a.frames) return;
  const bool all = (makes_one_file(a) || has_frame_pattern(a.output)) && !a.turntable && !moving_camera;
  const uint64_t frames = v.part_end > 0 ? v.part_end - v.part_first : v.dims[3]; // there are
  const auto first = static_cast<double>(v.part_first), last = first + static_cast<double>(frames - 1);
  if (all)
    a.frames = {first, last, 1};
  else
    a.which.time = shows_most, a.which.index = true;
  uint64_t told = 0; // frames whose ranges the file has
  check(bccsplat_volume_get_frame_ranges(volume.get(), 0, nullptr, 0, &told), "");
  const std::string drawn = all ? concat("no --frames given: all ", frames, " frames are drawn; they")
                                : concat("moment ", shows_most, " of ", first, "..", last,
                                         told > 0 && v.part_end == 0 ? ", which shows most" : ", the first",
                                         "; --time chooses another; they");
  std::fprintf(stderr, "bcc4: %s: %s run %s to %s%s%s\n", a.file.c_str(), drawn.c_str(),
               time_text(cut_at_index(volume, first).time).c_str(),
               time_text(cut_at_index(volume, last).time).c_str(), *v.time_unit ? " " : "", v.time_unit);
}

// Kernel exact has every sample of a Cartesian file and ripples between them, which light shows: only the
// best pictures are drawn with it where nobody asks for it.
Volume open_for_pictures(const Device& device, RenderArguments& a) {
  Volume volume = open_volume(device, a.file, a.kernel);
  const bool smooth = a.kernel.empty() && a.quality != BCCSPLAT_QUALITY_BEST &&
                      volume_info(volume).recommended_kernel == std::string_view("exact");
  const auto shape = picture_shape(volume, a);
  if (!smooth && !shape) return volume;
  a.shape_drawn = shape.value_or(std::array<double, 3>{});
  return open_volume(device, a.file, smooth ? "default" : a.kernel, a.shape_drawn);
}

std::vector<RenderTimes> draw_pictures(Scene& scene, const std::vector<Picture>& pictures) {
  Progress progress("render", pictures.size(), false, scene.a.common.quiet);
  std::vector<RenderTimes> times;
  for (size_t i = 0; i < pictures.size(); ++i) {
    stop_if_interrupted();
    times.push_back(scene.draw(pictures[i], i));
    progress.update(i + 1, concat(pictures[i].path, "  ", i + 1, " of ", pictures.size()));
  }
  scene.output.finish();
  progress.clear();
  return times;
}

void write_stats(const Scene& scene, const std::vector<RenderTimes>& times) {
  const bccsplat_volume_info info = volume_info(scene.volume);
  Json json = stats_json(times.front(), info);
  if (scene.a.frames || times.size() > 1) {
    json["frames"] = Json::array();
    for (const RenderTimes& t : times) json["frames"].push_back(stats_json(t, info));
  }
  write_text(scene.a.stats, json.dump(2) + "\n");
}

void print_times(const Scene& scene, const RenderTimes& times) {
  if (scene.planes)
    std::printf("%s: %u x %u, planes at samples %s\n", scene.a.output.c_str(), scene.layout.whole.width,
                scene.layout.whole.height, scene.planes->in_words().c_str());
  if (!scene.layout.has_volume()) return;
  const bccsplat_render_stats s = median_stats(times);
  // Rays draw without points.
  const bool by_rays = s.bricks_total == 0 && s.points_after_cull == 0;
  const std::string drawn = by_rays ? "" : concat(s.points_after_cull, " of ");
  const char* const by = s.backend == BCCSPLAT_BACKEND_GPU ? ", by the GPU" : "";
  std::printf("%s: %u x %u, %s ms after %s ms of slicing, %s%llu points, %llu sheets%s%s\n",
              scene.a.output.c_str(), scene.camera.size[0], scene.camera.size[1],
              short_number(s.ms_total, 3).c_str(), short_number(times.slice.milliseconds, 3).c_str(),
              drawn.c_str(), static_cast<unsigned long long>(s.points_total),
              static_cast<unsigned long long>(s.sheets), by, scene.output.in_words().c_str());
}

void refuse_outputs(const RenderArguments& a, const std::vector<Picture>& pictures) {
  for (const Picture& p : pictures) refuse_existing(p.path, a.overwrite);
  for (const std::string* out : {&a.stats, &a.dump_tf})
    if (!out->empty()) refuse_existing(*out, a.overwrite), refuse_source_as_output(*out, a.file);
}

// The pictures of a turn that lasts --seconds; a film of one moment has no other motion.
int turn_of(const RenderArguments& a, size_t count) {
  if (!a.turntable)
    fail_usage(
        "--seconds: a film of one moment, in which nothing moves; --turntable N turns it, --frames A-B "
        "shows others");
  return static_cast<int>(count);
}

Renderer create_renderer(const Device& device, const bccsplat_render_options& options,
                         const HostThings& host) {
  bccsplat_renderer* created = nullptr;
  check(bccsplat_renderer_create(device.get(), &created), "");
  Renderer renderer(created);
  check(bccsplat_renderer_set_options(created, &options), "render options");
  check(bccsplat_renderer_set_clips(created, host.clips.data(), host.clips.size()), "--clip");
  return renderer;
}

// Has what is asked for beside the channel drawn by the library's scene.
void draw_beside(Scene& scene, uint32_t channel, const std::vector<Picture>& pictures) {
  if (!scene.a.beside.needs_scene()) return;
  check_scene(scene.a, pictures);
  scene.beside.emplace(scene.device, scene.volume, channel, scene.a, scene.function, scene.trail_functions);
  scene.beside->set_clips(scene.host.clips);
}

Exit run_render(RenderArguments a) {
  check_arguments(a);
  const HostThings host = host_things(a);
  CameraChoice camera = choose_camera(a, host);
  const Device device = create_device(a.common.threads, a.common.max_memory);
  const auto start = Clock::now();
  const Volume volume = open_for_pictures(device, a);
  const double open_ms = milliseconds_since(start);
  const uint32_t channel = find_channel(volume, a.channel);
  const size_t cameras = camera.file ? camera.file->cameras.size() : 1;
  if (!a.common.quiet) warn_of_part(volume, a.file);
  if (a.trail && volume_info(volume).dims[3] == 1)
    fail_usage("--trail: ", a.file, " has one frame, in which nothing moves");
  const bccsplat_look first = make_look(volume, channel, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_DEFAULT);
  const PictureLayout layout = choose_layout(a, first.layout, camera.size);
  if (layout.has_volume()) camera.size = {layout.volume.size.width, layout.volume.size.height};
  prepare_annotation(a, camera.size);
  choose_moment(volume, a, first.frame, cameras > 1);
  if (const auto count = pictures_of_film(a); count && !a.frames) a.turntable = turn_of(a, *count);
  const std::vector<Picture> pictures = picture_sequence(volume, a, cameras);
  refuse_outputs(a, pictures);

  if (!a.iso.empty() && a.mode == BCCSPLAT_MODE_DEFAULT) a.mode = BCCSPLAT_MODE_ISOSURFACE;
  const bccsplat_look look = look_of_channel(a, volume, channel);
  const bccsplat_channel_info info = channel_info(volume, channel);
  warn_of_no_surface(a, info);
  const auto output = picture_output(a, device, layout.whole, pictures.size());
  const bccsplat_render_options options = render_options(a, look);
  Scene scene{.a = a,
              .device = device,
              .volume = volume,
              .channel = channel,
              .camera = camera,
              .host = host,
              .cutter = {volume, channel, !a.which.level, options, {camera.size[0], camera.size[1]}, host},
              .fitted = std::nullopt,
              .renderer = create_renderer(device, options, host),
              .function = transfer_function(slice_function(a), info, look),
              .function_is_set = false,
              .trail_functions = {},
              .trail = {0, 0},
              .open_ms = open_ms,
              .output = *output,
              .least_background = least_background(look, info.air),
              .exposure = std::nullopt,
              .annotation = std::nullopt,
              .info = info,
              .pictures = pictures,
              .options = options,
              .beside = std::nullopt,
              .layout = layout,
              .planes = std::nullopt};
  if (!layout.planes.empty())
    // By the file's own kernel, which has its samples.
    scene.planes.emplace(open_volume(device, a.file, a.kernel, a.shape_drawn), channel, layout,
                         scene.function ? scene.function->colors : colors_of(look));
  scene.dump_function();
  scene.trail_functions = functions_of_trail(a, info, look);
  draw_beside(scene, channel, pictures);
  const TransferFunction seen = seen_function(a, scene.function, look, info.air);
  warn_of_nothing(a, seen, info);
  scene.fitted.emplace(volume, channel, a, seen, camera.projection, camera.size, pictures);
  if (scene.beside && !camera.file)
    if (const auto others = scene.beside->seen_of_others()) scene.fitted->also_show(*others);
  if (a.annotate) scene.annotate(look, options.iso_value);

  const std::vector<RenderTimes> times = draw_pictures(scene, pictures);
  if (!a.stats.empty()) write_stats(scene, times);
  if (!a.common.quiet) print_times(scene, times.back());
  return Exit::ok;
}

} // namespace

Run add_render(const Command& tool, std::string command_line) {
  auto a = std::make_shared<RenderArguments>();
  a->command_line = std::move(command_line);
  const Command r = tool.add_command("render", "Draw slices as pictures (PNG, OpenEXR) or films (MP4, WebM). "
                                               "With no options the colours follow the values of the file.");
  r.set_examples({"bcc4 render smoke.bcc4 --time 0.06 -o smoke.png",
                  "bcc4 render smoke.bcc4 --time 0.06 --view front --annotate -o front.png",
                  "bcc4 render smoke.bcc4 --frames 0-3x0.5 --size 256 -o film.mp4",
                  "bcc4 render smoke.bcc4 --time 0.06 --shadow --ao -o shadowed.png",
                  "bcc4 render ct.bcc4 --with organs.bcc4,opacity=0.5 -o both.png",
                  "bcc4 render smoke.bcc4 --plane 1,0,0,0,-40 -o x40.png"});
  add_render_options(r, *a);
  return [a] { return run_render(*a); };
}

} // namespace bcc4

// bcc4 render: pictures of slices.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "readers/sequence.h"
#include "tool/camera_file.h"
#include "tool/cli.h"
#include "tool/commands.h"
#include "tool/interrupt.h"
#include "tool/output_file.h"
#include "tool/progress.h"
#include "tool/render_stats.h"
#include "tool/slice_choice.h"
#include "tool/slice_sweep.h"
#include "tool/time_slice.h"
#include "tool/transfer_function.h"

namespace bcc4 {
namespace {

using Clock = std::chrono::steady_clock;
double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct FrameRange {
  double first = 0, last = 0, step = 1;
};

struct RenderArguments {
  std::string file, output, kernel, channel;
  SliceChoiceArguments which;
  std::optional<FrameRange> frames;
  std::optional<std::array<uint32_t, 2>> size;
  std::string camera = "ortho";
  std::optional<double> rotate_x, rotate_y;
  std::string tf, colormap, dump_tf;
  std::optional<std::vector<double>> range;
  std::optional<double> opacity, iso, step, unit_distance;
  int32_t mode = BCCSPLAT_MODE_DEFAULT;
  int32_t quality = BCCSPLAT_QUALITY_DEFAULT;
  bool no_shading = false, reference = false;
  std::optional<std::vector<double>> trail; // DT[,K]
  int32_t trail_content = BCCSPLAT_TRAIL_CONTENT_DEFAULT;
  int32_t trail_mode = BCCSPLAT_TRAIL_COMBINE_DEFAULT;
  std::optional<std::vector<double>> background; // display colours
  std::string stats;
  int repeat = 1;
  CommonOptions common;
};

std::array<uint32_t, 2> parse_size(const std::string& text) {
  const auto parts = split(text, "x");
  const auto w = parts.size() == 2 ? parse_number<uint32_t>(parts[0]) : std::nullopt;
  const auto h = parts.size() == 2 ? parse_number<uint32_t>(parts[1]) : std::nullopt;
  if (!w || !h || *w < 1 || *h < 1 || *w > 65536 || *h > 65536)
    fail_usage("--size ", text, ": WxH is expected, such as 512x512");
  return {*w, *h};
}

FrameRange parse_frames(const std::string& text) {
  FrameRange r;
  const auto wrong = [&] {
    fail_usage("--frames ", text, ": A-B or A-BxS is expected, in frame numbers from 0");
  };
  const size_t x = text.find('x'), dash = text.find('-');
  if (dash == std::string::npos) wrong();
  const auto first = parse_number<double>(std::string_view(text).substr(0, dash));
  const auto last = parse_number<double>(
      std::string_view(text).substr(dash + 1, x == std::string::npos ? x : x - dash - 1));
  const auto step = x == std::string::npos ? std::optional(1.0)
                                           : parse_number<double>(std::string_view(text).substr(x + 1));
  if (!first || !last || !step || !(*step > 0) || !(*last >= *first) || !std::isfinite(*last)) wrong();
  return {*first, *last, *step};
}

// Colours and opacities when any option asks for other than the library's own.
std::optional<TransferFunction> transfer_function(const RenderArguments& a, const bccsplat_channel_info& c) {
  if (a.tf.empty() && a.colormap.empty() && !a.range && !a.opacity && !a.unit_distance && a.dump_tf.empty())
    return std::nullopt;
  if (!a.tf.empty() && !a.colormap.empty()) fail_usage("--tf and --colormap exclude each other");
  double low = c.percentile_2, high = c.percentile_998;
  if (a.range) {
    low = (*a.range)[0];
    high = (*a.range)[1];
    if (!(high > low)) fail_usage("--range ", low, ",", high, ": must rise");
  }
  if (!(high > low)) high = low + std::max(1e-6, 1e-6 * std::abs(low));
  TransferFunction f;
  if (!a.tf.empty()) {
    std::string warning;
    f = read_paraview_json(a.tf, warning);
    if (!warning.empty())
      std::fprintf(stderr, "bcc4: warning: %s: %s\n", a.tf.c_str(),
                   warning.substr(0, warning.size() - 2).c_str());
    if (a.range) rescale(f, low, high);
    if (!f.colors.empty()) {
      low = f.colors.front()[0];
      high = std::max(f.colors.back()[0], low + 1e-9 * std::max(1.0, std::abs(low)));
    }
  }
  if (f.colors.empty()) f.colors = colormap(a.colormap.empty() ? "viridis" : a.colormap, low, high).colors;
  if (f.opacities.empty()) add_default_opacity(f, low, high, c.air);
  scale_opacity(f, a.opacity.value_or(1));
  if (a.unit_distance) f.unit_distance = *a.unit_distance;
  return f;
}

struct CameraChoice {
  std::optional<CameraFile> file;
  int32_t projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  std::array<uint32_t, 2> size{512, 512};
};

CameraChoice choose_camera(const RenderArguments& a) {
  CameraChoice choice;
  if (lower(a.camera).ends_with(".json")) {
    choice.file = read_camera_file(a.camera);
    if (choice.file->resolution) choice.size = *choice.file->resolution;
    if (a.rotate_x || a.rotate_y)
      fail_usage("--rotate-x and --rotate-y do not turn a camera read from a file");
  } else {
    choice.projection = option_choice<int32_t>(
        "--camera", a.camera,
        {{"ortho", BCCSPLAT_PROJECTION_ORTHOGRAPHIC}, {"persp", BCCSPLAT_PROJECTION_PERSPECTIVE}});
  }
  if (a.size) choice.size = *a.size;
  return choice;
}

void set_options(const Renderer& renderer, const RenderArguments& a) {
  auto o = sized<bccsplat_render_options>();
  o.mode = a.mode;
  if (a.iso) {
    o.set_mask = BCCSPLAT_RENDER_SET_ISO;
    o.iso_value = *a.iso;
    if (a.mode == BCCSPLAT_MODE_DEFAULT) o.mode = BCCSPLAT_MODE_ISOSURFACE;
  }
  if (o.mode == BCCSPLAT_MODE_ISOSURFACE && !a.iso) fail_usage("--mode iso needs a value: --iso V");
  o.quality = a.quality;
  if (a.no_shading) o.shading = BCCSPLAT_SHADING_OFF;
  o.sheet_step = a.step.value_or(0);
  o.reference = a.reference;
  o.progress = Progress::cancel_only;
  check(bccsplat_renderer_set_options(renderer.get(), &o), "render options");
}

// --trail DT: what the volume held during the time DT up to the slice (after it when DT < 0), in the unit of
// --time.
void set_trail(const Renderer& renderer, const RenderArguments& a, const Volume& volume, const Cut& where) {
  if (!a.trail) return;
  if (!where.is_time_slice) fail_usage("--trail goes with time slices, not with --plane");
  const bccsplat_volume_info info = volume_info(volume);
  auto trail = sized<bccsplat_trail>();
  trail.content = a.trail_content;
  trail.combine = a.trail_mode;
  if (a.trail->size() > 1) {
    const double k = (*a.trail)[1];
    if (!(k >= 1 && k <= 256) || k != std::floor(k))
      fail_usage("--trail: K must be a whole number of sub-intervals, at most 256");
    trail.intervals = static_cast<uint32_t>(k);
  }
  double other = 0;
  if (a.which.index || a.frames) {
    other = where.index - (*a.trail)[0];
  } else {
    other =
        frame_index(volume, std::clamp(where.time - (*a.trail)[0], info.time_first, info.time_last), false);
  }
  trail.interval[0] = std::min(0.0, other - where.index);
  trail.interval[1] = std::max(0.0, other - where.index);
  check(bccsplat_renderer_set_trail(renderer.get(),
                                    trail.interval[0] == 0 && trail.interval[1] == 0 ? nullptr : &trail),
        "--trail");
}

void save(const Image& image, const std::string& path, const RenderArguments& a) {
  auto o = sized<bccsplat_image_options>();
  o.overwrite = 1; // pictures are made again and again
  if (a.background) {
    o.use_background = 1;
    for (size_t i = 0; i < 3; ++i) o.background[i] = srgb_to_linear((*a.background)[i]);
  }
  if (lower(path).ends_with(".exr"))
    check(bccsplat_frame_save_exr(image.get(), path.c_str(), &o), path);
  else
    check(bccsplat_frame_save_png(image.get(), path.c_str(), &o), path);
}

struct Scene {
  const RenderArguments& a;
  const Device& device;
  const Volume& volume;
  uint32_t channel;
  CameraChoice camera;
  Renderer renderer;
  double open_ms;

  // Renders one picture, --repeat times, and saves it.
  RenderTimes draw(const Cut& where, const std::string& path) {
    RenderTimes times;
    times.open_ms = open_ms;
    const Slice slice = cut(volume, where, channel);
    times.slice = slice_info(slice);
    times.kernel = times.slice.kernel;
    check(bccsplat_renderer_set_slice(renderer.get(), slice.get()), "");
    bccsplat_camera view = camera.file ? camera.file->camera : sized<bccsplat_camera>();
    if (!camera.file)
      check(bccsplat_slice_fit_camera(slice.get(), camera.projection, a.rotate_x.value_or(20),
                                      a.rotate_y.value_or(30), camera.size[0], camera.size[1], &view),
            "camera");
    check(bccsplat_renderer_set_camera(renderer.get(), &view), a.camera);
    set_trail(renderer, a, volume, where);
    uint32_t planes = BCCSPLAT_FRAME_RGBA;
    if (lower(path).ends_with(".exr")) planes |= BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE;
    bccsplat_frame* frame = nullptr;
    check(bccsplat_frame_create(device.get(), camera.size[0], camera.size[1], planes, &frame), "");
    const Image image(frame);
    for (int i = 0; i < a.repeat; ++i) {
      stop_if_interrupted();
      check(bccsplat_renderer_render(renderer.get(), image.get()), "render");
      auto stats = sized<bccsplat_render_stats>();
      check(bccsplat_renderer_get_stats(renderer.get(), &stats), "");
      times.renders.push_back(stats);
    }
    save(image, path, a);
    return times;
  }
};

bool is_picture(const std::string& path) {
  return lower(path).ends_with(".png") || lower(path).ends_with(".exr");
}

std::vector<Cut> cuts(const Volume& volume, const RenderArguments& a) {
  if (!a.frames) return sweep(volume, a.which);
  if (a.which.time || a.which.index || a.which.plane || a.which.point || a.which.sweep)
    fail_usage("--frames excludes --time, --plane, --point and --sweep");
  const double last_frame = static_cast<double>(volume_info(volume).dims[3]) - 1;
  if (!(a.frames->first >= 0 && a.frames->last <= last_frame))
    fail_usage("--frames: the frames are 0 to ", last_frame);
  std::vector<Cut> out;
  const auto count = static_cast<size_t>((a.frames->last - a.frames->first) / a.frames->step + 1e-9) + 1;
  if (count > 1'000'000) fail_usage("--frames: ", count, " pictures are too many");
  for (size_t i = 0; i < count; ++i) {
    out.push_back(cut_at_index(
        volume, std::min(a.frames->last, a.frames->first + static_cast<double>(i) * a.frames->step)));
    set_shape(out.back(), a.which);
  }
  return out;
}

// Names of the pictures: numbered by frame when frames are whole, else by their order.
std::vector<std::string> picture_names(const RenderArguments& a, const std::vector<Cut>& where) {
  if (!a.frames) return sweep_names(a.output, where.size());
  if (where.size() > 1 && !has_frame_pattern(a.output))
    fail_usage("-o ", a.output, ": ", where.size(), " pictures need a pattern such as smoke.%04d.png");
  const bool whole =
      std::all_of(where.begin(), where.end(), [](const Cut& c) { return c.index == std::floor(c.index); });
  std::vector<std::string> names;
  for (size_t i = 0; i < where.size(); ++i)
    names.push_back(
        apply_frame_pattern(a.output, whole ? std::llround(where[i].index) : static_cast<int64_t>(i)));
  return names;
}

void check_arguments(const RenderArguments& a) {
  require(a.file, "FILE", "bcc4 render smoke.bcc4 --time 10 -o smoke.png");
  require(a.output, "-o", "-o picture.png");
  if (!is_picture(a.output)) fail_usage("-o ", a.output, ": must end in .png or .exr");
  if (a.background && lower(a.output).ends_with(".exr"))
    fail_usage("--background is for PNG; an EXR keeps its opacity");
  if (!a.trail && (a.trail_content || a.trail_mode))
    fail_usage("--trail-content and --trail-mode go with --trail DT");
  if (a.step && !(*a.step > 0)) fail_usage("--step must be positive");
  if (a.opacity && !(*a.opacity >= 0)) fail_usage("--opacity must not be negative");
  if (a.unit_distance && !(*a.unit_distance > 0)) fail_usage("--unit-distance must be positive");
}

Exit run_render(const RenderArguments& a) {
  check_arguments(a);
  const CameraChoice camera = choose_camera(a);
  const Device device = create_device(a.common.threads, a.common.max_memory);
  const auto start = Clock::now();
  const Volume volume = open_volume(device, a.file, a.kernel);
  const double open_ms = milliseconds_since(start);
  const uint32_t channel = find_channel(volume, a.channel);
  const std::vector<Cut> where = cuts(volume, a);
  const std::vector<std::string> names = picture_names(a, where);
  for (const std::string& name : names) refuse_existing(name, true);
  if (!a.stats.empty()) refuse_existing(a.stats, true);

  bccsplat_renderer* created = nullptr;
  check(bccsplat_renderer_create(device.get(), &created), "");
  Scene scene{a, device, volume, channel, camera, Renderer(created), open_ms};
  set_options(scene.renderer, a);
  if (const auto f = transfer_function(a, channel_info(volume, channel))) {
    auto t = sized<bccsplat_transfer_function>();
    t.color_count = static_cast<uint32_t>(f->colors.size());
    t.colors = f->colors.front().data();
    t.opacity_count = static_cast<uint32_t>(f->opacities.size());
    t.opacities = f->opacities.front().data();
    t.unit_distance = f->unit_distance;
    check(bccsplat_renderer_set_transfer_function(scene.renderer.get(), &t),
          a.tf.empty() ? "transfer function" : a.tf);
    if (!a.dump_tf.empty()) {
      OutputFile file(a.dump_tf, true);
      const std::string text = paraview_json(*f, a.colormap.empty() ? "bcc4" : a.colormap);
      file.write(std::as_bytes(std::span(text)));
      file.finish();
    }
  }
  Progress progress("render", where.size(), false, a.common.quiet);
  std::vector<RenderTimes> times;
  for (size_t i = 0; i < where.size(); ++i) {
    stop_if_interrupted();
    times.push_back(scene.draw(where[i], names[i]));
    progress.update(i + 1, names[i]);
  }
  progress.clear();
  if (!a.stats.empty()) {
    Json json = stats_json(times.front(), volume_info(volume));
    if (a.frames || a.which.sweep) {
      json["frames"] = Json::array();
      for (const RenderTimes& t : times) json["frames"].push_back(stats_json(t, volume_info(volume)));
    }
    OutputFile file(a.stats, true);
    const std::string text = json.dump(2) + "\n";
    file.write(std::as_bytes(std::span(text)));
    file.finish();
  }
  if (!a.common.quiet) {
    const bccsplat_render_stats s = median_stats(times.back());
    std::printf("%s: %u x %u, %s ms after %s ms of slicing, %llu of %llu points, %llu sheets\n",
                a.output.c_str(), camera.size[0], camera.size[1], short_number(s.ms_total, 3).c_str(),
                short_number(times.back().slice.milliseconds, 3).c_str(),
                static_cast<unsigned long long>(s.points_after_cull),
                static_cast<unsigned long long>(s.points_total), static_cast<unsigned long long>(s.sheets));
  }
  return Exit::ok;
}

} // namespace

Run add_render(CLI::App& app) {
  auto a = std::make_shared<RenderArguments>();
  CLI::App& r = *app.add_subcommand("render", "Draw slices as PNG or OpenEXR pictures");
  r.add_option("FILE", a->file, "A .bcc4 file");
  r.add_option("-o,--output", a->output,
               "The .png or .exr to write; a pattern such as p.%04d.png with --frames")
      ->type_name("OUT");
  add_slice_choice(r, a->which);
  add_sweep(r, a->which);
  const auto text = [&r](const char* option, const char* type, const char* help, auto set) {
    r.add_option_function<std::string>(option, set, help)->type_name(type);
  };
  text("--frames", "A-B[xS]", "A picture for each of these frames, fractions allowed",
       [a](const std::string& t) { a->frames = parse_frames(t); });
  text("--size", "WxH", "Pixels (default 512x512)", [a](const std::string& t) { a->size = parse_size(t); });
  r.add_option("--camera", a->camera, "Fitted view, or a camera file (default ortho)")
      ->type_name("ortho|persp|FILE.json");
  add_number(r, "--rotate-x", a->rotate_x, "Degrees about the horizontal axis (default 20)");
  add_number(r, "--rotate-y", a->rotate_y, "Degrees about the vertical axis, applied first (default 30)");
  r.add_option("--tf", a->tf, "ParaView colour map (JSON)")->type_name("FILE.json");
  r.add_option("--colormap", a->colormap, concat("Built-in colours: ", join(colormap_names())))
      ->type_name("NAME");
  text("--range", "LO,HI",
       "Values the colours span (default: the percentiles 2 and 99.8; the file's own with --tf)",
       [a](const std::string& t) { a->range = option_numbers("--range", t, 2); });
  add_number(r, "--opacity", a->opacity, "Factor on all opacities");
  add_number(r, "--unit-distance", a->unit_distance,
             "World length the opacities are meant for (default: a mean voxel)");
  r.add_option("--dump-tf", a->dump_tf, "Write the transfer function as a ParaView colour map")
      ->type_name("FILE.json");
  add_choice<int32_t>(r, "--mode", a->mode,
                      {{"composite", BCCSPLAT_MODE_COMPOSITE},
                       {"iso", BCCSPLAT_MODE_ISOSURFACE},
                       {"xray", BCCSPLAT_MODE_XRAY},
                       {"mip", BCCSPLAT_MODE_MAXIMUM}},
                      "What is drawn (default composite)");
  add_number(r, "--iso", a->iso, "Value of the isosurface; makes --mode iso the default");
  add_choice<int32_t>(r, "--quality", a->quality,
                      {{"draft", BCCSPLAT_QUALITY_DRAFT},
                       {"normal", BCCSPLAT_QUALITY_NORMAL},
                       {"fine", BCCSPLAT_QUALITY_FINE},
                       {"best", BCCSPLAT_QUALITY_BEST}},
                      "Quality (default normal)");
  add_number(r, "--step", a->step, "Distance of the sheets in samples (default: by the quality)");
  r.add_option("--kernel", a->kernel, "Reconstruction kernel (default: the file's)")->type_name("NAME");
  r.add_option("--channel", a->channel, "Channel, by name or number (default: the first)")->type_name("NAME");
  r.add_flag("--no-shading", a->no_shading, "Colours without light");
  r.add_flag("--reference", a->reference, "Slow double-precision integration of the same field");
  text("--trail", "DT[,K]",
       "Motion blur: what was there during DT before the slice, in K sub-intervals of rising colour",
       [a](const std::string& t) {
         a->trail = option_numbers("--trail", t, 0);
         if (a->trail->size() > 2) fail_usage("--trail ", t, ": DT or DT,K is expected");
       });
  add_choice<int32_t>(r, "--trail-content", a->trail_content,
                      {{"classified", BCCSPLAT_TRAIL_CLASSIFIED},
                       {"mean", BCCSPLAT_TRAIL_MEAN},
                       {"max", BCCSPLAT_TRAIL_MAXIMUM}},
                      "What the trail holds (default classified)");
  add_choice<int32_t>(r, "--trail-mode", a->trail_mode,
                      {{"physical", BCCSPLAT_TRAIL_PHYSICAL},
                       {"interleaved", BCCSPLAT_TRAIL_INTERLEAVED},
                       {"post", BCCSPLAT_TRAIL_POST},
                       {"interleaved-consistent", BCCSPLAT_TRAIL_INTERLEAVED_CONSISTENT}},
                      "How trail and slice meet (default physical)");
  text("--background", "R,G,B", "PNG: opaque over this display colour, 0 to 1 each",
       [a](const std::string& t) {
         a->background = option_numbers("--background", t, 3);
         for (const double c : *a->background)
           if (c < 0 || c > 1) fail_usage("--background ", t, ": each part must be 0 to 1");
       });
  r.add_option("--stats", a->stats, "Write times and counts as JSON")->type_name("FILE.json");
  text("--repeat", "N", "Render N times and report medians", [a](const std::string& t) {
    a->repeat = option_number<int>("--repeat", t);
    if (a->repeat < 1 || a->repeat > 100000) fail_usage("--repeat ", t, ": 1 to 100000");
  });
  add_threads(r, a->common);
  add_max_memory(r, a->common);
  r.add_flag("--quiet", a->common.quiet, "Print warnings and errors only");
  return [a] { return run_render(*a); };
}

} // namespace bcc4

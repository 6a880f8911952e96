// SPDX-License-Identifier: Apache-2.0
// Declares the options of `bcc4 render` with their texts, and parses those that are no plain numbers.
#include "tool/view/render_arguments.h"

#include <algorithm>
#include <cmath>

#include "readers/sequence.h"
#include "tool/cli.h"
#include "tool/view/host_things.h"
#include "tool/view/iso_surfaces.h"
#include "tool/view/looks.h"
#include "tool/view/slice_sweep.h"
#include "tool/view/transfer_function.h"

namespace bcc4 {
namespace {

// "AxB" with A and B from 1 to `most`.
std::array<uint32_t, 2> parse_product(const std::string& option, const std::string& text, uint32_t most,
                                      const std::string& expected) {
  const auto parts = split(text, "x");
  const auto w = parts.size() == 2 ? parse_number<uint32_t>(parts[0]) : std::nullopt;
  const auto h = parts.size() == 2 ? parse_number<uint32_t>(parts[1]) : std::nullopt;
  if (!w || !h || *w < 1 || *h < 1 || *w > most || *h > most)
    fail_usage(option, " ", text, ": ", expected, ", of 1 to ", most);
  return {*w, *h};
}

std::array<uint32_t, 2> parse_size(const std::string& text) {
  constexpr uint32_t most = 65536;
  const bool square = text.find('x') == std::string::npos;
  return parse_product("--size", square ? concat(text, "x", text) : text, most,
                       "WxH or the edge of a square is expected, such as 512x512 or 512");
}

std::array<int32_t, 2> parse_rate(const std::string& text) {
  const size_t slash = text.find('/');
  const std::string_view all(text);
  const int32_t n = parse_number<int32_t>(trim(all.substr(0, slash))).value_or(0);
  const int32_t d =
      slash == std::string::npos ? 1 : parse_number<int32_t>(trim(all.substr(slash + 1))).value_or(0);
  if (n < 1 || d < 1)
    fail_usage("--fps ", text, ": N or N/D is expected, in whole numbers, such as 24 or 24000/1001");
  return {n, d};
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

std::optional<double> parse_noise(const std::string& text) {
  if (text == "auto") return std::nullopt;
  if (text == "none") return 0;
  const double noise = option_number<double>("--gradient-noise", text);
  if (!(noise >= 0 && std::isfinite(noise)))
    fail_usage("--gradient-noise ", text, ": auto, none or a value >= 0 is expected");
  return noise;
}

TrailInterval parse_trail(const std::string& text) {
  const auto parts = split(text, ",");
  if (parts.empty() || parts.size() > 2) fail_usage("--trail ", text, ": DT or DT,K is expected");
  TrailInterval t = parse_trail_span("--trail", std::string(parts[0]));
  if (parts.size() == 2) {
    const double k = option_number<double>("--trail", std::string(parts[1]));
    if (!(k >= 1 && k <= 256) || k != std::floor(k))
      fail_usage("--trail: K must be a whole number of sub-intervals, at most 256");
    t.intervals = static_cast<uint32_t>(k);
  }
  return t;
}

// Rotations of --view NAME.
const Choices<std::array<double, 2>> kViews{{"front", {0, 0}},  {"back", {0, 180}}, {"left", {0, -90}},
                                            {"right", {0, 90}}, {"top", {90, 0}},   {"bottom", {-90, 0}}};

// No name: all parts.
AnnotationParts parse_parts(const std::string& text) {
  AnnotationParts parts;
  const Choices<bool AnnotationParts::*> choices{
      {"colorbar", &AnnotationParts::colorbar}, {"time", &AnnotationParts::time},
      {"axes", &AnnotationParts::axes},         {"scale", &AnnotationParts::scale},
      {"box", &AnnotationParts::box},           {"title", &AnnotationParts::title}};
  if (text.empty() || text == "all") {
    for (const auto& [name, part] : choices) parts.*part = true;
    return parts;
  }
  if (lower(text).ends_with(".bcc4"))
    fail_usage("--annotate ", text, ": write --annotate=all, or the file before it");
  parts.by_name = true;
  for (const std::string& name : option_names("--annotate", text))
    parts.*option_choice("--annotate", name, choices) = true;
  return parts;
}

// Which pictures, and how large.
void add_pictures(const Command& command, RenderArguments& a) {
  command.add_text("--frames", "A-B[xS]", "A picture for each of these frames, fractions allowed",
                   [&a](const std::string& t) { a.frames = parse_frames(t); });
  command.add_text("--turntable", "N",
                   "N pictures, once around the vertical; with --frames: 1/N of a turn from each to the next",
                   [&a](const std::string& t) {
                     a.turntable = option_number<int>("--turntable", t);
                     if (*a.turntable < 1 || *a.turntable > 100000)
                       fail_usage("--turntable ", t, ": 1 to 100000 pictures");
                   });
  command.add_text(
      "--sheet", "CxR",
      "PNG: a contact sheet, pictures in so many columns and rows; of more pictures as many, evenly",
      [&a](const std::string& t) {
        a.sheet = parse_product("--sheet", t, 1000, "CxR is expected, columns and rows such as 4x3");
      });
  add_choice<int32_t>(
      command, "--layout", a.layout,
      {{"auto", BCCSPLAT_LAYOUT_DEFAULT},
       {"volume", BCCSPLAT_LAYOUT_VOLUME},
       {"planes", BCCSPLAT_LAYOUT_PLANES},
       {"both", BCCSPLAT_LAYOUT_BOTH},
       {"flat", BCCSPLAT_LAYOUT_FLAT}},
      "planes: three through the middle of what is seen, with the letters of their sides, as radiologists "
      "have "
      "them: the patient's right (R) is on the left of the picture. both: these and the volume. flat: a map "
      "seen from above. auto, the default: both for CT and MR, flat for maps, else, and wherever an option "
      "is "
      "of a volume's picture, the volume");
  command.add_text("--size", "WxH|N",
                   "Pixels of a picture, N: a square (default 512x512 for the volume and for each plane)",
                   [&a](const std::string& t) { a.size = parse_size(t); });
}

// Adds the options that place the camera.
void add_camera(const Command& command, RenderArguments& a) {
  command.add_option("--camera", a.camera, "Fitted view, or a camera file (default ortho)")
      .type_name("ortho|persp|FILE.json");
  command.add_text(
      "--view", "SIDE",
      "front: x to the right, y up, against z, as maps have it; of a patient the face, head up; back, left, "
      "right, top or bottom, as that picture has them",
      [&a](const std::string& t) { a.view = option_choice("--view", t, kViews); });
  add_number(command, "--rotate-x", a.rotate_x, "Degrees about the horizontal axis (default 20)");
  add_number(
      command, "--rotate-y", a.rotate_y,
      "Degrees about the vertical axis, applied first: the camera goes to the right (default 30; 0: front)");
  command
      .add_option(
          "--shape", a.shape,
          "Proportions of axes in different units, as degrees and metres: auto (default: what is alike "
          "keeps its own, what is not has a fair share), stored (the numbers as lengths) or SX,SY,SZ, "
          "factors on x, y and z")
      .type_name("auto|stored|SX,SY,SZ");
  command.add_text(
      "--fit", "WHAT",
      "seen: what the picture shows fills it, of a film that of all its moments (default); domain: all "
      "of the volume",
      [&a](const std::string& t) {
        a.fit_domain = option_choice<bool>("--fit", t, {{"seen", false}, {"domain", true}});
      });
  add_number(command, "--zoom", a.zoom,
             "Factor on the size of what is seen, about the middle of the picture");
}

// Adds what a picture shares with other programs.
void add_host(const Command& command, RenderArguments& a) {
  command.add_texts("--clip", "A,B,C,D",
                    "Draw only what has A x + B y + C z + D >= 0 in the world; may be given several times",
                    [&a](const std::string& t) { a.clips.push_back(parse_clip(t)); });
  command.add_text("--box", "X0,Y0,Z0,X1,Y1,Z1", "Draw only what is in this box of the world",
                   [&a](const std::string& t) {
                     const auto faces = parse_box(t);
                     a.clips.insert(a.clips.end(), faces.begin(), faces.end());
                   });
  command
      .add_option("--view-matrix", a.view_matrix,
                  "Another program's view: {\"world_to_view\": [16], \"projection\": [16], \"depth\": "
                  "\"0..1\", \"-1..1\" or \"reversed\"}, row by row, for columns")
      .type_name("FILE.json");
  command
      .add_option("--over", a.over,
                  "Another program's picture, with Z as distance along the view direction: what is nearer "
                  "hides the volume, the volume what is behind; its size is the picture's")
      .type_name("FILE.exr");
}

// Which colours and opacities values have.
void add_colours(const Command& command, RenderArguments& a) {
  add_choice<int32_t>(command, "--look", a.look, look_names(),
                      "Colours and opacities made from the file's histogram (default auto: air and noise "
                      "transparent, by the kind of the values)");
  command.add_option("--tf", a.tf, "ParaView colour map (JSON)").type_name("FILE.json");
  command.add_option("--colormap", a.colormap, concat("Built-in colours: ", join(colormap_names())))
      .type_name("NAME");
  command.add_text(
      "--range", "LO,HI",
      "Values the colours and a ramp of opacity span, whose first fiftieth from air is transparent "
      "(default: by "
      "--look; the file's own with --tf)",
      [&a](const std::string& t) { a.range = option_numbers("--range", t, 2); });
  add_number(command, "--opacity", a.opacity, "Factor on all opacities");
  add_number(command, "--unit-distance", a.unit_distance,
             "World length the opacities are meant for (default: a mean voxel)");
  command.add_option("--dump-tf", a.dump_tf, "Write the transfer function as a ParaView colour map")
      .type_name("FILE.json");
}

// What is drawn of the field.
void add_mode(const Command& command, RenderArguments& a) {
  add_choice<int32_t>(command, "--mode", a.mode,
                      {{"composite", BCCSPLAT_MODE_COMPOSITE},
                       {"iso", BCCSPLAT_MODE_ISOSURFACE},
                       {"xray", BCCSPLAT_MODE_XRAY},
                       {"mip", BCCSPLAT_MODE_MAXIMUM}},
                      "What is drawn (default composite); xray as PNG: exposed so that the most is white");
  command.add_text(
      "--iso", "V[:OPACITY[:#RRGGBB]][,...]",
      "Values of isosurfaces, each with an opacity (default 1) and a display colour (default: the transfer "
      "function's); makes --mode iso the default (its default: one value between air and object)",
      [&a](const std::string& t) { a.iso = parse_surfaces(t); });
}

// How well it is drawn.
void add_sampling(const Command& command, RenderArguments& a) {
  add_choice<int32_t>(command, "--quality", a.quality,
                      {{"draft", BCCSPLAT_QUALITY_DRAFT},
                       {"normal", BCCSPLAT_QUALITY_NORMAL},
                       {"fine", BCCSPLAT_QUALITY_FINE},
                       {"best", BCCSPLAT_QUALITY_BEST}},
                      "Quality (default normal)");
  add_number(command, "--step", a.step, "Distance of the sheets in samples (default: by the quality)");
  add_number(command, "--opacity-stop", a.opacity_stop,
             "A pixel this opaque is finished (default 0.995); 1: never, so that --deep has what lies behind "
             "dense matter, too");
  add_choice<int32_t>(command, "--preintegrate", a.preintegrate,
                      {{"auto", BCCSPLAT_PREINTEGRATE_DEFAULT},
                       {"on", BCCSPLAT_PREINTEGRATE_ON},
                       {"off", BCCSPLAT_PREINTEGRATE_OFF}},
                      "Draw what the transfer function shows between sheets (default auto: where it is "
                      "narrower than a step)");
  add_choice<int32_t>(command, "--smooth-edges", a.smooth_edges,
                      {{"auto", BCCSPLAT_SMOOTH_EDGES_DEFAULT},
                       {"on", BCCSPLAT_SMOOTH_EDGES_ON},
                       {"off", BCCSPLAT_SMOOTH_EDGES_OFF}},
                      "Four samples for each pixel on an edge of an isosurface (default auto: on, but with "
                      "--quality draft)");
  add_choice<int32_t>(
      command, "--gpu", a.backend,
      {{"auto", BCCSPLAT_BACKEND_AUTO}, {"on", BCCSPLAT_BACKEND_GPU}, {"off", BCCSPLAT_BACKEND_CPU}},
      "Draw by a GPU (default auto: by a graphics card, where there is one and it draws such a "
      "picture); bcc4 info --gpu says what there is");
  command
      .add_option("--kernel", a.kernel,
                  "Reconstruction kernel (default: the file's; of a file with kernel exact "
                  "the smoother default, but with --quality best)")
      .type_name("NAME");
  command.add_option("--channel", a.channel, "Channel, by name or number (default: the first)")
      .type_name("NAME");
  command.add_flag("--no-shading", a.no_shading, "Colours without light");
  command.add_text(
      "--gradient-noise", "auto|none|V",
      "Change of the value per mean voxel up to which there is no surface to be lit (default auto: the "
      "kernel's "
      "ripple and the noise that the file tells)",
      [&a](const std::string& t) { a.gradient_noise = parse_noise(t); });
  command.add_flag("--reference", a.reference, "Slow double-precision integration of the same field");
}

// What moved before or after the slice.
void add_trail(const Command& command, RenderArguments& a) {
  command.add_text(
      "--trail", "DT[f][,K]|A:B[f][,K]",
      "Motion blur: what was there during DT before the slice (after it when DT < 0), or from A to B around "
      "it, in the unit of --time, f: in frames; off the time axis samples along the normal. K: sub-intervals "
      "of rising colour",
      [&a](const std::string& t) { a.trail = parse_trail(t); });
  command.add_text("--trail-samples", "N",
                   "Stills per sub-interval (default: one per lattice layer or sample, 4 to 64)",
                   [&a](const std::string& t) {
                     a.trail_samples = option_number<uint32_t>("--trail-samples", t);
                     if (*a.trail_samples < 1 || *a.trail_samples > 4096)
                       fail_usage("--trail-samples ", t, ": 1 to 4096");
                   });
  command
      .add_option(
          "--shutter", a.shutter,
          "How a shutter opens and closes over the trail: box, triangle, or weights of sub-intervals, "
          "the earliest first; in the trail's own colours")
      .type_name("box|triangle|W,W[,W...]");
  command.add_flag("--trail-unlit", a.trail_unlit, "Do not light the trail, whatever the slice is");
  command
      .add_option("--trail-tf", a.trail_tf,
                  "ParaView colour map of the trail (default: the slice's), or one for each of its K "
                  "sub-intervals, the earliest first, separated by commas")
      .type_name("FILE.json[,FILE.json...]");
  command.add_option("--trail-colormap", a.trail_colormap, "Built-in colours of the trail").type_name("NAME");
  command.add_text("--trail-range", "LO,HI", "Values the trail's colours span",
                   [&a](const std::string& t) { a.trail_range = option_numbers("--trail-range", t, 2); });
  add_number(command, "--trail-opacity", a.trail_opacity, "Factor on the trail's opacities");
  add_choice<int32_t>(command, "--trail-content", a.trail_content,
                      {{"classified", BCCSPLAT_TRAIL_CLASSIFIED},
                       {"mean", BCCSPLAT_TRAIL_MEAN},
                       {"max", BCCSPLAT_TRAIL_MAXIMUM}},
                      "What the trail holds (default classified)");
  add_choice<int32_t>(command, "--trail-mode", a.trail_mode,
                      {{"physical", BCCSPLAT_TRAIL_PHYSICAL}, {"interleaved", BCCSPLAT_TRAIL_INTERLEAVED}},
                      "How trail and slice meet (default physical)");
}

// What is laid under pictures and over them.
void add_decoration(const Command& command, RenderArguments& a) {
  command.add_text(
      "--background", "R,G,B",
      "PNG and films: opaque over this display colour, 0 to 1 each (default: PNGs are transparent, films "
      "black)",
      [&a](const std::string& t) {
        a.background = option_numbers("--background", t, 3);
        for (const double c : *a.background)
          if (c < 0 || c > 1) fail_usage("--background ", t, ": each part must be 0 to 1");
      });
  command
      .add_text("--annotate", "PARTS",
                "Into PNGs and films: colorbar, time, axes, scale, box (of the domain), title, or some of "
                "them with "
                "commas "
                "(default: all)",
                [&a](const std::string& t) { a.annotate = parse_parts(t); })
      .expected(0, 1);
  command.add_text("--title", "TEXT",
                   "The title of --annotate (default: the file's name); alone: only a title",
                   [&a](const std::string& t) { a.title = t; });
}

// How fast pictures follow each other.
void add_films(const Command& command, RenderArguments& a) {
  command.add_text("--fps", "N[/D]",
                   "EXR and films: rate at which the pictures are to be shown (default 24 for sequences)",
                   [&a](const std::string& t) { a.fps = parse_rate(t); });
  command.add_text(
      "--seconds", "S",
      "Films: how long it lasts, by moments between frames; of --turntable how long a turn takes",
      [&a](const std::string& t) { a.seconds = option_number<double>("--seconds", t); });
  command.add_text("--loop", "N", "Films: shown N times, one after the other", [&a](const std::string& t) {
    constexpr int most = 1000;
    a.loop = option_number<int>("--loop", t);
    if (*a.loop < 1 || *a.loop > most) fail_usage("--loop ", t, ": 1 to ", most, " times");
  });
}

// Deep pictures.
void add_deep(const Command& command, RenderArguments& a) {
  command.add_flag(
      "--deep", a.deep,
      "EXR: a deep picture, samples along each ray as Z, ZBack, A, R, G, B, for compositing in depth");
  add_number(command, "--deep-tolerance", a.deep_tolerance,
             "What merging samples may cost the deep picture cut at any depth (default 0.001)");
}

// What is told of the work, and how much it may take.
void add_work(const Command& command, RenderArguments& a) {
  command.add_option("--stats", a.stats, "Write times and counts as JSON").type_name("FILE.json");
  command.add_text("--repeat", "N", "Render N times and report medians", [&a](const std::string& t) {
    a.repeat = option_number<int>("--repeat", t);
    if (a.repeat < 1 || a.repeat > 100000) fail_usage("--repeat ", t, ": 1 to 100000");
  });
  add_threads(command, a.common);
  add_max_memory(command, a.common);
  command.add_flag("--overwrite", a.overwrite, "Replace existing outputs");
  command.add_flag("--quiet", a.common.quiet, "Print warnings and errors only");
}

} // namespace

void add_render_options(const Command& command, RenderArguments& a) {
  command.add_option("FILE", a.file, "A .bcc4 file");
  command
      .add_option(
          "-o,--output,--out", a.output,
          "The .png or .exr to write; a pattern such as p.%04d.png for several; or a film of them, .mp4, "
          ".webm or .webp, encoded by ffmpeg")
      .type_name("OUT");
  const Command which = command.under("The moment or plane"), colours = command.under("Colours and surfaces");
  add_slice_choice(which, a.which);
  add_sweep(which, a.which);
  add_pictures(command.under("Pictures and films"), a);
  add_films(command.under("Pictures and films"), a);
  add_camera(command.under("The view"), a);
  add_mode(colours, a);
  add_colours(colours, a);
  add_beside(command.under("Beside the channel"), a.beside);
  add_trail(command.under("Trails: what moved"), a);
  add_decoration(command.under("Background and annotation"), a);
  add_sampling(command.under("Quality and light"), a);
  add_host(command.under("With other programs' pictures"), a);
  add_deep(command.under("With other programs' pictures"), a);
  add_work(command.under("The work"), a);
}

} // namespace bcc4

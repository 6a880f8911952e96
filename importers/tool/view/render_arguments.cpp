// SPDX-License-Identifier: Apache-2.0
// Refuses arguments of `bcc4 render` that exclude each other or that the kind of file has no place for.
// Nothing here needs a volume.
#include "tool/view/render_arguments.h"
#include "readers/system.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tool/cli.h"
#include "tool/output/film.h"
#include "tool/view/film_rate.h"

namespace bcc4 {
namespace {

constexpr double most_pictures = 1e6;

// What the kind of file that is written has no place for.
void check_output(const RenderArguments& a) {
  const bool exr = lower(a.output).ends_with(".exr"), film = is_film(a.output);
  if (!exr && !film && !lower(a.output).ends_with(".png"))
    fail_usage("-o ", a.output, ": must end in .png or .exr, or a film in .mp4, .webm or .webp");
  if (a.background && exr) fail_usage("--background is for PNG and films; an EXR keeps its opacity");
  if (a.fps && !exr && !film) fail_usage("--fps is for EXR and films; a PNG has no place for a rate");
  if ((a.seconds || a.loop) && !film) fail_usage("--seconds and --loop are for films: -o film.mp4");
  if (a.deep && !exr) fail_usage("--deep is for EXR: -o picture.exr");
  if (exr && (a.annotate || !a.title.empty()))
    fail_usage("--annotate and --title are for PNG and films; an EXR keeps what was rendered");
  if (a.sheet && (exr || film)) fail_usage("--sheet is a PNG: -o sheet.png");
}

} // namespace

bool makes_one_file(const RenderArguments& a) { return a.sheet || is_film(a.output); }

std::optional<size_t> pictures_of_film(const RenderArguments& a) {
  if (!a.seconds) return std::nullopt;
  const std::array<int32_t, 2> rate = a.fps.value_or(usual_rate);
  const double count = std::round(*a.seconds * rate[0] / rate[1]);
  if (!(count >= 2 && count <= most_pictures))
    fail_usage("--seconds ", *a.seconds, ": at ", rate[0], rate[1] > 1 ? concat("/", rate[1]) : "",
               " pictures a second that is ", count, " pictures; 2 to ", most_pictures, " can be drawn");
  return static_cast<size_t>(count);
}

std::vector<std::string> trail_tf_files(const RenderArguments& a) {
  if (a.trail_tf.empty()) return {};
  if (std::filesystem::exists(to_path(a.trail_tf))) return {a.trail_tf}; // whatever its name holds
  std::vector<std::string> files;
  for (const std::string_view file : split(a.trail_tf, ",")) files.emplace_back(file);
  return files;
}

bool has_trail(const RenderArguments& a) {
  return a.trail || std::any_of(a.beside.others.begin(), a.beside.others.end(),
                                [](const OtherVolume& o) { return o.trail.has_value(); });
}

std::vector<double> shutter_weights(const RenderArguments& a) {
  constexpr uint32_t parts_of_triangle = 16; // where nobody says how many
  if (a.shutter.empty() || !has_trail(a)) return {};
  const bool triangle = a.shutter == "triangle";
  if (!triangle && a.shutter != "box") {
    std::vector<double> weights;
    for (const std::string_view weight : split(a.shutter, ","))
      weights.push_back(option_number<double>("--shutter", std::string(weight)));
    return weights;
  }
  const uint32_t given = a.trail ? a.trail->intervals : 0;
  const uint32_t parts = triangle && given == 0 ? parts_of_triangle : given;
  std::vector<double> weights(std::max(parts, 1u), 1);
  for (size_t i = 0; triangle && i < weights.size(); ++i)
    weights[i] = 1 - std::fabs((2 * static_cast<double>(i) + 1) / static_cast<double>(weights.size()) - 1);
  return weights;
}

uint32_t trail_intervals(const RenderArguments& a) {
  if (!a.trail) return 0;
  const size_t weights = shutter_weights(a).size();
  return weights > 0 ? static_cast<uint32_t>(weights) : std::max(a.trail->intervals, 1u);
}

namespace {

void check_shutter(const RenderArguments& a) {
  const std::vector<double> weights = shutter_weights(a);
  constexpr size_t most_parts = 256;
  constexpr double largest_weight = 1e9;
  if (weights.size() > most_parts) fail_usage("--shutter: at most ", most_parts, " weights");
  double sum = 0;
  for (const double w : weights) {
    if (!(w >= 0 && w <= largest_weight)) fail_usage("--shutter ", a.shutter, ": weights are 0 to 1e9");
    sum += w;
  }
  if (!weights.empty() && !(sum > 0))
    fail_usage("--shutter ", a.shutter, ": a shutter that is never open shows nothing; leave --trail out");
  if (!weights.empty() && a.trail && a.trail->intervals > 0 && a.trail->intervals != weights.size())
    fail_usage("--shutter names ", weights.size(), " weights for ", a.trail->intervals,
               " sub-intervals; ask for as many with --trail DT,", weights.size());
}

} // namespace

std::array<double, 2> rotations(const RenderArguments& a) {
  return a.view.value_or(std::array{a.rotate_x.value_or(20), a.rotate_y.value_or(30)});
}

void check_arguments(const RenderArguments& a) {
  require_option(a.file, "FILE", "bcc4 render smoke.bcc4 --time 10 -o smoke.png");
  require_option(a.output, "-o", "-o picture.png");
  check_output(a);
  check_beside(a.beside);
  if ((a.beside.shadow || a.beside.occlusion) &&
      (a.no_shading || a.reference || has_trail(a) || a.mode == BCCSPLAT_MODE_XRAY ||
       a.mode == BCCSPLAT_MODE_MAXIMUM || a.mode == BCCSPLAT_MODE_ISOSURFACE))
    fail_usage("--shadow and --ao are of lit composites, without --no-shading, --reference and --trail");
  if (a.deep && (a.mode == BCCSPLAT_MODE_XRAY || a.mode == BCCSPLAT_MODE_MAXIMUM || a.reference))
    fail_usage("--deep goes with --mode composite and iso, without --reference");
  if (!a.iso.empty() && a.mode != BCCSPLAT_MODE_DEFAULT && a.mode != BCCSPLAT_MODE_ISOSURFACE)
    fail_usage("--iso is the value of an isosurface; another --mode has none");
  if (has_trail(a) &&
      std::any_of(a.iso.begin(), a.iso.end(), [](const auto& s) { return s.opacity > 0 && s.opacity < 1; }))
    fail_usage("--trail goes with isosurfaces that are opaque; leave the opacities of --iso out");
  if (a.opacity_stop && !(*a.opacity_stop >= 1e-3 && *a.opacity_stop <= 1))
    fail_usage("--opacity-stop ", *a.opacity_stop, ": 0.001 to 1");
  if (a.look != BCCSPLAT_LOOK_DEFAULT && (!a.tf.empty() || a.range))
    fail_usage("--look makes the transfer function by itself; --tf and --range exclude it");
  if (a.deep_tolerance && !a.deep) fail_usage("--deep-tolerance goes with --deep");
  if (a.deep_tolerance && !(*a.deep_tolerance > 0 && *a.deep_tolerance <= 1))
    fail_usage("--deep-tolerance ", *a.deep_tolerance, ": above 0, at most 1");
  const bool trail_function =
      !a.trail_tf.empty() || !a.trail_colormap.empty() || a.trail_range || a.trail_opacity;
  if (!has_trail(a) &&
      (!a.shutter.empty() || a.trail_unlit || a.trail_content || a.trail_mode || a.trail_samples))
    fail_usage("--trail-content, --trail-mode and the like go with --trail DT");
  if (!a.trail && trail_function)
    fail_usage("--trail-tf, --trail-colormap, --trail-range and --trail-opacity go with --trail DT");
  check_shutter(a);
  const uint32_t parts = trail_intervals(a);
  if (const size_t files = trail_tf_files(a).size(); files > 1 && files != parts)
    fail_usage("--trail-tf names ", files, " files for ", parts,
               " sub-intervals; ask for as many with --trail DT,", files);
  if (a.which.sweep && (a.frames || a.turntable)) fail_usage("--sweep excludes --frames and --turntable");
  if (a.seconds && (a.which.sweep || (a.frames && a.turntable)))
    fail_usage(
        "--seconds sets how many pictures there are, and so do --sweep, and --frames with --turntable");
  if (a.view && (a.rotate_x || a.rotate_y))
    fail_usage("--view and --rotate-x, --rotate-y exclude each other");
  if (a.zoom && !(*a.zoom >= 1e-3 && *a.zoom <= 1e6)) fail_usage("--zoom ", *a.zoom, ": 0.001 to 1e6");
  if (a.step && !(*a.step > 0)) fail_usage("--step must be positive");
  for (const auto& [option, opacity] :
       {std::pair("--opacity", a.opacity), {"--trail-opacity", a.trail_opacity}})
    if (opacity && !(*opacity >= 0 && std::isfinite(*opacity)))
      fail_usage(option, " ", *opacity, ": must be finite and not negative");
  if (a.unit_distance && !(*a.unit_distance > 0)) fail_usage("--unit-distance must be positive");
}

} // namespace bcc4

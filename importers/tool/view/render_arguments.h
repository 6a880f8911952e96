// SPDX-License-Identifier: Apache-2.0
// What `bcc4 render` was asked for.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bccsplat.h"
#include "tool/options.h"
#include "tool/view/beside.h"
#include "tool/view/slice_choice.h"
#include "tool/view/trail_interval.h"

namespace bcc4 {

struct FrameRange {
  double first = 0, last = 0, step = 1;
};

// What --annotate draws into a picture.
struct AnnotationParts {
  bool colorbar = false, time = false, axes = false, scale = false, box = false, title = false;
  bool by_name = false; // some of them, which the user wants to see
};

struct RenderArguments {
  std::string file, output, kernel, channel;
  SliceChoiceArguments which;
  std::optional<FrameRange> frames;
  std::optional<int> turntable;                 // pictures
  std::optional<std::array<uint32_t, 2>> sheet; // columns and rows
  std::optional<std::array<uint32_t, 2>> size;
  std::string camera = "ortho";
  std::optional<double> rotate_x, rotate_y, zoom;
  std::optional<std::array<double, 2>> view; // rotations of a side; none: by rotate_x, rotate_y
  std::string shape = "auto";
  std::array<double, 3> shape_drawn{}; // the factors that became of it; 0: none
  std::optional<bool> fit_domain;      // whether all of the volume fills the picture, or what is seen of it
  std::vector<bccsplat_clip> clips;    // of the world
  std::string view_matrix, over;       // files
  std::string tf, colormap, dump_tf, trail_tf, trail_colormap;
  std::optional<std::vector<double>> range, trail_range;
  std::optional<double> opacity, trail_opacity, step, unit_distance, opacity_stop;
  BesideArguments beside;
  std::vector<bccsplat_iso_surface> iso; // none: the look's
  int32_t mode = BCCSPLAT_MODE_DEFAULT;
  int32_t look = BCCSPLAT_LOOK_DEFAULT;
  int32_t layout = BCCSPLAT_LAYOUT_DEFAULT;
  int32_t quality = BCCSPLAT_QUALITY_DEFAULT;
  int32_t preintegrate = BCCSPLAT_PREINTEGRATE_DEFAULT;
  int32_t smooth_edges = BCCSPLAT_SMOOTH_EDGES_DEFAULT;
  int32_t backend = BCCSPLAT_BACKEND_DEFAULT;
  std::optional<double> gradient_noise; // none: as the file tells
  bool no_shading = false, reference = false, deep = false;
  std::optional<double> deep_tolerance;
  std::optional<TrailInterval> trail;
  std::optional<uint32_t> trail_samples;
  std::string shutter; // the curve of a trail: "box", "triangle", or weights; empty: none
  bool trail_unlit = false;
  int32_t trail_content = BCCSPLAT_TRAIL_CONTENT_DEFAULT;
  int32_t trail_mode = BCCSPLAT_TRAIL_COMBINE_DEFAULT;
  std::optional<std::vector<double>> background; // display colours
  std::optional<std::array<int32_t, 2>> fps;     // numerator and denominator
  std::optional<double> seconds;                 // that a film lasts, once
  std::optional<int> loop;                       // times that a film is shown
  std::optional<AnnotationParts> annotate;
  std::string title;
  std::string command_line; // what was typed
  std::string stats;
  int repeat = 1;
  bool overwrite = false;
  CommonOptions common;
};

void add_render_options(const Command& command, RenderArguments& arguments);
// A film or a sheet: one file for all pictures.
[[nodiscard]] bool makes_one_file(const RenderArguments& arguments);
// The pictures that a film of --seconds has; none: as many as there are.
[[nodiscard]] std::optional<size_t> pictures_of_film(const RenderArguments& arguments);
// The files of --trail-tf: one for all sub-intervals of the trail, or one for each.
[[nodiscard]] std::vector<std::string> trail_tf_files(const RenderArguments& arguments);
// The weights of the trail's sub-intervals by --shutter; none: all alike.
[[nodiscard]] std::vector<double> shutter_weights(const RenderArguments& arguments);
// Whether anything in the picture has a trail.
[[nodiscard]] bool has_trail(const RenderArguments& arguments);
// The sub-intervals of the trail of --trail; 0: there is none.
[[nodiscard]] uint32_t trail_intervals(const RenderArguments& arguments);
// The rotations about x and y that the fitted view has.
[[nodiscard]] std::array<double, 2> rotations(const RenderArguments& arguments);
// What no single option can tell.
void check_arguments(const RenderArguments& arguments);

} // namespace bcc4

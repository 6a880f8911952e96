// SPDX-License-Identifier: Apache-2.0
// Divides a picture into parts, and tells which options are of a volume alone.
#include "tool/view/picture_layout.h"

#include <algorithm>

#include "tool/annotate/font.h"
#include "tool/cli.h"
#include "tool/output/film.h"

namespace bcc4 {
namespace {

constexpr uint32_t least_pane = 96;      // pixels a side, which letters have room in
constexpr uint32_t pane_gap_share = 100; // a gap is this part of a picture's smaller side

// An option that says how a volume is drawn, or from what.
struct VolumeOption {
  const char* name;
  bool given;
  bool beside_planes; // whether the volume beside planes can have it
};

std::vector<VolumeOption> volume_options(const RenderArguments& a) {
  const SliceChoiceArguments& w = a.which;
  const auto& b = a.beside;
  return {{"--plane", w.plane.has_value(), false},
          {"--point", w.point.has_value(), false},
          {"--sweep", w.sweep.has_value(), false},
          {"--thickness", w.thickness.has_value(), false},
          {"--slice-spacing", w.spacing.has_value(), false},
          {"--bandwidth", w.bandwidth.has_value(), false},
          {"--slice-method", w.method != BCCSPLAT_METHOD_DEFAULT, false},
          {"--slice-lattice", w.lattice != BCCSPLAT_LATTICE_DEFAULT, false},
          {"--deep", a.deep, false},
          {"-o PICTURE.exr", lower(a.output).ends_with(".exr"), false},
          {"--over", !a.over.empty(), false},
          {"--view-matrix", !a.view_matrix.empty(), false},
          {"--level", w.level.has_value(), true},
          {"--camera", a.camera != "ortho", true},
          {"--view", a.view.has_value(), true},
          {"--rotate-x", a.rotate_x.has_value(), true},
          {"--rotate-y", a.rotate_y.has_value(), true},
          {"--zoom", a.zoom.has_value(), true},
          {"--turntable", a.turntable.has_value(), true},
          {"--clip", !a.clips.empty(), true},
          {"--mode", a.mode != BCCSPLAT_MODE_DEFAULT, true},
          {"--iso", !a.iso.empty(), true},
          {"--opacity", a.opacity.has_value(), true},
          {"--unit-distance", a.unit_distance.has_value(), true},
          {"--quality", a.quality != BCCSPLAT_QUALITY_DEFAULT, true},
          {"--step", a.step.has_value(), true},
          {"--opacity-stop", a.opacity_stop.has_value(), true},
          {"--preintegrate", a.preintegrate != BCCSPLAT_PREINTEGRATE_DEFAULT, true},
          {"--smooth-edges", a.smooth_edges != BCCSPLAT_SMOOTH_EDGES_DEFAULT, true},
          {"--gpu", a.backend != BCCSPLAT_BACKEND_DEFAULT, true},
          {"--kernel", !a.kernel.empty(), true},
          {"--no-shading", a.no_shading, true},
          {"--gradient-noise", a.gradient_noise.has_value(), true},
          {"--reference", a.reference, true},
          {"--trail", has_trail(a), true},
          {"--with, --color-channel and the like", b.needs_scene(), true},
          {"--shadow, --ao and --light", b.shadow || b.occlusion || !b.lights.empty(), true},
          {"--annotate", a.annotate.has_value() || !a.title.empty(), true},
          {"--stats", !a.stats.empty(), true},
          {"--repeat", a.repeat > 1, true}};
}

// Whether somebody wants to see the volume as he says, or several pictures of it in one file.
bool asks_for_volume(const RenderArguments& a, const std::vector<VolumeOption>& options) {
  return std::any_of(options.begin(), options.end(), [](const VolumeOption& o) { return o.given; }) ||
         makes_one_file(a) || a.fit_domain || a.shape != "auto" || a.look != BCCSPLAT_LOOK_DEFAULT ||
         !a.tf.empty();
}

// So many columns and rows in the picture; where none is given, each of the size of a volume's.
std::vector<Pane> divide(PictureSize& whole, const PictureSize& pane, bool given, uint32_t columns,
                         uint32_t rows) {
  if (!given) whole = {pane.width * columns, pane.height * rows};
  const uint32_t gap = std::max<uint32_t>(2, std::min(whole.width, whole.height) / pane_gap_share);
  const auto side = [&](uint32_t pixels, uint32_t count) {
    return pixels > gap * (count - 1) ? (pixels - gap * (count - 1)) / count : 0;
  };
  const PictureSize size{side(whole.width, columns), side(whole.height, rows)};
  std::vector<Pane> panes;
  for (uint32_t r = 0; r < rows; ++r)
    for (uint32_t c = 0; c < columns; ++c)
      panes.push_back({c * (size.width + gap), r * (size.height + gap), size});
  return panes;
}

} // namespace

PictureLayout choose_layout(const RenderArguments& a, int32_t of_kind, const std::array<uint32_t, 2>& size) {
  const std::vector<VolumeOption> options = volume_options(a);
  const bool chosen = a.layout != BCCSPLAT_LAYOUT_DEFAULT;
  const PictureSize volume{size[0], size[1]};
  PictureLayout alone{BCCSPLAT_LAYOUT_VOLUME, volume, {}, {0, 0, volume}};
  const int32_t kind = chosen ? a.layout : of_kind;
  if (kind == BCCSPLAT_LAYOUT_VOLUME || (!chosen && (!has_font() || asks_for_volume(a, options))))
    return alone;
  for (const VolumeOption& o : options)
    if (o.given && !(o.beside_planes && kind == BCCSPLAT_LAYOUT_BOTH))
      fail_usage(o.name, ": ",
                 kind == BCCSPLAT_LAYOUT_BOTH ? "no picture beside planes has it"
                                              : "planes have no use for it",
                 "; --layout volume");
  PictureLayout layout{kind, volume, {}, {}};
  const bool given = a.size.has_value();
  if (kind == BCCSPLAT_LAYOUT_BOTH)
    layout.planes = divide(layout.whole, volume, given, 2, 2);
  else
    layout.planes = divide(layout.whole, volume, given, kind == BCCSPLAT_LAYOUT_PLANES ? 3 : 1, 1);
  const PictureSize pane = layout.planes.front().size;
  if (kind == BCCSPLAT_LAYOUT_BOTH) layout.volume = layout.planes.back(), layout.planes.pop_back();
  if (std::min(pane.width, pane.height) >= least_pane) return layout;
  if (!chosen) return alone;
  fail_usage("--layout: of a picture of ", layout.whole.width, " x ", layout.whole.height,
             " pixels each part has ", pane.width, " x ", pane.height, ", ", least_pane, " x ", least_pane,
             " is the least");
}

} // namespace bcc4

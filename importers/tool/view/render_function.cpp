// SPDX-License-Identifier: Apache-2.0
// Makes transfer functions of options, of looks and of what either leaves open.
#include "tool/view/render_function.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace bcc4 {
namespace {

constexpr double one_sample = 1.5; // what is thinner is one sample thick

// The map over a range that was given: greys where the look has these, as scans do.
const char* usual_map(const bccsplat_look& look) {
  for (uint32_t i = 0; i < look.color_count; ++i) {
    const double* const c = look.colors[i];
    if (c[1] != c[2] || c[2] != c[3]) return "viridis";
  }
  return "gray";
}

} // namespace

std::vector<std::array<double, 4>> colors_of(const bccsplat_look& look) {
  std::vector<std::array<double, 4>> colors;
  for (uint32_t i = 0; i < look.color_count; ++i)
    colors.push_back({look.colors[i][0], look.colors[i][1], look.colors[i][2], look.colors[i][3]});
  return colors;
}

FunctionChoice slice_function(const RenderArguments& a) {
  return {a.tf,
          a.colormap,
          a.range,
          a.opacity,
          a.unit_distance,
          a.look,
          !a.dump_tf.empty(),
          a.mode == BCCSPLAT_MODE_MAXIMUM};
}

std::vector<FunctionChoice> trail_functions(const RenderArguments& a) {
  FunctionChoice c = slice_function(a);
  if (!a.trail_tf.empty() || !a.trail_colormap.empty()) c.tf = a.trail_tf, c.colormap = a.trail_colormap;
  if (!a.trail_tf.empty()) c.range.reset(), c.opacity.reset(); // those are of the slice's colours
  if (a.trail_range) c.range = a.trail_range;
  if (a.trail_opacity) c.opacity = a.trail_opacity;
  c.always = !a.trail_tf.empty() || !a.trail_colormap.empty() || a.trail_range || a.trail_opacity;
  if (!c.always) return {};
  std::vector<FunctionChoice> choices;
  for (const std::string& file : trail_tf_files(a)) choices.emplace_back(c).tf = file;
  if (choices.empty()) choices.push_back(c);
  return choices;
}

std::optional<TransferFunction> transfer_function(const FunctionChoice& a, const bccsplat_channel_info& c,
                                                  const bccsplat_look& look) {
  if (a.tf.empty() && a.colormap.empty() && !a.range && !a.opacity && !a.unit_distance && !a.always &&
      a.look == BCCSPLAT_LOOK_DEFAULT)
    return std::nullopt;
  if (!a.tf.empty() && !a.colormap.empty()) fail_usage("--tf and --colormap exclude each other");
  double low = look.range[0], high = look.range[1];
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
  // Who gives values gets a ramp over them; else the look says what is transparent.
  const bool given = a.range.has_value() || !a.tf.empty();
  if (f.colors.empty() && !given && a.colormap.empty()) f.colors = colors_of(look);
  if (f.colors.empty())
    f.colors = colormap(a.colormap.empty() ? usual_map(look) : a.colormap, low, high).colors;
  if (f.opacities.empty() && !given)
    for (uint32_t i = 0; i < look.opacity_count; ++i)
      f.opacities.push_back({look.opacities[i][0], look.opacities[i][1]});
  if (f.opacities.empty())
    add_default_opacity(f, low, high, {c.air, {look.empty[0], look.empty[1]}, a.opaque});
  scale_opacity(f, a.opacity.value_or(1));
  if (a.unit_distance) f.unit_distance = *a.unit_distance;
  return f;
}

std::optional<TransferFunction> function_of_dense_trail(const FunctionChoice& slice,
                                                        const bccsplat_look& look) {
  if (look.kind != BCCSPLAT_KIND_DENSE || !by_look(slice) || !slice.colormap.empty()) return std::nullopt;
  const bool above = !std::isinf(look.empty[1]);
  TransferFunction f;
  f.colors = colors_of(look);
  for (uint32_t i = 0; i < look.opacity_count; ++i) {
    const auto& [value, opacity] = look.opacities[i];
    if (above ? value > look.iso_value : value < look.iso_value) f.opacities.push_back({value, opacity});
  }
  f.opacities.insert(above ? f.opacities.begin() : f.opacities.end(), {look.iso_value, 0});
  return f;
}

bool by_look(const FunctionChoice& a) { return a.tf.empty() && !a.range && !a.unit_distance; }

double distance_of_look(const bccsplat_volume_info& volume, const bccsplat_slice_info& slice) {
  const double* m = slice.affine;
  const double world = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                       m[2] * (m[4] * m[9] - m[5] * m[8]);
  const double* plane = slice.hyperplane;
  const bool moment = plane[0] == 0 && plane[1] == 0 && plane[2] == 0;
  double shortest = HUGE_VAL, frame = 1;
  for (const auto& [begin, end] : slice.extent) shortest = std::min(shortest, end - begin);
  if (moment && shortest > one_sample) return 0;
  for (size_t a = 0; a < 3; ++a) frame *= static_cast<double>(volume.dims[a]);
  return std::max(shortest, 1.0) * std::cbrt(std::fabs(world) / frame);
}

bccsplat_look make_look(const Volume& volume, uint32_t channel, int32_t look, int32_t mode) {
  auto made = sized<bccsplat_look>();
  check(bccsplat_volume_get_look(volume.get(), channel, look, mode, &made), "--look");
  return made;
}

bccsplat_look make_look(const Slice& slice, int32_t look, int32_t mode) {
  auto made = sized<bccsplat_look>();
  check(bccsplat_slice_get_look(slice.get(), look, mode, &made), "--look");
  return made;
}

std::string look_in_words(const bccsplat_look& l) {
  switch (l.kind) {
  case BCCSPLAT_KIND_EMPTY:
    return "nothing but air";
  case BCCSPLAT_KIND_CONSTANT:
    return "one value beside air";
  case BCCSPLAT_KIND_LABELS:
    return "labels, a colour for each";
  case BCCSPLAT_KIND_LEVEL_SET:
    return "a level set, its surface at 0";
  default:
    break;
  }
  if (l.empty[0] > l.empty[1]) return "no air found, all values drawn";
  const std::string from = short_number(l.empty[0], 3), to = short_number(l.empty[1], 3);
  const std::string what = l.kind == BCCSPLAT_KIND_DENSE ? "the commoner values" : "air and noise";
  if (std::isinf(l.empty[0])) return concat(what, " below ", to, " transparent");
  if (std::isinf(l.empty[1])) return concat(what, " above ", from, " transparent");
  return concat(what, " from ", from, " to ", to, " transparent");
}

bccsplat_transfer_function as_struct(const TransferFunction& f) {
  auto t = sized<bccsplat_transfer_function>();
  t.color_count = static_cast<uint32_t>(f.colors.size());
  t.colors = f.colors.front().data();
  t.opacity_count = static_cast<uint32_t>(f.opacities.size());
  t.opacities = f.opacities.front().data();
  t.unit_distance = f.unit_distance;
  return t;
}

} // namespace bcc4

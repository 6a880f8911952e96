// SPDX-License-Identifier: Apache-2.0
// Declares the options, makes a cut of them by the times of an opened volume, and has the library make the
// slice.
#include "tool/view/slice_choice.h"

#include <algorithm>

#include "tool/cli.h"
#include "tool/interrupt.h"
#include "tool/view/even_places.h"
#include "tool/view/time_slice.h"

namespace bcc4 {

namespace {

SampleBox parse_region(const std::string& text) {
  SampleBox box;
  const auto parts = split_commas(text);
  if (parts.size() != 3)
    fail_usage("--roi ", text, ": X0-X1,Y0-Y1,Z0-Z1 is expected, such as 0-31,0-31,10-20");
  for (size_t a = 0; a < 3; ++a) {
    const std::string part(parts[a]);
    const size_t dash = part.find('-');
    box.begin[a] = option_number<uint64_t>("--roi", part.substr(0, dash));
    const uint64_t last =
        dash == std::string::npos ? box.begin[a] : option_number<uint64_t>("--roi", part.substr(dash + 1));
    if (last < box.begin[a] || last > INT32_MAX) fail_usage("--roi ", text, ": ", part, " does not rise");
    box.dims[a] = last - box.begin[a] + 1;
  }
  return box;
}

} // namespace

void add_region(const Command& command, std::optional<SampleBox>& region, const char* help) {
  command.add_text("--roi", "X0-X1,Y0-Y1,Z0-Z1", help,
                   [&region](const std::string& text) { region = parse_region(text); });
}

void add_motion(const Command& command, int32_t& motion) {
  add_choice<int32_t>(
      command, "--motion", motion,
      {{"auto", BCCSPLAT_MOTION_DEFAULT}, {"on", BCCSPLAT_MOTION_ON}, {"off", BCCSPLAT_MOTION_OFF}},
      "Between frames, follow what moves from one to the next (default: auto, which is off: "
      "it takes several times as long)");
}

void add_slice_choice(const Command& command, SliceChoiceArguments& a) {
  add_number(command, "--time", a.time, "Time of the slice, in the file's unit");
  command.add_flag("--index", a.index, "--time is a frame number, fractions allowed");
  const auto numbers = [&command](const char* option, std::optional<std::vector<double>>& target,
                                  size_t count, const char* form, const char* help) {
    command.add_text(option, form, help, [&target, option, count](const std::string& text) {
      target = option_numbers(option, text, count);
    });
  };
  numbers("--plane", a.plane, 5, "a,b,c,d,e",
          "Hyperplane a x + b y + c z + d t + e = 0, in samples and frames");
  numbers("--point", a.point, 4, "x,y,z,t",
          "Instead of --plane: a point of the hyperplane, the slice's origin");
  numbers("--basis", a.basis, 12, "u,v,w", "With --point: three directions x,y,z,t in the hyperplane");
  command
      .add_option("--level", a.level,
                  "Cut a coarser level of the file, see bcc4 info: an eighth of the work each (default: "
                  "render takes the "
                  "coarsest that draws the picture as well as its quality asks, slice all of it, 0)")
      .type_name("N");
  add_number(command, "--thickness", a.thickness,
             "Of a slab around the hyperplane, in samples (or frames) along its normal");
  add_choice<int32_t>(
      command, "--slab", a.slab,
      {{"mean", BCCSPLAT_SLAB_MEAN}, {"sum", BCCSPLAT_SLAB_SUM}, {"max", BCCSPLAT_SLAB_MAXIMUM}},
      "What the slab holds along its normal (default: mean)");
  add_choice<int32_t>(command, "--slice-method", a.method,
                      {{"merged", BCCSPLAT_METHOD_MERGED},
                       {"resampled", BCCSPLAT_METHOD_RESAMPLED},
                       {"extracted", BCCSPLAT_METHOD_EXTRACTED}},
                      "How the slice is made (default: merged where the hyperplane allows it)");
  add_choice<int32_t>(command, "--slice-lattice", a.lattice,
                      {{"bcc", BCCSPLAT_LATTICE_BCC}, {"cc", BCCSPLAT_LATTICE_CC}},
                      "Lattice of the slice (default: the volume's where it is merged, else bcc)");
  add_region(command, a.region,
             "Only this box of a time slice: samples from 0, both ends included. Costs what the box costs");
  add_motion(command, a.motion);
  add_number(command, "--slice-spacing", a.spacing,
             "Spacing of that lattice in samples (default: the source's)");
  numbers("--bandwidth", a.bandwidth, 4, "wx,wy,wz,wt",
          "With --kernel paper: widths of the 4D filter that a resampled slice is made by (the paper's "
          "equation 6), in distances of the file's lattice from 1 on");
}

Cut cut_at_index(const Volume& volume, double index) {
  Cut cut;
  cut.plane[3] = 1;
  cut.plane[4] = -index;
  cut.index = index;
  check(bccsplat_volume_index_to_time(volume.get(), index, &cut.time), "");
  return cut;
}

namespace {

Cut resolve_plane(const Volume& volume, const SliceChoiceArguments& a) {
  if (a.point || a.basis) {
    if (!a.point || !a.basis) fail_usage("--point and --basis go together");
    if (a.plane || a.time || a.index) fail_usage("--point and --basis exclude --plane and --time");
    Cut cut;
    cut.is_time_slice = false; // resampled on a lattice of its own, whatever its normal
    cut.point.emplace();
    std::copy(a.point->begin(), a.point->end(), cut.point->begin());
    std::copy(a.basis->begin(), a.basis->end(), cut.basis.begin());
    return cut;
  }
  if (a.plane) {
    if (a.time || a.index) fail_usage("--plane and --time exclude each other");
    Cut cut;
    cut.is_time_slice = (*a.plane)[0] == 0 && (*a.plane)[1] == 0 && (*a.plane)[2] == 0;
    std::copy(a.plane->begin(), a.plane->end(), cut.plane);
    if (cut.is_time_slice && (*a.plane)[3] == 0) fail_usage("--plane: a, b, c and d must not all be 0");
    if (!cut.is_time_slice && volume_info(volume).dims[3] == 1)
      fail_usage(
          "--plane: hyperplanes cut through time, which one frame does not have; --roi takes a box of it, "
          "or a plane such as 0-255,0-255,50");
    if (cut.is_time_slice)
      return cut_at_index(volume, frame_index(volume, -(*a.plane)[4] / (*a.plane)[3], true));
    return cut;
  }
  if (!a.time) {
    if (volume_info(volume).dims[3] == 1) return cut_at_index(volume, 0);
    fail_usage("--time T or --plane a,b,c,d,e is missing");
  }
  return cut_at_index(volume, frame_index(volume, *a.time, a.index));
}

} // namespace

void set_shape(Cut& cut, const SliceChoiceArguments& a) {
  if (a.thickness && !(*a.thickness > 0)) fail_usage("--thickness must be positive");
  if (a.slab != BCCSPLAT_SLAB_DEFAULT && !a.thickness) fail_usage("--slab goes with --thickness D");
  if (a.spacing && !(*a.spacing > 0)) fail_usage("--slice-spacing must be positive");
  cut.thickness = a.thickness.value_or(0), cut.spacing = a.spacing.value_or(0);
  if (a.bandwidth) std::copy(a.bandwidth->begin(), a.bandwidth->end(), cut.bandwidth.begin());
  cut.slab = a.slab, cut.method = a.method, cut.lattice = a.lattice, cut.level = a.level.value_or(0);
  cut.motion = a.motion;
  if (a.motion == BCCSPLAT_MOTION_ON && (!cut.is_time_slice || a.region || a.thickness))
    fail_usage("--motion on goes with --time alone: all of a moment, without --roi and --thickness");
  if (a.region && !cut.is_time_slice) fail_usage("--roi goes with --time: a box is a part of a time slice");
  cut.region = a.region;
}

Cut resolve_cut(const Volume& volume, const SliceChoiceArguments& a) {
  Cut cut = resolve_plane(volume, a);
  set_shape(cut, a);
  return cut;
}

Slice cut_slice(const Volume& volume, const Cut& where, uint32_t channel) {
  auto hyperplane = sized<bccsplat_hyperplane>();
  std::array<double, 5> plane{};
  std::copy_n(where.plane, plane.size(), plane.begin());
  if (where.even) plane = even_plane(volume, where.plane);
  hyperplane.a = plane[0], hyperplane.b = plane[1], hyperplane.c = plane[2], hyperplane.d = plane[3];
  hyperplane.e = plane[4];
  auto options = sized<bccsplat_slice_options>();
  options.channel = channel, options.level = where.level;
  options.thickness = where.thickness, options.spacing = where.spacing;
  std::copy(where.bandwidth.begin(), where.bandwidth.end(), options.bandwidth);
  options.slab = where.slab, options.method = where.method, options.lattice = where.lattice;
  options.motion = where.motion;
  if (where.point) options.point = where.point->data(), options.basis = where.basis.data();
  auto box = sample_box(volume, where.region);
  for (uint32_t i = 0; box && where.even && i < box->size(); ++i)
    (*box)[i] = even_position(volume, i % 3, (*box)[i]);
  if (box) options.box = box->data();
  if (where.even) options.space = BCCSPLAT_SPACE_EVEN;
  options.once = where.once ? 1 : 0;
  options.cancel_token = interrupt_token();
  bccsplat_slice* slice = nullptr;
  check(bccsplat_slice_create(volume.get(), where.point ? nullptr : &hyperplane, &options, &slice), "slice");
  Slice made(slice);
  const bccsplat_slice_info info = slice_info(made);
  if (info.dims[0] == 0) {
    std::string normal_form;
    for (const double x : info.hyperplane) normal_form += concat(normal_form.empty() ? "" : ",", x);
    fail_usage("the hyperplane ", normal_form, " misses the data");
  }
  return made;
}

} // namespace bcc4

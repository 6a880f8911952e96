// SPDX-License-Identifier: Apache-2.0
// Which hyperplane, and what the slice holds of it: --time, --index, --plane, --point and --basis,
// --thickness, --roi and so on, for every command that cuts.
#pragma once

#include <array>
#include <optional>

#include "readers/frame_reader.h"
#include "tool/handles.h"
#include "tool/options.h"

namespace bcc4 {

struct SliceChoiceArguments {
  std::optional<double> time;
  bool index = false;
  std::optional<std::vector<double>> plane;        // a, b, c, d, e
  std::optional<std::vector<double>> point, basis; // x, y, z, t and three times as many
  std::optional<double> thickness, spacing;
  std::optional<std::vector<double>> bandwidth; // along x, y, z and t
  std::optional<std::vector<double>> sweep;     // from, to, count (slice_sweep.h)
  int32_t slab = BCCSPLAT_SLAB_DEFAULT;
  int32_t method = BCCSPLAT_METHOD_DEFAULT;
  int32_t lattice = BCCSPLAT_LATTICE_DEFAULT;
  int32_t motion = BCCSPLAT_MOTION_DEFAULT;
  std::optional<SampleBox> region; // of a time slice
  std::optional<uint32_t> level;   // none: all of it, or what a picture needs
};
// --roi X0-X1,Y0-Y1,Z0-Z1: samples of the source grid from 0, both ends included.
void add_region(const Command& command, std::optional<SampleBox>& region, const char* help);
// --motion auto|on|off
void add_motion(const Command& command, int32_t& motion);
void add_slice_choice(const Command& command, SliceChoiceArguments& arguments);

struct Cut {
  double plane[5]{};
  bool is_time_slice = true;
  double index = 0; // of a time slice
  double time = 0;  // of a time slice, in the file's unit
  // A point and the directions of u, v, w, in place of the normal form.
  std::optional<std::array<double, 4>> point;
  std::array<double, 12> basis{};
  double thickness = 0, spacing = 0;
  std::array<double, 4> bandwidth{}; // all 0: none
  int32_t slab = BCCSPLAT_SLAB_DEFAULT;
  int32_t method = BCCSPLAT_METHOD_DEFAULT;
  int32_t lattice = BCCSPLAT_LATTICE_DEFAULT;
  int32_t motion = BCCSPLAT_MOTION_DEFAULT;
  std::optional<SampleBox> region;
  uint32_t level = 0;
  bool even = false; // laid out by even positions, for pictures (bccsplat_slice_options.space)
  bool once = false; // no other moment of the file will be looked at (bccsplat_slice_options.once)

  bool operator==(const Cut&) const = default;
};
// A file of one frame needs neither option. The sweep is not looked at.
[[nodiscard]] Cut resolve_cut(const Volume& volume, const SliceChoiceArguments& arguments);
[[nodiscard]] Cut cut_at_index(const Volume& volume, double index);
// --thickness, --slab, --roi and the --slice- options onto a hyperplane.
void set_shape(Cut& cut, const SliceChoiceArguments& arguments);
// A hyperplane that misses the data is an error here.
[[nodiscard]] Slice cut_slice(const Volume& volume, const Cut& where, uint32_t channel);

} // namespace bcc4

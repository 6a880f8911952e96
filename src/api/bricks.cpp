// SPDX-License-Identifier: Apache-2.0
// A slice as bricks, for hosts that draw by themselves.
#include <algorithm>
#include <vector>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/structs.h"
#include "volume/slice_bricks.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

BrickSettings read_settings(const bccsplat_brick_options* options) {
  const auto in = read_struct(options, "bccsplat_brick_options");
  require_choice(in.grid, BCCSPLAT_BRICK_GRID_SITES, "bccsplat_brick_options.grid");
  require_choice(in.type, BCCSPLAT_TYPE_F32, "bccsplat_brick_options.type");
  require_zero_or(in.edge, 4, 128, "bccsplat_brick_options.edge");
  require_range(in.border, 0, 16, "bccsplat_brick_options.border");
  require_zero(in.reserved, "bccsplat_brick_options.reserved");
  require_zero_or(in.spacing, smallest_length, largest_number, "bccsplat_brick_options.spacing");
  require_numbers(in.range, "bccsplat_brick_options.range", largest_value);
  if (in.range[0] > in.range[1] || (in.range[0] == in.range[1] && in.range[0] != 0))
    fail(Code::invalid_argument, "bccsplat_brick_options.range ends at ", in.range[1],
         ", not above its begin ", in.range[0]);
  BrickSettings out;
  out.sites = in.grid == BCCSPLAT_BRICK_GRID_SITES;
  if (in.type != 0) out.type = static_cast<ValueType>(in.type);
  if (in.edge != 0) out.edge = static_cast<int>(in.edge);
  out.border = static_cast<int>(in.border);
  if (in.spacing != 0) out.spacing = in.spacing;
  out.range = {in.range[0], in.range[1]};
  return out;
}

// A slice's bricks, and how the call that asks is cancelled.
struct AskedBricks {
  BrickSettings settings;
  Progress progress;
  Context context;
  SliceBricks bricks;

  AskedBricks(const bccsplat_slice* slice, const bccsplat_brick_options* options)
      : settings(read_settings(options)), context(watched(slice)), bricks(slice->open, settings, context) {}

 private:
  Context watched(const bccsplat_slice* slice) {
    watch(progress, slice->token);
    progress.throw_if_cancelled();
    return slice->volume->device->context(progress);
  }
};

bccsplat_brick_info info_of(const AskedBricks& asked, const Slice& slice) {
  const BrickGrid& grid = asked.bricks.grid();
  bccsplat_brick_info out{};
  out.cosets = static_cast<uint32_t>(grid.cosets);
  out.edge = static_cast<uint32_t>(grid.whole());
  for (size_t a = 0; a < 3; ++a) {
    out.bricks[a] = static_cast<uint32_t>(grid.bricks[a]), out.dims[a] = static_cast<uint64_t>(grid.dims[a]);
    out.step[a] = grid.step[a];
    for (size_t c = 0; c < 2; ++c) out.origin[c][a] = grid.origin[c][a];
  }
  out.brick_bytes = grid.brick_samples() * value_bytes(asked.settings.type);
  out.scale = grid.scale, out.offset = grid.offset, out.empty = asked.bricks.empty();
  if (!asked.settings.sites) return out;
  const RadialKernel& phi = slice.kernel.space;
  out.kernel_radius = asked.bricks.kernel_radius();
  std::copy_n(phi.a.begin(), phi.terms, out.kernel);
  out.kernel_terms = static_cast<uint32_t>(phi.terms),
  out.kernel_normalised = slice.kernel.normalised ? 1 : 0;
  return out;
}

} // namespace

extern "C" {

bccsplat_status bccsplat_slice_get_brick_info(const bccsplat_slice* slice,
                                              const bccsplat_brick_options* options,
                                              bccsplat_brick_info* info) {
  return guard([&] {
    require(slice, "slice"), require(info, "info");
    check_output(info, "info");
    const AskedBricks asked(slice, options);
    write_struct(info, info_of(asked, slice->open.slice), "info");
  });
}

bccsplat_status bccsplat_slice_find_bricks(const bccsplat_slice* slice, const bccsplat_brick_options* options,
                                           uint32_t* index, float* bounds, uint64_t* count) {
  return guard([&] {
    require(slice, "slice");
    const AskedBricks asked(slice, options);
    const std::vector<ValueBounds> of = asked.bricks.bounds(asked.context);
    const ValueBounds nothing{asked.bricks.empty(), asked.bricks.empty()};
    uint32_t found = 0;
    for (size_t n = 0; n < of.size(); ++n) {
      const uint32_t number = of[n] == nothing ? 0 : ++found;
      if (index) index[n] = number;
      if (bounds) bounds[2 * n] = of[n][0], bounds[2 * n + 1] = of[n][1];
    }
    if (count) *count = found;
  });
}

bccsplat_status bccsplat_slice_get_bricks(const bccsplat_slice* slice, const bccsplat_brick_options* options,
                                          uint64_t count, const uint32_t* cells, void* values,
                                          float* ranges) {
  return guard([&] {
    require(slice, "slice");
    const AskedBricks asked(slice, options);
    if (count == 0) return;
    require(cells, "cells"), require(values, "values");
    require_count(count, asked.bricks.grid().brick_samples() * value_bytes(asked.settings.type), "count");
    const std::span wanted(cells, count);
    for (const uint32_t cell : wanted)
      if (cell >= asked.bricks.grid().cells())
        fail(Code::invalid_argument, "cells: there is no brick ", cell, "; there are ",
             asked.bricks.grid().cells());
    std::vector<ValueBounds> found(ranges ? count : 0);
    asked.bricks.fill(wanted, values, ranges ? found.data() : nullptr, asked.context);
    for (size_t n = 0; n < found.size(); ++n) ranges[2 * n] = found[n][0], ranges[2 * n + 1] = found[n][1];
  });
}

} // extern "C"

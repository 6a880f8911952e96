// SPDX-License-Identifier: Apache-2.0
// Lays bricks over a slice and fills them.
#include "volume/slice_bricks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/half.h"
#include "field/footprint/patch.h"
#include "volume/site_boxes.h"

namespace bccsplat {
namespace {

constexpr double most_samples = 1 << 20; // along an axis
constexpr uint64_t most_cells = INT32_MAX;

int bricks_of(int samples, int edge) { return (samples + edge - 1) / edge; }

double largest_code(ValueType type) { return type == ValueType::u8 ? 255 : 65535; }

// Turns values into what is stored.
struct Codes {
  ValueType type;
  double scale, offset;
  float empty;

  void write(std::span<const float> from, void* to) const {
    switch (type) {
    case ValueType::u8:
      return write_codes(from, static_cast<uint8_t*>(to));
    case ValueType::u16:
      return write_codes(from, static_cast<uint16_t*>(to));
    case ValueType::f16:
      std::transform(from.begin(), from.end(), static_cast<uint16_t*>(to), float_to_half);
      return;
    default:
      std::memcpy(to, from.data(), from.size_bytes());
    }
  }

 private:
  template<class Code> void write_codes(std::span<const float> from, Code* to) const {
    const double per_value = scale > 0 ? 1 / scale : 0;
    for (const float v : from) {
      const double code = ((std::isnan(v) ? empty : v) - offset) * per_value;
      *to++ = static_cast<Code>(std::lround(std::clamp(code, 0.0, largest_code(type))));
    }
  }
};

} // namespace

SliceBricks::SliceBricks(const OpenSlice& slice, const BrickSettings& settings, const Context& context)
    : slice_(slice), settings_(settings) {
  grid_.edge = settings.edge, grid_.border = settings.border;
  if (settings.sites && (slice.extraction || slice.slice.labels))
    fail(Code::unsupported, "bricks: the values of ", slice.extraction ? "extracted points" : "labels",
         " are no sums over sites: ask for samples");
  if (slice.slice.empty()) return;
  if (!slice.extraction) slice.slice.coset.make(context);
  settings.sites ? lay_out_sites() : lay_out_samples();
  for (size_t a = 0; a < 3; ++a) grid_.bricks[a] = bricks_of(grid_.dims[a], grid_.edge);
  if (grid_.cells() > most_cells) fail(Code::limit_exceeded, "bricks: there would be ", grid_.cells());
  set_codes(context);
}

void SliceBricks::lay_out_samples() {
  const auto extent = slice_.extent();
  for (size_t a = 0; a < 3; ++a) {
    const double length = extent[a][1] - extent[a][0];
    const double steps = std::ceil(length / settings_.spacing - 1e-9);
    if (!(steps < most_samples))
      fail(Code::limit_exceeded, "bricks: there would be ", steps + 1, " samples along an axis");
    grid_.dims[a] = static_cast<int32_t>(steps) + 1;
    grid_.origin[0][a] = extent[a][0];
    grid_.step[a] = steps > 0 ? length / steps : settings_.spacing;
  }
}

void SliceBricks::lay_out_sites() {
  const Slice& s = slice_.slice;
  grid_.cosets = s.lattice.cosets(), grid_.dims = s.lattice.dims(0);
  for (int c = 0; c < grid_.cosets; ++c)
    grid_.origin[static_cast<size_t>(c)] = s.lattice_to_slice.point(s.site(c, {0, 0, 0}));
  for (size_t a = 0; a < 3; ++a) grid_.step[a] = s.lattice_to_slice.linear[a][a] * coset_pitch(s.lattice);
}

double SliceBricks::kernel_radius() const {
  return slice_.slice.kernel.space.radius / coset_pitch(slice_.slice.lattice);
}

void SliceBricks::set_codes(const Context& context) {
  if (is_float(settings_.type)) return;
  Range range = settings_.range;
  if (range == Range{}) {
    range = {empty(), empty()};
    if (settings_.sites) {
      for (const auto& [low, high] : bounds(context))
        range = {std::min<double>(range.low, low), std::max<double>(range.high, high)};
    } else {
      range = {slice_.bounds()[0], slice_.bounds()[1]};
    }
  }
  grid_.offset = range.low, grid_.scale = (range.high - range.low) / largest_code(settings_.type);
}

std::array<Int3, 2> SliceBricks::samples_of(uint64_t cell) const {
  std::array<Int3, 2> samples;
  for (size_t a = 0; a < 3; ++a) {
    const auto at = static_cast<int32_t>(cell % static_cast<uint64_t>(grid_.bricks[a]));
    cell /= static_cast<uint64_t>(grid_.bricks[a]);
    samples[0][a] = at * grid_.edge - grid_.border;
    samples[1][a] = (at + 1) * grid_.edge - 1 + grid_.border;
    if (settings_.sites) continue; // these go on beyond their ends, as the field does
    samples[0][a] = std::max(samples[0][a], 0), samples[1][a] = std::min(samples[1][a], grid_.dims[a] - 1);
  }
  return samples;
}

std::array<Vec3, 2> SliceBricks::box_of(const std::array<Int3, 2>& samples) const {
  std::array<Vec3, 2> box;
  for (size_t side = 0; side < 2; ++side)
    for (size_t a = 0; a < 3; ++a) box[side][a] = grid_.origin[0][a] + grid_.step[a] * samples[side][a];
  return box;
}

ValueBounds SliceBricks::bounds_of(uint64_t cell, std::vector<float>& scratch) const {
  const std::array<Int3, 2> samples = samples_of(cell);
  if (!settings_.sites) return value_bounds(slice_, box_of(samples), scratch);
  const size_t coset = cell * static_cast<uint64_t>(grid_.cosets) / grid_.cells();
  const ValueBounds range = coefficient_range(slice_.slice.coset[coset], samples, scratch);
  return {slice_.slice.base + range[0], slice_.slice.base + range[1]};
}

std::vector<ValueBounds> SliceBricks::bounds(const Context& context) const {
  std::vector<ValueBounds> bounds(grid_.cells());
  context.tasks.parallel_for(bounds.size(), [&](uint64_t cell) {
    context.progress.check();
    std::vector<float> scratch;
    bounds[cell] = bounds_of(cell, scratch);
  });
  return bounds;
}

void SliceBricks::read(uint64_t cell, float* values, std::vector<float>& scratch,
                       const Context& context) const {
  const std::array<Int3, 2> samples = samples_of(cell);
  Int3 size;
  for (size_t a = 0; a < 3; ++a) size[a] = samples[1][a] - samples[0][a] + 1;
  if (settings_.sites) {
    const size_t coset = cell * static_cast<uint64_t>(grid_.cosets) / grid_.cells();
    gather_sites(slice_.slice.coset[coset], {samples[0], size}, values, scratch);
    for (uint64_t i = 0; i < grid_.brick_samples(); ++i) values[i] += slice_.slice.base;
    return;
  }
  scratch.resize(static_cast<size_t>(size[0]) * size[1] * size[2]);
  slice_.sample({box_of(samples)[0], grid_.step, size}, scratch.data(), context);
  // What lies beyond the samples is as the last of them.
  std::array<std::vector<size_t>, 3> from;
  uint64_t rest = cell;
  for (size_t a = 0; a < 3; ++a) {
    const auto at = static_cast<int32_t>(rest % static_cast<uint64_t>(grid_.bricks[a]));
    rest /= static_cast<uint64_t>(grid_.bricks[a]);
    for (int i = 0; i < grid_.whole(); ++i)
      from[a].push_back(static_cast<size_t>(
          std::clamp(at * grid_.edge - grid_.border + i, samples[0][a], samples[1][a]) - samples[0][a]));
  }
  const size_t nx = static_cast<size_t>(size[0]), ny = static_cast<size_t>(size[1]);
  for (const size_t z : from[2])
    for (const size_t y : from[1])
      for (const size_t x : from[0]) *values++ = scratch[(z * ny + y) * nx + x];
}

void SliceBricks::fill(std::span<const uint32_t> cells, void* values, ValueBounds* ranges,
                       const Context& context) const {
  const uint64_t samples = grid_.brick_samples();
  const Codes codes{settings_.type, grid_.scale, grid_.offset, empty()};
  auto* const bytes = static_cast<std::byte*>(values);
  context.tasks.parallel_for(cells.size(), [&](uint64_t n) {
    context.progress.check();
    std::vector<float> brick(samples), scratch;
    read(cells[n], brick.data(), scratch, context);
    codes.write(brick, bytes + n * samples * value_bytes(settings_.type));
    if (!ranges) return;
    ValueBounds range{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN()};
    for (const float v : brick)
      if (!std::isnan(v)) range = {std::fmin(range[0], v), std::fmax(range[1], v)};
    ranges[n] = range;
  });
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Copies rows of bricks, and mends them as slices are: with the file's masks, and then its corrections.
#include "volume/frame_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/would_block.h"
#include "kernel/cc_kernel.h"
#include "volume/labels.h"
#include "volume/open_slice.h"
#include "volume/value_counts.h"

namespace bccsplat {
namespace {

constexpr float no_value = std::numeric_limits<float>::quiet_NaN();

// A box of one frame, as it is filled.
class Box {
 public:
  Box(const SampleBox& box, float* values) : box_(box), values_(values) {
    for (size_t a = 0; a < 3; ++a) size_[a] = box.end[a] - box.begin[a];
  }
  [[nodiscard]] size_t rows() const { return static_cast<size_t>(size_[1]) * size_[2]; }
  [[nodiscard]] int width() const { return size_[0]; }
  // The first sample of a row.
  [[nodiscard]] Int3 sample(size_t row) const {
    return {box_.begin[0], box_.begin[1] + static_cast<int>(row % size_[1]),
            box_.begin[2] + static_cast<int>(row / size_[1])};
  }
  [[nodiscard]] float* row(size_t row) const { return values_ + row * size_[0]; }
  // Null outside the box.
  [[nodiscard]] float* at(const Int3& sample) const {
    size_t place = 0;
    for (size_t a = 3; a-- > 0;) {
      if (sample[a] < box_.begin[a] || sample[a] >= box_.end[a]) return nullptr;
      place = place * size_[a] + (sample[a] - box_.begin[a]);
    }
    return values_ + place;
  }

 private:
  SampleBox box_;
  Int3 size_{};
  float* values_;
};

// Copies a row of sites of a layer, beginning at `site`; those in holes are missing.
void copy_row(const BrickLayer& layer, const Int3& site, int width, float base, bool whole, float* to) {
  for (int x = 0; x < width;) {
    const int at = site[0] + x, first = at % brick_edge, count = std::min(brick_edge - first, width - x);
    const Brick* const brick = layer.brick(at / brick_edge, site[1] / brick_edge, site[2] / brick_edge);
    if (!brick) {
      std::fill_n(to + x, count, base);
    } else {
      const int row = site[2] % brick_edge * brick_edge + site[1] % brick_edge;
      const float* const from = brick->value.data() + row * brick_edge + first;
      for (int i = 0; i < count; ++i) to[x + i] = base + from[i];
      for (int i = 0; whole && i < count; ++i) to[x + i] = std::round(to[x + i]);
      for (int i = 0; brick->hole && i < count; ++i)
        if (brick->is_hole(row * brick_edge + first + i)) to[x + i] = no_value;
    }
    x += count;
  }
}

// Hides what the file's masks say is missing of a frame.
void hide_masked(const FrameMask& mask, const Box& box, const Context& context) {
  context.tasks.parallel_for(box.rows(), [&](uint64_t r) {
    Int3 at = box.sample(r);
    float* const row = box.row(r);
    for (int x = 0; x < box.width(); ++x, ++at[0])
      if (mask.at({at[0], at[1], at[2]})) row[x] = no_value;
  });
}

void read_samples(const OpenVolume& volume, uint32_t channel, int64_t frame, const SampleBox& samples,
                  float* values, const Context& context) {
  const Lattice4& lattice = volume.lattice(0);
  const SampleSource& source = volume.samples(0);
  const int number = static_cast<int>(channel);
  BrickBox bricks;
  for (size_t a = 0; a < 3; ++a) {
    bricks.begin[a] = (lattice.before[a] + samples.begin[a]) / brick_edge;
    bricks.end[a] = (lattice.before[a] + samples.end[a] - 1) / brick_edge + 1;
  }
  const int32_t layer = lattice.is_static() ? 0 : lattice.lead + static_cast<int32_t>(frame);
  Attempts attempts;
  BrickLayer read;
  FrameMaskPtr mask;
  attempts.attempt([&] { read = source.read_layer(number, layer, bricks, context); });
  if (const Masks* const masks = volume.masks(channel)) attempts.attempt([&] { mask = masks->frame(frame); });
  const Reservation memory(context.memory, read.bytes(), "samples of a frame");
  const Box box(samples, values);
  const float base = source.base(number);
  const bool labels = is_labels(volume, channel), whole = labels && value_counts(volume, channel).integers;
  // Corrections of the kernel that is looked through; labels stand in the place of the field.
  const Corrections* const corrections =
      labels ? nullptr : volume.coefficients(channel, nullptr).corrections();
  if (!attempts.waits()) {
    context.tasks.parallel_for(box.rows(), [&](uint64_t r) {
      context.progress.check();
      Int3 site = box.sample(r);
      for (size_t a = 0; a < 3; ++a) site[a] += lattice.before[a];
      copy_row(read, site, box.width(), base, whole, box.row(r));
    });
    if (mask) hide_masked(*mask, box, context);
  }
  if (corrections) {
    attempts.attempt([&] {
      const auto add = [&](const Int3& at, float value) {
        if (float* const found = box.at(at); found && !std::isnan(*found)) *found += value;
      };
      corrections->each(frame, add, {samples.begin, samples.end});
    });
    attempts.attempt([&] {
      corrections->each_set(frame, [&](const Int3& at, float value) {
        if (float* const found = box.at(at); found && std::isnan(*found)) *found = value;
      });
    });
  }
  attempts.throw_if_waiting();
}

void sample_slice(const OpenVolume& volume, uint32_t channel, int64_t frame, const SampleBox& box,
                  float* values, const Context& context) {
  HypersliceOptions cut;
  Grid grid;
  IndexBox part;
  bool all = true;
  for (size_t a = 0; a < 3; ++a) {
    part.begin[a] = grid.origin[a] = box.begin[a], part.end[a] = box.end[a] - 1;
    grid.step[a] = 1, grid.dims[a] = box.end[a] - box.begin[a];
    all = all && grid.dims[a] == static_cast<int64_t>(volume.lattice(0).dims[a]);
  }
  if (!all) cut.box = part;
  const Hyperplane plane{0, 0, 0, 1, -static_cast<double>(frame)};
  const OpenSlice slice = cut_slice(volume, request_slice(volume, channel, nullptr, 0, plane, cut), context);
  slice.sample(grid, values, context);
}

} // namespace

void read_frame(const OpenVolume& volume, uint32_t channel, int64_t frame, const SampleBox& box,
                float* values, const Context& context) {
  if (goes_through_samples(volume.lattice(0), volume.kernel()) || is_labels(volume, channel))
    read_samples(volume, channel, frame, box, values, context);
  else
    sample_slice(volume, channel, frame, box, values, context);
}

} // namespace bccsplat

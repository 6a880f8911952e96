// SPDX-License-Identifier: Apache-2.0
// Looks at the coarsest level of a frame to choose boxes, and makes the slices of both levels in each of
// these alone. The source itself is not there; what level 0 loses of it is small beside what coarser levels
// lose.
#include "store/compared_levels.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "field/coefficients/coefficients.h"
#include "field/sample_grid.h"
#include "slice/part.h"
#include "slice/time_slice.h"
#include "store/channel_info.h"
#include "store/joined_samples.h"
#include "store/measured_boxes.h"
#include "store/measuring.h"
#include "store/sample_comparison.h"

namespace bccsplat {
namespace {

// Boxes as wide as a brick of the coarsest level are many bricks of level 0.
MeasuredCells cells_of(int level) {
  MeasuredCells cells;
  cells.bricks = level == 1 ? 2 : 1;
  cells.fewest = 2, cells.least_edge = 1, cells.planes_apart = 1;
  return cells;
}

// A frame as its coarsest level has it.
struct Overview {
  std::array<uint32_t, 3> dims{};
  std::vector<float> values;
};

class LevelComparison {
 public:
  LevelComparison(const SeriesParts& parts, const VolumeInfo& info, const Context& context)
      : info_(info), context_(context) {
    const uint64_t cache = context.memory.limit() / 8 / info.level_count();
    for (int l = 0; l < info.level_count(); ++l)
      levels_.push_back(std::make_unique<JoinedSamples>(parts, l, context.memory, cache));
  }

  // Returns the errors of a level of a channel in these frames.
  [[nodiscard]] SampleErrors compare(int channel, int level, std::span<const uint32_t> frames) const {
    SampleErrors sum;
    for (const uint32_t frame : frames) sum.add(compare_frame(channel, level, frame));
    return sum;
  }

 private:
  [[nodiscard]] Coefficients field(int channel, int level, const BrickBox& bricks) const {
    return {*levels_[level],
            channel,
            make_kernel(info_.recommended_kernel),
            info_.channels[channel].threshold / 2,
            context_.memory.limit() / 8,
            bricks};
  }

  [[nodiscard]] Overview look_at(int channel, uint32_t frame) const {
    const int coarsest = info_.level_count() - 1;
    const Coefficients all = field(channel, coarsest, {});
    const Slice slice = time_slice(all, frame, {0, 0}, {}, context_);
    Overview seen;
    Grid grid;
    for (size_t a = 0; a < 3; ++a) {
      const uint32_t n = info_.lattice.dims[a];
      seen.dims[a] = std::max(1u, (n - 1) >> coarsest) + (n > 1 ? 1 : 0);
      grid.dims[a] = static_cast<int32_t>(seen.dims[a]);
      grid.step[a] = n > 1 ? (n - 1.0) / (seen.dims[a] - 1.0) : 1;
    }
    seen.values.resize(static_cast<size_t>(seen.dims[0]) * seen.dims[1] * seen.dims[2]);
    sample_grid(slice, grid, seen.values.data(), context_);
    return seen;
  }

  [[nodiscard]] SampleErrors compare_frame(int channel, int level, uint32_t frame) const {
    const Overview seen = look_at(channel, frame);
    FrameBox whole;
    whole.data = seen.values.data();
    whole.dims = {seen.dims[0], seen.dims[1], seen.dims[2]};
    const Lattice4 over = lattice_over({seen.dims[0], seen.dims[1], seen.dims[2]}, levels_[level]->lattice());
    BoxErrors sum;
    for (const MeasuredBox& box : choose_measured_boxes(over, frame, {&whole, 1}, info_.channels[channel].air,
                                                        nullptr, cells_of(level)))
      sum.add(compare_box(channel, level, frame, box.bricks), box.weight);
    return sum.of_frame();
  }

  [[nodiscard]] SampleErrors compare_box(int channel, int level, uint32_t frame,
                                         const BrickBox& bricks) const {
    const Region samples = samples_inside(levels_[level]->lattice(), bricks);
    IndexBox around;
    for (size_t a = 0; a < 3; ++a) {
      around.begin[a] = static_cast<double>(samples.begin[a]);
      around.end[a] = static_cast<double>(samples.end[a] - 1);
    }
    // Samples between those of the level, in all places relative to them.
    const HeldGrid held = held_grid(samples, (1 << level) + 1);
    const Coefficients fine = field(channel, 0, bricks_around(around, info_.lattice, BeyondBox::field)),
                       coarse = field(channel, level, bricks);
    const Slice slice = time_slice(fine, frame, {0, 0}, {}, context_);
    const std::vector<float> values = values_at(slice, held);
    const int64_t plane = held.dims[0] * held.dims[1];
    const auto read = [&](int64_t z, double* to) { std::copy_n(values.begin() + z * plane, plane, to); };
    const ChannelInfo& c = info_.channels[channel];
    FrameResiduals none;
    return compare_samples(time_slice(coarse, frame, {0, 0}, {}, context_),
                           {.name = c.name, .air = c.air, .threshold = c.threshold}, {read, held, frame, 0},
                           none, context_);
  }

  [[nodiscard]] std::vector<float> values_at(const Slice& slice, const HeldGrid& held) const {
    Grid grid;
    for (size_t a = 0; a < 3; ++a) {
      grid.origin[a] = static_cast<double>(held.begin[a] * held.every);
      grid.step[a] = static_cast<double>(held.every);
      grid.dims[a] = static_cast<int32_t>(held.dims[a]);
    }
    std::vector<float> values(held.dims[0] * held.dims[1] * held.dims[2]);
    sample_grid(slice, grid, values.data(), context_);
    return values;
  }

  const VolumeInfo& info_;
  const Context& context_;
  std::vector<std::unique_ptr<JoinedSamples>> levels_;
};

} // namespace

void compare_levels(const SeriesParts& parts, std::span<const FitChannelReport> fits, VolumeInfo& info,
                    const Context& context) {
  const auto of_level = [](const MeasuredError& e) { return e.level > 0; };
  if (info.levels.empty() || std::any_of(info.errors.begin(), info.errors.end(), of_level)) return;
  const LevelComparison levels(parts, info, context);
  const std::vector<uint32_t> frames = some_frames(0, info.lattice.dims[3]);
  std::vector<MeasuredError> errors;
  for (size_t c = 0; c < info.channels.size(); ++c)
    for (int l = 1; l < info.level_count(); ++l)
      add_measured_level(levels.compare(static_cast<int>(c), l, frames), fits[c].source_range, c, l,
                         frames.size(), errors);
  info.errors.insert(info.errors.end(), errors.begin(), errors.end());
  sort_errors(info.errors);
}

} // namespace bccsplat

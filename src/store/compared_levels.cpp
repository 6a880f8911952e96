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
#include "formats/bcc4/sample_step.h"
#include "slice/part.h"
#include "slice/time_slice.h"
#include "store/channel_info.h"
#include "store/joined_samples.h"
#include "store/measured_boxes.h"
#include "store/measuring.h"
#include "store/sample_comparison.h"

namespace bccsplat {
namespace {

// What a box of level 0, and what is kept beside it, may take.
constexpr int64_t widest_box = 96; // samples
constexpr uint64_t most_cache = 64 << 20;

// A brick of a coarse level is many of level 0.
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
  LevelComparison(const SeriesParts& parts, std::span<const FitChannelReport> fits, const VolumeInfo& info,
                  const Context& context)
      : info_(info), fits_(fits), context_(context) {
    for (int l = 0; l < info.level_count(); ++l)
      levels_.push_back(std::make_unique<JoinedSamples>(parts, l, context.memory, cache_bytes()));
  }

  // Returns the errors of a level of a channel in these frames: what it differs from level 0, whose own
  // rounding is no error of the level.
  [[nodiscard]] SampleErrors compare(int channel, int level, std::span<const uint32_t> frames) const {
    SampleErrors sum;
    for (const uint32_t frame : frames) sum.add(compare_frame(channel, level, frame));
    const double rounding = rounding_of(channel) * static_cast<double>(sum.bare.count);
    const double squares = std::max(0.0, sum.bare.squares.value() - rounding);
    sum.bare.squares = {};
    sum.bare.squares.add(squares);
    return sum;
  }

 private:
  [[nodiscard]] Coefficients field(int channel, int level, const BrickBox& bricks) const {
    return {*levels_[level],
            channel,
            make_kernel(info_.recommended_kernel),
            info_.channels[channel].threshold / 2,
            cache_bytes(),
            bricks};
  }

  // The mean square over all sites of what rounding to steps makes of those that are kept.
  [[nodiscard]] double rounding_of(int channel) const {
    const double step = sample_step(info_.channels[channel]);
    const auto kept = static_cast<double>(fits_[channel].sites_kept);
    return step * step / 12 * kept / static_cast<double>(info_.lattice.sites());
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
    Region samples = samples_inside(levels_[level]->lattice(), bricks);
    IndexBox around;
    for (size_t a = 0; a < 3; ++a) {
      samples.begin[a] += std::max<int64_t>(0, samples.length(a) - widest_box) / 2;
      samples.end[a] = std::min(samples.end[a], samples.begin[a] + widest_box);
      around.begin[a] = static_cast<double>(samples.begin[a]);
      around.end[a] = static_cast<double>(samples.end[a] - 1);
    }
    // Samples in all places relative to those of the level.
    const HeldGrid held = held_grid(samples, level == 1 ? 3 : 5);
    const int reach = sites_in_reach(info_.lattice, make_kernel(info_.recommended_kernel));
    const Coefficients fine = field(channel, 0, bricks_around(around, info_.lattice, reach)),
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

  [[nodiscard]] uint64_t cache_bytes() const { return std::min(context_.memory.limit() / 16, most_cache); }

  const VolumeInfo& info_;
  std::span<const FitChannelReport> fits_;
  const Context& context_;
  std::vector<std::unique_ptr<JoinedSamples>> levels_;
};

} // namespace

void compare_levels(const SeriesParts& parts, std::span<const FitChannelReport> fits, VolumeInfo& info,
                    const Context& context) {
  const auto of_level = [](const MeasuredError& e) { return e.level > 0; };
  if (info.levels.empty() || std::any_of(info.errors.begin(), info.errors.end(), of_level)) return;
  const LevelComparison levels(parts, fits, info, context);
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

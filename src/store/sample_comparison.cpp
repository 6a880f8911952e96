// SPDX-License-Identifier: Apache-2.0
// Samples the slice some planes at a time and compares plane by plane; where a bound is missed it counts the
// steps of a correction.
#include "store/sample_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "field/sample_grid.h"

namespace bccsplat {
namespace {

constexpr int64_t samples_at_a_time = 1 << 22;
// Other ways to the same sample (evaluate at a point) round differently by a few units in the last place.
constexpr double rounding = 0x1p-21;

// What one plane of a frame adds.
struct PlaneErrors {
  SampleErrors errors;
  FrameResiduals residuals;
};

struct PlaneJob {
  const RoundTripChannel& channel;
  const ComparedPart& source;
  std::array<int64_t, 3> n; // of its grid
  uint32_t frame;

  void compare(int64_t z, const float* got, PlaneErrors& out) const;

 private:
  // Sample i of plane z, in the frame.
  [[nodiscard]] std::array<uint64_t, 3> place(int64_t z, int64_t i) const {
    return source.grid.sample({i % n[0], i / n[0], z});
  }
  [[nodiscard]] uint64_t voxel(int64_t z, int64_t i) const {
    const std::array<uint64_t, 3> at = place(z, i);
    return (at[2] * source.dims[1] + at[1]) * source.dims[0] + at[0];
  }
  // The largest magnitude of all that is compared: what its floats hold, those of lesser values hold, too.
  [[nodiscard]] double largest() const {
    double most = 0;
    std::vector<double> plane(static_cast<size_t>(n[0] * n[1]));
    for (int64_t z = 0; z < n[2]; ++z) {
      source.plane(z, plane.data());
      for (const double v : plane)
        if (std::isfinite(v)) most = std::max(most, std::fabs(v));
    }
    return most;
  }
  [[noreturn]] void refuse(int64_t z, int64_t i, double expected, double reached) const {
    const std::array<uint64_t, 3> at = place(z, i);
    const double most = largest(), least = 2 * (most * rounding + source.doubt);
    fail(Code::bound_not_met, "channel '", channel.name, "', frame ", frame, ", voxel (", at[0], ", ", at[1],
         ", ", at[2], "): the source has ", expected, ", the file would give ", reached,
         ", more than the bound of ", channel.bound,
         " away even with a correction: values are read as 32-bit floats, ",
         source.doubt > 0 ? "and made of rounded samples, " : "", "which hold errors down to about ", least,
         " where the largest is ", most, "; accept that much");
  }
};

// Differences of samples, summed some at a time.
class DifferenceSum {
 public:
  void add(double magnitude) {
    sum_.largest = std::max(sum_.largest, magnitude);
    squares_[count_++] = magnitude * magnitude;
    if (count_ == squares_.size()) sum_up();
  }
  [[nodiscard]] const ErrorSum& sum() {
    sum_up();
    return sum_;
  }

 private:
  void sum_up() {
    sum_.squares.add(std::span(squares_).first(count_));
    sum_.count += std::exchange(count_, 0);
  }
  ErrorSum sum_;
  size_t count_ = 0;
  std::array<double, ExactSum::most_at_once> squares_;
};

void PlaneJob::compare(int64_t z, const float* got, PlaneErrors& out) const {
  std::vector<double> expected(static_cast<size_t>(n[0] * n[1]));
  source.plane(z, expected.data());
  const double bound = channel.bound, step = correction_step(bound);
  const double air = static_cast<float>(channel.air);
  // Where half the bound suffices, the other half has room for rounding of all but enormous values.
  const double surely = bound > 0 ? bound / 2 : std::numeric_limits<double>::max();
  const double enormous =
      bound > 0 ? (bound / 2 - source.doubt) / rounding : std::numeric_limits<double>::infinity();
  const bool usual = std::fabs(air) < enormous;
  SampleErrors& e = out.errors;
  DifferenceSum near_air, far; // of samples without a correction
  double largest = -1;
  for (int64_t i = 0; i < n[0] * n[1]; ++i) {
    const double want = expected[i];
    float value = got[i];
    const bool is_far = std::fabs(want - channel.air) > channel.threshold;
    const double bare = std::fabs(value - want);
    if (usual && bare <= surely && std::fabs(want) + bare < enormous && bare <= largest) {
      (is_far ? far : near_air).add(bare);
      continue;
    }
    if (!std::isfinite(want)) continue;
    const bool lost = std::isnan(value);
    if (lost && bound == 0) {
      ++e.lost;
      continue;
    }
    const double from = lost ? air : static_cast<double>(value), off = want - from;
    const double margin =
        rounding * std::max({std::fabs(want), std::fabs(from), std::fabs(air)}) + source.doubt;
    if (bound > 0 && (lost || (off != 0 && !(std::fabs(off) <= bound - margin)))) {
      const double steps = std::nearbyint(off / step);
      if (!(std::fabs(steps) < 0x1p53)) refuse(z, i, want, from);
      // The reader computes it in the same way.
      value = static_cast<float>(from) + static_cast<float>(steps * step);
      if (!(std::fabs(value - want) <= bound - source.doubt)) refuse(z, i, want, value);
      (lost ? out.residuals.set : out.residuals.add).push_back({voxel(z, i), static_cast<int64_t>(steps)});
      ++e.corrected;
      if (!lost) e.bare.add(off);
      e.all.add(value - want);
      if (is_far) e.non_air.add(value - want);
    } else {
      (is_far ? far : near_air).add(std::fabs(off));
    }
    if (const double difference = std::fabs(value - want); difference > largest) {
      largest = difference;
      e.frame = frame;
      e.voxel = place(z, i);
      e.expected = want, e.got = value;
    }
  }
  for (DifferenceSum* const sum : {&near_air, &far}) e.all.add(sum->sum()), e.bare.add(sum->sum());
  e.non_air.add(far.sum());
}

// Appends the lists of planes, the first of so many that are left of a frame; room is made for all of them as
// if the others had as many corrections, so that what is there moves once or not at all.
void append(std::span<const PlaneErrors> planes, ResidualList FrameResiduals::*list, int64_t left,
            FrameResiduals& to, Progress& progress) {
  size_t count = 0;
  for (const PlaneErrors& p : planes) count += (p.residuals.*list).size();
  ResidualList& all = to.*list;
  if (all.size() + count > all.capacity()) all.reserve(all.size() + count * left / planes.size() + count);
  for (const PlaneErrors& p : planes) {
    progress.check();
    const ResidualList& plane = p.residuals.*list;
    all.insert(all.end(), plane.begin(), plane.end());
  }
}

} // namespace

SampleErrors compare_samples(const Slice& slice, const RoundTripChannel& channel, const ComparedPart& part,
                             FrameResiduals& residuals, const Context& context) {
  const HeldGrid& held = part.grid;
  const auto read = [&](int64_t z, int64_t count, float* to) {
    Grid grid;
    for (size_t a = 0; a < 3; ++a) grid.origin[a] = static_cast<double>(held.begin[a] * held.every);
    grid.origin[2] += static_cast<double>(z * held.every);
    grid.step.fill(static_cast<double>(held.every));
    grid.dims = {static_cast<int32_t>(held.dims[0]), static_cast<int32_t>(held.dims[1]),
                 static_cast<int32_t>(count)};
    sample_grid(slice, grid, to, context);
  };
  return compare_samples(read, channel, part, residuals, context);
}

SampleErrors compare_samples(const ReadPlanes& read, const RoundTripChannel& channel,
                             const ComparedPart& part, FrameResiduals& residuals, const Context& context) {
  const std::array<int64_t, 3>& n = part.grid.dims;
  const PlaneJob job{channel, part, n, part.frame};
  const int64_t plane = n[0] * n[1], planes = std::clamp<int64_t>(samples_at_a_time / plane, 1, n[2]);
  const Reservation memory(context.memory, (planes * plane) * sizeof(float),
                           "samples of a frame to measure the error");
  std::vector<float> values(static_cast<size_t>(planes * plane));
  SampleErrors errors;
  for (int64_t z = 0; z < n[2]; z += planes) {
    const int64_t count = std::min(planes, n[2] - z);
    read(z, count, values.data());
    std::vector<PlaneErrors> parts(static_cast<size_t>(count));
    context.tasks.parallel_for(parts.size(), [&](uint64_t p) {
      context.progress.check();
      job.compare(z + static_cast<int64_t>(p), values.data() + static_cast<int64_t>(p) * plane, parts[p]);
    });
    for (const PlaneErrors& p : parts) errors.add(p.errors); // in order: the same sums for any thread count
    append(parts, &FrameResiduals::add, n[2] - z, residuals, context.progress);
    append(parts, &FrameResiduals::set, n[2] - z, residuals, context.progress);
  }
  return errors;
}

} // namespace bccsplat

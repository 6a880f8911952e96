// SPDX-License-Identifier: Apache-2.0
// Reads a frame after the other, of each no more bricks than the samples lie in.
#include "volume/label_samples.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "volume/value_counts.h"

namespace bccsplat {
namespace {

constexpr size_t planes_at_once = 4 * brick_edge; // of a slice, so that little of a frame is held

struct SampleRange {
  Vec4 low, high;
  void add(const Vec4& sample) {
    for (size_t a = 0; a < 4; ++a)
      low[a] = std::min(low[a], sample[a]), high[a] = std::max(high[a], sample[a]);
  }
};

// The labels of a frame at samples within a range.
class FrameLabels {
 public:
  FrameLabels(const OpenVolume& volume, uint32_t channel, double frame, const SampleRange& range,
              const Context& context)
      : lattice_(volume.lattice(0)), whole_(value_counts(volume, channel).integers) {
    const SampleSource& source = volume.samples(0);
    const int number = static_cast<int>(channel);
    BrickBox bricks;
    for (size_t a = 0; a < 3; ++a) {
      if (lattice_.turns(a)) continue;
      bricks.begin[a] = site(a, range.low[a]) / brick_edge;
      bricks.end[a] = site(a, range.high[a]) / brick_edge + 1;
    }
    const auto layer = static_cast<int32_t>(
        lattice_.is_static() ? 0 : lattice_.lead + lattice_.turned_frame(std::lround(frame)));
    layer_ = source.read_layer(number, layer, bricks, context);
    memory_ = Reservation(context.memory, layer_.bytes(), "a frame of labels");
    base_ = source.base(number);
  }
  // Labels of integers are whole, in whatever steps they are stored.
  [[nodiscard]] float at(const Vec4& sample) const {
    const float value = base_ + layer_.value(site(0, sample[0]), site(1, sample[1]), site(2, sample[2]));
    return whole_ ? std::round(value) : value;
  }

 private:
  // A grid may go on beyond the ends, where nothing is shown.
  [[nodiscard]] int32_t site(size_t axis, double sample) const {
    const int64_t last = lattice_.dims[axis] - 1, turned = lattice_.turned_sample(axis, std::lround(sample));
    return lattice_.before[axis] + static_cast<int32_t>(std::clamp<int64_t>(turned, 0, last));
  }

  const Lattice4& lattice_;
  bool whole_;
  BrickLayer layer_;
  Reservation memory_;
  float base_ = 0;
};

} // namespace

void read_labels(const OpenVolume& volume, uint32_t channel, std::span<const Vec4> samples,
                 std::span<float> values, const Context& context) {
  std::map<double, std::vector<size_t>> frames;
  for (size_t n = 0; n < samples.size(); ++n)
    if (!std::isnan(values[n])) frames[volume.lattice(0).is_static() ? 0 : samples[n][3]].push_back(n);
  for (const auto& [frame, numbers] : frames) {
    SampleRange range{samples[numbers.front()], samples[numbers.front()]};
    for (const size_t n : numbers) range.add(samples[n]);
    const FrameLabels labels(volume, channel, frame, range, context);
    for (const size_t n : numbers) values[n] = labels.at(samples[n]);
  }
}

EvenPlaces even_places(const OpenSlice& slice) {
  EvenPlaces places{slice.cut.even, {}};
  for (size_t k = 0; k < 3; ++k) { // along one axis each
    const Vec4& b = slice.slice.basis[k];
    places.along[k] = static_cast<size_t>(std::max_element(b.begin(), b.end()) - b.begin());
  }
  return places;
}

Grid label_grid(const OpenSlice& slice) {
  Grid grid = slice.own_grid();
  const EvenPlaces even = even_places(slice);
  const auto extent = slice.extent();
  for (size_t k = 0; k < 3; ++k) {
    if (!even.uneven(k)) continue;
    const auto sample = [&](double place) { return std::round(even.axes->index_of(even.along[k], place)); };
    grid.origin[k] = sample(extent[k][0]);
    grid.dims[k] = static_cast<int32_t>(sample(extent[k][1]) - grid.origin[k]) + 1;
  }
  return grid;
}

std::vector<float> read_labels(const OpenVolume& volume, const OpenSlice& slice, const Context& context) {
  const Grid grid = label_grid(slice);
  Vec4 origin = slice.slice.origin;
  for (size_t a = 0; a < 3 && slice.cut.even; ++a) origin[a] = slice.cut.even->index_of(a, origin[a]);
  const auto nx = static_cast<size_t>(grid.dims[0]), ny = static_cast<size_t>(grid.dims[1]),
             nz = static_cast<size_t>(grid.dims[2]);
  const auto sample = [&](size_t x, size_t y, size_t z) {
    const Vec3 n{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
    Vec4 p = origin;
    for (size_t k = 0; k < 3; ++k)
      for (size_t a = 0; a < 4; ++a) p[a] += slice.slice.basis[k][a] * (grid.origin[k] + n[k]);
    for (double& c : p) c = std::round(c);
    return p;
  };
  std::vector<float> values(nx * ny * nz);
  for (size_t first = 0, end = 0; first < nz; first = end) {
    end = std::min(nz, first + planes_at_once);
    SampleRange range{sample(0, 0, first), sample(0, 0, first)};
    range.add(sample(nx - 1, ny - 1, end - 1));
    for (double frame = range.low[3]; frame <= range.high[3]; ++frame) {
      const FrameLabels labels(volume, slice.channel, frame, range, context);
      context.tasks.parallel_for(ny * (end - first), [&](uint64_t row) {
        const size_t y = row % ny, z = first + row / ny;
        const double from = sample(0, y, z)[3], to = sample(nx - 1, y, z)[3];
        for (size_t x = 0; x < nx && (from == frame || from != to); ++x)
          if (const Vec4 p = sample(x, y, z); p[3] == frame) values[(z * ny + y) * nx + x] = labels.at(p);
      });
    }
  }
  return values;
}

void hold_labels(const OpenVolume& volume, uint32_t channel, double frame, const std::optional<IndexBox>& box,
                 const Context& context) {
  SampleRange range{{0, 0, 0, frame}, {0, 0, 0, frame}};
  for (size_t a = 0; a < 3; ++a) {
    range.low[a] = box ? std::floor(box->begin[a]) : 0;
    range.high[a] = box ? std::ceil(box->end[a]) : volume.lattice(0).domain_end(a);
  }
  SampleRange part = range;
  for (double& z = part.low[2]; z <= range.high[2]; z += planes_at_once) {
    part.high[2] = std::min(range.high[2], z + planes_at_once - 1);
    (void)FrameLabels(volume, channel, frame, part, context);
  }
}

} // namespace bccsplat

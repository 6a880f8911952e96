// SPDX-License-Identifier: Apache-2.0
// Cuts the sample into blocks, transforms them axis by axis by matrices of cosines that have the window in
// them, and adds the squares up in bins of frequency. Ends are mirrored where the lattice mirrors them, and
// fade out elsewhere.
#include "choose/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "choose/beyond.h"

namespace bccsplat::series {
namespace {

constexpr size_t kBlockEdge = 32;    // samples of a block along an axis that is cut
constexpr size_t kWholeEdge = 64;    // an axis up to this long is taken whole, space and short series
constexpr uint64_t kPredicted = 23;  // frames: what happens at the ends of a shorter series is not faded out
constexpr uint64_t kLong = 43;       // samples from which on an axis is not mirrored at its faces
constexpr size_t kMostBins = 20;     // along an axis that is whole
constexpr size_t kWindowedBins = 14; // along one that is cut: the window is no finer
constexpr size_t kFewest = 4;        // samples; a shorter axis is not measured
constexpr double kNothing = 1e-8;    // of the energy: bins that are left out, all together
constexpr double kRounding = 1e-6;   // of sums of frequencies: the border of the cell belongs to it

// How a block goes on at its two ends along an axis: mirrored, as short axes are at a face, or it fades out.
struct Ends {
  bool fades[2] = {false, false};
};

// The weight of sample i of n: 1, and half of a Hann window towards an end that fades.
double fade(Ends ends, size_t i, size_t n) {
  const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  return ends.fades[at < 0.5 ? 0 : 1] ? 0.5 - 0.5 * std::cos(2 * std::numbers::pi * at) : 1;
}

// Along one axis: values of a block -> roots of its mean squares by frequency.
struct Transform {
  size_t n = 1;
  std::vector<float> weights;    // by frequency, then sample; those of a constant first
  std::vector<float> transposed; // by sample, then frequency

  // Cosines of the mirrored block, period 2 (n - 1): a sum of squares over the frequencies is the mean square
  // over the period.
  Transform(size_t samples, Ends ends) : n(samples), weights(n * n, 1), transposed(n * n, 1) {
    if (n == 1) return;
    const double period = 2 * static_cast<double>(n - 1);
    double squares = 0;
    std::vector<double> w(n);
    for (size_t i = 0; i < n; ++i) {
      const double times = i == 0 || i + 1 == n ? 1 : 2;
      w[i] = fade(ends, i, n);
      squares += times * w[i] * w[i];
    }
    const double scale = std::sqrt(period / squares) / period;
    for (size_t k = 0; k < n; ++k)
      for (size_t i = 0; i < n; ++i) {
        const double times = i == 0 || i + 1 == n ? 1 : 2;
        const double both = k == 0 || k + 1 == n ? 1 : std::numbers::sqrt2;
        const double turn = static_cast<double>(k * i % (2 * (n - 1))) / period;
        transposed[i * n + k] = weights[k * n + i] =
            static_cast<float>(both * scale * times * w[i] * std::cos(2 * std::numbers::pi * turn));
      }
  }
};

using Block = std::vector<float>;
using AxisTransforms = std::array<const Transform*, 4>;

void add_scaled(float* to, const float* from, float factor, size_t count) {
  for (size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

// Along every line of an axis.
void transform_axis(Block& block, Block& out, const AxisTransforms& axes, size_t axis) {
  const size_t n = axes[axis]->n;
  if (n == 1) return;
  size_t stride = 1;
  for (size_t a = 0; a < axis; ++a) stride *= axes[a]->n;
  out.assign(block.size(), 0);
  if (stride == 1) {
    for (size_t first = 0; first < block.size(); first += n)
      for (size_t i = 0; i < n; ++i)
        add_scaled(out.data() + first, axes[axis]->transposed.data() + i * n, block[first + i], n);
    block.swap(out);
    return;
  }
  for (size_t first = 0; first < block.size(); first += stride * n)
    for (size_t k = 0; k < n; ++k)
      for (size_t i = 0; i < n; ++i)
        add_scaled(out.data() + first + k * stride, block.data() + first + i * stride,
                   axes[axis]->weights[k * n + i], stride);
  block.swap(out);
}

// The samples of a block, fastest first, from where it begins in a stretch.
void take_block(const SampleStretch& s, size_t channel, double air, const AxisTransforms& axes,
                const std::array<size_t, 4>& at, Block& block) {
  block.clear();
  for (size_t t = 0; t < axes[3]->n; ++t)
    for (size_t z = 0; z < axes[2]->n; ++z)
      for (size_t y = 0; y < axes[1]->n; ++y) {
        const float* const row =
            s.values[channel].data() +
            (((at[3] + t) * s.box.dims[2] + at[2] + z) * s.box.dims[1] + at[1] + y) * s.box.dims[0] + at[0];
        for (size_t x = 0; x < axes[0]->n; ++x)
          block.push_back(
              static_cast<float>((std::isfinite(row[x]) ? static_cast<double>(row[x]) : air) - air));
      }
}

uint64_t length_of(const SampleStretch& s, size_t axis) { return axis == 3 ? s.frames : s.box.dims[axis]; }

// Returns where blocks begin along an axis: from one end to the other, no two overlapping; a single one is in
// the middle.
std::vector<size_t> block_begins(uint64_t length, size_t n) {
  const size_t fit = std::max<size_t>(1, length / n);
  if (fit == 1) return {(length - n) / 2};
  std::vector<size_t> begins;
  for (size_t i = 0; i < fit; ++i) begins.push_back((length - n) * i / (fit - 1));
  return begins;
}

// Energy of blocks, by bins of frequency.
struct Bins {
  std::array<size_t, 4> count{1, 1, 1, 1};
  std::vector<double> energy;

  void add(const Block& block, const AxisTransforms& axes, double weight) {
    std::array<std::vector<size_t>, 4> place; // of each frequency, in bins
    size_t stride = 1;
    for (size_t a = 0; a < 4; ++a) {
      for (size_t k = 0; k < axes[a]->n; ++k)
        place[a].push_back(axes[a]->n == 1
                               ? 0
                               : (2 * k * (count[a] - 1) + axes[a]->n - 1) / (2 * (axes[a]->n - 1)) * stride);
      stride *= count[a];
    }
    const float* v = block.data();
    for (const size_t t : place[3])
      for (const size_t z : place[2])
        for (const size_t y : place[1])
          for (const size_t x : place[0]) {
            const double value = *v++;
            energy[t + z + y + x] += weight * value * value;
          }
  }
};

// Takes the mean off, weighed as the transforms do.
void remove_mean(Block& block, const AxisTransforms& axes) {
  double sum = 0, all = 0;
  for (size_t i = 0; i < block.size(); ++i) {
    double w = 1;
    size_t rest = i;
    for (const Transform* a : axes) {
      w *= a->weights[rest % a->n]; // of a constant
      rest /= a->n;
    }
    sum += w * block[i], all += w;
  }
  const auto mean = static_cast<float>(sum / all);
  for (float& v : block) v -= mean;
}

// Blocks along an axis: of one length, and all ways to go on at their ends.
struct BlockAxis {
  size_t axis = 0, n = 1;
  uint64_t samples = 1;  // of the series
  bool whole = false;    // a block has the axis from end to end
  bool mirrored = false; // and a lattice is mirrored at its ends

  BlockAxis(const SeriesDescription& series, const SeriesSample& sample, size_t a, bool mirrors)
      : axis(a), samples(series.dims[a]), mirrors_(mirrors) {
    uint64_t length = samples;
    for (const SampleStretch& s : sample.stretches) length = std::min(length, length_of(s, a));
    whole = length == samples && length <= kWholeEdge;
    mirrored = whole && mirrors;
    n = length < kFewest ? 1 : whole ? length : std::min<uint64_t>(length, kBlockEdge);
    for (const bool first : {false, true})
      for (const bool last : {false, true}) transforms_.emplace_back(n, Ends{{first, last}});
  }
  // Returns the transform of a block from `begin` on in a stretch: it ends at a face, or it is cut there.
  [[nodiscard]] const Transform& transform(const SampleStretch& s, size_t begin) const {
    if (mirrored) return transforms_.front();
    if (axis == 3 || !mirrors_) return transforms_.back();
    const uint64_t first = s.box.begin[axis] + begin;
    return transforms_[(first > 0 ? 2 : 0) + (first + n < samples ? 1 : 0)];
  }

 private:
  bool mirrors_; // the lattice does so at the ends of the axis
  std::vector<Transform> transforms_;
};

// Does a lattice mirror this axis at its ends, which are treated so?
bool is_mirrored(size_t axis, uint64_t samples, int32_t faces, int32_t ends, int32_t periodic) {
  if (axis == 3)
    return ends == BCCSPLAT_ENDS_MIRROR || (ends == BCCSPLAT_ENDS_DEFAULT && samples < kPredicted);
  if (is_periodic(periodic, axis)) return false;
  if (faces >= BCCSPLAT_FACES_PREDICT_X) return (faces & face_bit(axis)) == 0;
  return faces == BCCSPLAT_FACES_MIRROR || (faces == BCCSPLAT_FACES_DEFAULT && samples < kLong);
}

} // namespace

Spectrum::Spectrum(const SeriesDescription& series, const SeriesSample& sample,
                   const std::vector<double>& air, int32_t faces, int32_t ends, int32_t periodic,
                   Watch& watch) {
  std::vector<BlockAxis> axes;
  Bins sums;
  size_t bins = 1;
  for (size_t a = 0; a < 4; ++a) {
    axes.emplace_back(series, sample, a, is_mirrored(a, series.dims[a], faces, ends, periodic));
    windowed_[a] = !axes[a].mirrored;
    sums.count[a] = count_[a] = std::min<size_t>(axes[a].n, axes[a].whole ? kMostBins : kWindowedBins);
    bins *= count_[a];
  }
  sums.energy.assign(bins, 0);
  Block block, scratch;
  for (const SampleStretch& s : sample.stretches) {
    std::array<std::vector<size_t>, 4> at;
    size_t blocks = 1;
    for (size_t a = 0; a < 4; ++a) {
      at[a] = block_begins(length_of(s, a), axes[a].n);
      blocks *= at[a].size();
    }
    for (size_t c = 0; c < s.values.size(); ++c) {
      const double range = sample.ranges[c].max - sample.ranges[c].min;
      if (!(range > 0)) continue;
      const double weight = s.weight / static_cast<double>(blocks * s.values.size()) / (range * range);
      for (size_t b = 0; b < blocks; ++b) {
        watch.go_on();
        std::array<size_t, 4> begin{};
        AxisTransforms transforms{};
        size_t rest = b;
        for (size_t a = 0; a < 4; ++a) {
          begin[a] = at[a][rest % at[a].size()], rest /= at[a].size();
          transforms[a] = &axes[a].transform(s, begin[a]);
        }
        take_block(s, c, air[c], transforms, begin, block);
        remove_mean(block, transforms);
        for (size_t a = 0; a < 4; ++a) transform_axis(block, scratch, transforms, a);
        sums.add(block, transforms, weight);
      }
    }
  }
  for (const double e : sums.energy) total_ += e;
  for (size_t i = 0; i < sums.energy.size(); ++i) {
    if (!(sums.energy[i] > kNothing * total_ / static_cast<double>(bins))) continue;
    Bin bin;
    bin.energy = sums.energy[i];
    size_t rest = i;
    for (size_t a = 0; a < 4; ++a) {
      bin.at[a] = static_cast<uint8_t>(rest % count_[a]);
      rest /= count_[a];
    }
    bins_.push_back(bin);
  }
}

double Spectrum::resolution(size_t axis) const {
  return count_[axis] == 1 ? 0 : (windowed_[axis] ? 2 : 1) / static_cast<double>(count_[axis] - 1);
}

double Spectrum::percentile(size_t axis, double part) const {
  if (count_[axis] == 1 || empty()) return 0;
  const size_t count = count_[axis];
  std::vector<double> sum(count);
  for (const Bin& b : bins_) sum[b.at[axis]] += b.energy;
  double below = 0;
  for (size_t k = 0; k < count; ++k)
    if ((below += sum[k]) >= part * total_) return static_cast<double>(k) / static_cast<double>(count - 1);
  return 1;
}

double Spectrum::outside() const {
  if (empty()) return 0;
  double sum = 0;
  for (const Bin& b : bins_) {
    std::array<double, 4> f{};
    for (size_t a = 0; a < 4; ++a) f[a] = frequency(a, b.at[a]);
    std::sort(f.begin(), f.end());
    if (f[2] + f[3] > std::numbers::sqrt2 + kRounding) sum += b.energy;
  }
  return sum / total_;
}

} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
// Sums up bin by bin what kernel and filter leave of a wave, of its image in the source's grid and of what
// they fold to. Distances are searched in pairs, one wider and one narrower; most steps are refused by a
// glance at one bin in 16.
#include "choose/lattice_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

#include "choose/wave_error.h"

namespace bccsplat::series {
namespace {

constexpr double kFinest = 0.5, kCoarsest = 8;       // distances that are looked at
constexpr double kFewestPlanes = 3;                  // along an axis
constexpr double kFirstStep = 0.4, kLastStep = 0.02; // of logarithms of distances
// A shape is looked at by one of so many bins first, and dropped if these are worse by so many standard
// errors.
constexpr size_t kGlance = 16;
constexpr double kSurely = 3;
// More sites than asked for count as so much more error: errors fall more slowly with them.
constexpr double kOfDensity = 4;
constexpr double kSameDistance = 1e-9;

// A wave along one axis, beside a lattice.
struct AxisWave {
  double amplitude = 1; // of what the filter lets through
  double frequency = 0; // in units of the lattice's
};

// A wave and its image in the grid of the source, whose sum the source's samples are; one too faint to count
// is left out.
using WaveAndImage = std::array<AxisWave, 2>;
constexpr double kFaint = 1e-3; // amplitude

WaveAndImage waves_of(double frequency, double distance) {
  const double widening = std::max(1.0, distance);
  WaveAndImage both;
  for (size_t i = 0; i < 2; ++i) {
    const double f = i == 0 ? frequency : 2 - frequency;
    both[i] = {filter_response(f * widening), f * distance};
  }
  if (std::fabs(both[1].amplitude) <= kFaint) both[1].amplitude = 0;
  return both;
}

// Largest |f_i| + |f_j| over sqrt2.
double pair_gauge(const std::array<double, 4>& g) {
  const double a = std::max(g[0], g[1]), b = std::min(g[0], g[1]);
  const double c = std::max(g[2], g[3]), d = std::min(g[2], g[3]);
  return (std::max(a, c) + std::max(std::min(a, c), a > c ? b : d)) / std::numbers::sqrt2;
}

// What waves along the axes of D4* and BCC become, by number of frequency. Mean square error of one of mean
// square 1: what is lost of the wave and its images, and what they fold to.
class LatticeWaves {
 public:
  LatticeWaves(const Spectrum& spectrum, const Distances& distances) {
    for (size_t a = 0; a < 4; ++a)
      for (size_t k = 0; k < spectrum.count(a); ++k)
        axes_[a].push_back(waves_of(spectrum.frequency(a, k), distances[a]));
  }
  [[nodiscard]] double error(const Spectrum::Bin& bin) const {
    size_t imaged = 0; // axes with an image
    for (size_t a = 0; a < 4; ++a)
      if (axes_[a][bin.at[a]][1].amplitude != 0) imaged |= size_t{1} << a;
    double pass = 0, folded = 0;
    for (size_t images = imaged;; images = (images - 1) & imaged) { // every part of `imaged`, nothing last
      double amplitude = 1;
      std::array<double, 4> frequency{};
      for (size_t a = 0; a < 4; ++a) {
        const AxisWave& wave = axes_[a][bin.at[a]][images >> a & 1];
        amplitude *= wave.amplitude, frequency[a] = wave.frequency;
      }
      const WaveResponse r = lattice_response(pair_gauge(frequency));
      pass += amplitude * r.pass, folded += amplitude * amplitude * r.folded;
      if (images == 0) break;
    }
    return (1 - pass) * (1 - pass) + folded;
  }

 private:
  std::array<std::vector<WaveAndImage>, 4> axes_;
};

// The same on CC, where sums over waves and images are products of the sums along each axis.
class CartesianWaves {
 public:
  CartesianWaves(const Spectrum& spectrum, const Distances& distances) {
    for (size_t a = 0; a < 4; ++a)
      for (size_t k = 0; k < spectrum.count(a); ++k) {
        Sums& sums = axes_[a].emplace_back();
        if (std::fabs(distances[a] - 1) < kSameDistance)
          sums = {1, 1, 1}; // the samples themselves
        else
          for (const AxisWave& wave : waves_of(spectrum.frequency(a, k), distances[a])) add(wave, sums);
      }
  }
  [[nodiscard]] double error(const Spectrum::Bin& bin) const {
    double pass = 1, passed = 1, all = 1;
    for (size_t a = 0; a < 4; ++a) {
      const Sums& sums = axes_[a][bin.at[a]];
      pass *= sums.pass, passed *= sums.passed, all *= sums.all;
    }
    return (1 - pass) * (1 - pass) + all - passed;
  }

 private:
  // Amplitudes that pass, and energies of what passes, and of that with what it folds to.
  struct Sums {
    double pass = 0, passed = 0, all = 0;
  };
  static void add(const AxisWave& wave, Sums& sums) {
    const WaveResponse r = cartesian_response(wave.frequency);
    const double energy = wave.amplitude * wave.amplitude;
    sums.pass += wave.amplitude * r.pass;
    sums.passed += energy * r.pass * r.pass;
    sums.all += energy * (r.pass * r.pass + r.folded);
  }
  std::array<std::vector<Sums>, 4> axes_;
};

using SpectrumBins = std::vector<Spectrum::Bin>;

// No further than to where it is more than `most`.
template<class Waves> double error_of(const Waves& waves, const SpectrumBins& bins, double most) {
  double error = 0;
  for (const Spectrum::Bin& b : bins)
    if ((error += b.energy * waves.error(b)) > most) break;
  return error;
}

double error_of(const Spectrum& spectrum, const SpectrumBins& bins, const LatticeShape& shape,
                const std::array<uint64_t, 4>& dims, double most) {
  const Distances distances = realised_distances(shape, dims);
  return is_bcc(shape) ? error_of(LatticeWaves(spectrum, distances), bins, most)
                       : error_of(CartesianWaves(spectrum, distances), bins, most);
}

// Returns the error in each bin.
std::vector<double> errors_of(const Spectrum& spectrum, const SpectrumBins& bins, const LatticeShape& shape,
                              const std::array<uint64_t, 4>& dims) {
  std::vector<double> errors;
  errors.reserve(bins.size());
  const Distances distances = realised_distances(shape, dims);
  const auto collect = [&](const auto& waves) {
    for (const Spectrum::Bin& b : bins) errors.push_back(b.energy * waves.error(b));
  };
  if (is_bcc(shape))
    collect(LatticeWaves(spectrum, distances));
  else
    collect(CartesianWaves(spectrum, distances));
  return errors;
}

// Bins that a shape loses most of first: what is worse than it is soon seen to be.
SpectrumBins by_error(const Spectrum& spectrum, const SpectrumBins& of, const LatticeShape& shape,
                      const std::array<uint64_t, 4>& dims) {
  const std::vector<double> errors = errors_of(spectrum, of, shape, dims);
  std::vector<size_t> order(errors.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return errors[a] > errors[b]; });
  SpectrumBins bins;
  for (const size_t i : order) bins.push_back(of[i]);
  return bins;
}

// Neighbours along each axis as one, but for the first of them: with a fifteenth of the bins, or more, a
// search takes as much less time.
SpectrumBins merged_bins(const Spectrum& spectrum) {
  struct Sum {
    double energy = 0;
    std::array<double, 4> at{};
  };
  std::map<std::array<uint8_t, 4>, Sum> sums;
  for (const Spectrum::Bin& b : spectrum.bins()) {
    std::array<uint8_t, 4> place{};
    for (size_t a = 0; a < 4; ++a) place[a] = static_cast<uint8_t>((b.at[a] + 1) / 2);
    Sum& sum = sums[place];
    sum.energy += b.energy;
    for (size_t a = 0; a < 4; ++a) sum.at[a] += b.energy * b.at[a];
  }
  SpectrumBins bins;
  for (const auto& [place, sum] : sums) {
    Spectrum::Bin& bin = bins.emplace_back();
    bin.energy = sum.energy;
    for (size_t a = 0; a < 4; ++a) bin.at[a] = static_cast<uint8_t>(std::lround(sum.at[a] / sum.energy));
  }
  return bins;
}

// Searches distances around a shape, pairs of axes against each other so that the density stays.
class ShapeSearch {
 public:
  ShapeSearch(const Spectrum& spectrum, double density, const std::array<uint64_t, 4>& dims, Watch& watch)
      : spectrum_(spectrum), density_(density), dims_(dims), watch_(watch) {}

  [[nodiscard]] LatticeShape descend(LatticeShape best) {
    bins_ = by_error(spectrum_, merged_bins(spectrum_), best, dims_);
    for (size_t i = kGlance / 2; i < bins_.size(); i += kGlance) few_.push_back(bins_[i]);
    double least = cost(best, HUGE_VAL);
    std::vector<double> glance = glance_at(best);
    for (double step = kFirstStep; step >= kLastStep;) {
      bool better = false;
      for (size_t up = 0; up < 4; ++up)
        for (size_t down = 0; down < 4; ++down) {
          if (up == down) continue;
          watch_.go_on();
          const LatticeShape next = moved(best, up, down, std::exp(step));
          if (!allowed(next)) continue;
          std::vector<double> next_glance = glance_at(next);
          if (surely_more(next_glance, glance)) continue;
          const double c = cost(next, least);
          if (c >= least) continue;
          least = c, best = next, better = true;
          glance = std::move(next_glance);
        }
      if (!better) step /= 2;
    }
    return best;
  }

 private:
  [[nodiscard]] double factor(const LatticeShape& s) const {
    return std::pow(std::max(1.0, site_density(s, dims_) / density_), kOfDensity);
  }
  // Returns the cost of a shape; where it is more than `most`, perhaps not all of it.
  [[nodiscard]] double cost(const LatticeShape& s, double most) const {
    return factor(s) * error_of(spectrum_, bins_, s, dims_, most / factor(s));
  }
  // Parts of the cost.
  [[nodiscard]] std::vector<double> glance_at(const LatticeShape& s) const {
    std::vector<double> parts = errors_of(spectrum_, few_, s, dims_);
    const double times = factor(s);
    for (double& part : parts) part *= times;
    return parts;
  }
  // Returns whether the first one is more, as far as was sampled.
  [[nodiscard]] static bool surely_more(const std::vector<double>& a, const std::vector<double>& b) {
    double more = 0, squares = 0;
    for (size_t i = 0; i < a.size(); ++i) more += a[i] - b[i], squares += (a[i] - b[i]) * (a[i] - b[i]);
    return more > kSurely * std::sqrt(squares);
  }
  [[nodiscard]] static LatticeShape moved(LatticeShape s, size_t up, size_t down, double factor) {
    s.scales[up] *= factor, s.scales[down] /= factor;
    return s;
  }
  [[nodiscard]] bool allowed(const LatticeShape& s) const {
    for (size_t a = 0; a < 4; ++a) {
      if (dims_[a] == 1) {
        if (s.scales[a] != 1) return false;
        continue;
      }
      const double planes = static_cast<double>(dims_[a] - 1) / s.scales[a];
      if (s.scales[a] < kFinest || s.scales[a] > kCoarsest) return false;
      if (s.scales[a] > 1 && planes < kFewestPlanes) return false;
    }
    return true;
  }

  const Spectrum& spectrum_;
  double density_;
  const std::array<uint64_t, 4>& dims_;
  Watch& watch_;
  SpectrumBins bins_, few_; // few: of all kinds
};

} // namespace

double predicted_error(const Spectrum& spectrum, const LatticeShape& shape,
                       const std::array<uint64_t, 4>& dims) {
  return error_of(spectrum, spectrum.bins(), shape, dims, HUGE_VAL);
}

LatticeShape fit_lattice(const Spectrum& spectrum, int32_t lattice, double density,
                         const std::array<uint64_t, 4>& dims, Watch& watch) {
  return ShapeSearch(spectrum, density, dims, watch).descend(cubic_lattice(lattice, density, dims));
}

} // namespace bccsplat::series

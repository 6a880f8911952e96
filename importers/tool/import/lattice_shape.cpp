#include "tool/import/lattice_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "readers/error.h"
#include "tool/handles.h"
#include "tool/import/wave_error.h"
#include "tool/interrupt.h"

namespace bcc4 {
namespace {

constexpr double kFinest = 0.5, kCoarsest = 8;       // distances that are looked at
constexpr double kFewestPlanes = 3;                  // along an axis
constexpr double kFirstStep = 0.4, kLastStep = 0.02; // of logarithms of distances
// More sites than asked for count as so much more error: errors fall more slowly with them.
constexpr double kOfDensity = 4;
constexpr double kRounding = 1e-9;

bool is_bcc(const LatticeShape& s) { return s.lattice != BCCSPLAT_LATTICE_CC; }
// In units of the lattice's distance.
double plane_distance(const LatticeShape& s) { return is_bcc(s) ? 1 / std::numbers::sqrt2 : 1; }

// The number of the last plane of an axis of n samples.
double last_plane(const LatticeShape& s, size_t axis, uint64_t n) {
  return std::max(1.0,
                  std::ceil(static_cast<double>(n - 1) / (s.scales[axis] * plane_distance(s)) - kRounding));
}

double axes_of(const std::array<uint64_t, 4>& dims) {
  return static_cast<double>(std::count_if(dims.begin(), dims.end(), [](uint64_t n) { return n > 1; }));
}

// Distances of `lattice` at a density when all are alike.
double even_distance(int32_t lattice, double density, const std::array<uint64_t, 4>& dims) {
  const double axes = axes_of(dims);
  // Sites in a cube of the distance: 2 to a cell of sqrt2 times it.
  const double sites = lattice == BCCSPLAT_LATTICE_CC ? 1 : 2 / std::pow(std::numbers::sqrt2, axes);
  return axes > 0 ? std::pow(sites / density, 1 / axes) : 1;
}

// One axis of a spectrum beside a lattice, by frequency: the wave itself and its image in the grid of the
// source, whose sum the source's samples are.
struct AxisWaves {
  struct Part {
    double amplitude = 1; // of what the filter lets through
    double frequency = 0; // in units of the lattice's
  };
  std::vector<std::array<Part, 2>> waves; // by number of frequency

  AxisWaves(const Spectrum& spectrum, size_t axis, double distance, bool at_samples) {
    const double widening = std::max(1.0, distance);
    for (size_t k = 0; k < spectrum.count(axis); ++k) {
      const double f = spectrum.frequency(axis, k), image = 2 - f;
      if (at_samples)
        waves.push_back({Part{1, 0}, Part{0, 0}});
      else
        waves.push_back({Part{filter_response(f * widening), f * distance},
                         Part{filter_response(image * widening), image * distance}});
    }
  }
};

// Largest |f_i| + |f_j| over sqrt2.
double pair_gauge(const std::array<double, 4>& g) {
  const double a = std::max(g[0], g[1]), b = std::min(g[0], g[1]);
  const double c = std::max(g[2], g[3]), d = std::min(g[2], g[3]);
  return (std::max(a, c) + std::max(std::min(a, c), a > c ? b : d)) / std::numbers::sqrt2;
}

WaveResponse response_of(bool bcc, const std::array<double, 4>& frequency) {
  if (bcc) return lattice_response(pair_gauge(frequency));
  double pass = 1, all = 1; // energies of a product of sums multiply
  for (const double f : frequency) {
    const WaveResponse r = cartesian_response(f);
    pass *= r.pass;
    all *= r.pass * r.pass + r.folded;
  }
  return {pass, all - pass * pass};
}

using AxisParts = std::array<AxisWaves::Part, 2>;

// Mean square error of a wave of mean square 1: what is lost of the wave and its images, and what they fold
// to.
double error_of_wave(bool bcc, const std::array<const AxisParts*, 4>& axes) {
  constexpr double negligible = 1e-3; // amplitude of an image
  size_t imaged = 0;                  // axes with one
  for (size_t a = 0; a < 4; ++a)
    if (std::fabs((*axes[a])[1].amplitude) > negligible) imaged |= size_t{1} << a;
  double pass = 0, folded = 0;
  for (size_t images = imaged;; images = (images - 1) & imaged) { // every part of `imaged`, nothing last
    double amplitude = 1;
    std::array<double, 4> frequency{};
    for (size_t a = 0; a < 4; ++a) {
      const AxisWaves::Part& part = (*axes[a])[images >> a & 1];
      amplitude *= part.amplitude, frequency[a] = part.frequency;
    }
    const WaveResponse r = response_of(bcc, frequency);
    pass += amplitude * r.pass, folded += amplitude * amplitude * r.folded;
    if (images == 0) break;
  }
  return (1 - pass) * (1 - pass) + folded;
}

// Searches distances around a shape, pairs of axes against each other so that the density stays.
class ShapeSearch {
 public:
  ShapeSearch(const Spectrum& spectrum, double density, const std::array<uint64_t, 4>& dims)
      : spectrum_(spectrum), density_(density), dims_(dims) {}

  [[nodiscard]] double cost(const LatticeShape& s) const {
    return foretold_error(spectrum_, s, dims_) *
           std::pow(std::max(1.0, site_density(s, dims_) / density_), kOfDensity);
  }
  [[nodiscard]] LatticeShape descend(LatticeShape best) const {
    double least = cost(best);
    for (double step = kFirstStep; step >= kLastStep;) {
      bool better = false;
      for (size_t up = 0; up < 4; ++up)
        for (size_t down = 0; down < 4; ++down) {
          if (up == down) continue;
          stop_if_interrupted();
          const LatticeShape next = moved(best, up, down, std::exp(step));
          if (!allowed(next)) continue;
          const double c = cost(next);
          if (c >= least) continue;
          least = c, best = next, better = true;
        }
      if (!better) step /= 2;
    }
    return best;
  }

 private:
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
};

} // namespace

Distances realised_distances(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  Distances d = s.scales; // along time exact: a series may go on
  for (size_t a = 0; a < 3; ++a)
    if (dims[a] > 1) d[a] = static_cast<double>(dims[a] - 1) / last_plane(s, a, dims[a]) / plane_distance(s);
  return d;
}

double site_density(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  const size_t cosets = is_bcc(s) ? 2 : 1;
  double sites = 0, samples = 1;
  for (size_t c = 0; c < cosets; ++c) {
    double of_coset = 1;
    for (size_t a = 0; a < 4; ++a) {
      if (a == 3 && dims[a] == 1) continue;
      of_coset *=
          std::floor((last_plane(s, a, dims[a]) - static_cast<double>(c)) / static_cast<double>(cosets)) + 1;
    }
    sites += of_coset;
  }
  for (const uint64_t n : dims) samples *= static_cast<double>(n);
  return sites / samples;
}

double foretold_error(const Spectrum& spectrum, const LatticeShape& shape,
                      const std::array<uint64_t, 4>& dims) {
  const Distances distances = realised_distances(shape, dims);
  std::vector<AxisWaves> axes;
  for (size_t a = 0; a < 4; ++a)
    axes.emplace_back(spectrum, a, distances[a], !is_bcc(shape) && std::fabs(distances[a] - 1) < kRounding);
  double error = 0;
  for (const Spectrum::Bin& b : spectrum.bins())
    error += b.energy * error_of_wave(is_bcc(shape), {&axes[0].waves[b.at[0]], &axes[1].waves[b.at[1]],
                                                      &axes[2].waves[b.at[2]], &axes[3].waves[b.at[3]]});
  return error;
}

LatticeShape cubic_lattice(int32_t lattice, double density, const std::array<uint64_t, 4>& dims) {
  LatticeShape s{lattice, {1, 1, 1, 1}};
  double distance = even_distance(lattice, density, dims);
  if (std::fabs(distance - 1) < kRounding) distance = 1;
  for (size_t a = 0; a < 4; ++a)
    if (dims[a] > 1) s.scales[a] = distance;
  return s;
}

LatticeShape scaled_shape(LatticeShape shape, double fewer, const std::array<uint64_t, 4>& dims) {
  const double factor = std::pow(fewer, 1 / std::max(1.0, axes_of(dims)));
  for (size_t a = 0; a < 4; ++a)
    if (dims[a] > 1) shape.scales[a] *= factor;
  return shape;
}

LatticeShape fit_lattice(const Spectrum& spectrum, int32_t lattice, double density,
                         const std::array<uint64_t, 4>& dims) {
  const ShapeSearch search(spectrum, density, dims);
  return search.descend(cubic_lattice(lattice, density, dims));
}

std::string shape_text(const LatticeShape& shape, const std::array<uint64_t, 4>& dims) {
  const Distances d = realised_distances(shape, dims);
  std::string text = concat(lattice_name(shape.lattice), ", distances");
  for (size_t a = 0; a < (dims[3] > 1 ? 4 : 3); ++a)
    text += concat(a == 0 ? " " : " x ", short_number(d[a], 3));
  return text;
}

} // namespace bcc4

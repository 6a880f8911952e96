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
// From so many on a writer predicts beyond them (BCCSPLAT_ENDS_DEFAULT).
constexpr uint64_t kPredictedLayers = 20;
constexpr double kPlanesOutside = 4; // both faces of an axis together, or both ends of time
constexpr std::array<int32_t, 3> kAcross{BCCSPLAT_FACES_PREDICT_X, BCCSPLAT_FACES_PREDICT_Y,
                                         BCCSPLAT_FACES_PREDICT_Z};

bool is_bcc(const LatticeShape& s) { return s.lattice != BCCSPLAT_LATTICE_CC; }
// Are its sites samples of the source in space, at the frames it has?
bool has_source_planes(const LatticeShape& s) {
  return !is_bcc(s) &&
         std::all_of(s.scales.begin(), s.scales.begin() + 3, [](double scale) { return scale == 1; });
}
bool has_source_frames(const LatticeShape& s) { return !is_bcc(s) && s.scales[3] == 1; }
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
        if (std::fabs(distances[a] - 1) < kRounding)
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

template<class Waves> double error_of(const Waves& waves, const Spectrum& spectrum) {
  double error = 0;
  for (const Spectrum::Bin& b : spectrum.bins()) error += b.energy * waves.error(b);
  return error;
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

bool is_source_grid(const LatticeShape& s) { return has_source_planes(s) && has_source_frames(s); }

Distances realised_distances(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  Distances d = s.scales; // along time exact: a series may go on
  for (size_t a = 0; a < 3; ++a)
    if (dims[a] > 1) d[a] = static_cast<double>(dims[a] - 1) / last_plane(s, a, dims[a]) / plane_distance(s);
  return d;
}

LatticeShape shape_of_part(const LatticeShape& shape, const std::array<uint64_t, 4>& dims,
                           const std::array<uint64_t, 4>& part, bool ends_with_series) {
  LatticeShape s = shape;
  const Distances distances = realised_distances(shape, dims);
  for (size_t a = 0; a < 4; ++a) {
    if (part[a] == dims[a] || part[a] == 1 || (a == 3 && !ends_with_series)) continue;
    const double plane = distances[a] * plane_distance(shape);
    double length = static_cast<double>(part[a] - 1);
    if (a == 3) length += last_plane(shape, a, dims[a]) * plane - static_cast<double>(dims[a] - 1);
    s.scales[a] = length / std::max(1.0, std::round(length / plane)) / plane_distance(shape);
  }
  return s;
}

int32_t faces_of_part(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  if (s.faces >= BCCSPLAT_FACES_PREDICT_X) return s.faces;
  const bool asked = s.faces == BCCSPLAT_FACES_PREDICT;
  if (s.faces == BCCSPLAT_FACES_MIRROR || (has_source_planes(s) && !asked)) return BCCSPLAT_FACES_MIRROR;
  int32_t along = 0;
  for (size_t a = 0; a < 3; ++a)
    if (last_plane(s, a, dims[a]) + kPlanesOutside >= kPlanesOutside * (asked ? 5 : 16)) along += kAcross[a];
  return along > 0 ? along : BCCSPLAT_FACES_MIRROR;
}

uint64_t inner_layers(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  return dims[3] == 1 ? 1 : static_cast<uint64_t>(last_plane(s, 3, dims[3])) + 1;
}

bool predicts_ends(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  if (s.ends != BCCSPLAT_ENDS_DEFAULT || dims[3] == 1) return s.ends == BCCSPLAT_ENDS_PREDICT && dims[3] > 1;
  return is_bcc(s) && inner_layers(s, dims) >= kPredictedLayers;
}

LatticeShape with_beyond(LatticeShape s, Beyond beyond) {
  if (beyond == Beyond::plain) return s;
  if (s.faces == BCCSPLAT_FACES_DEFAULT && !has_source_planes(s)) s.faces = BCCSPLAT_FACES_PREDICT;
  if (beyond == Beyond::all && s.ends == BCCSPLAT_ENDS_DEFAULT && !has_source_frames(s))
    s.ends = BCCSPLAT_ENDS_PREDICT;
  return s;
}

bool goes_on_alike(const LatticeShape& a, const LatticeShape& b, const std::array<uint64_t, 4>& dims) {
  return faces_of_part(a, dims) == faces_of_part(b, dims) && predicts_ends(a, dims) == predicts_ends(b, dims);
}

double outside_share(const LatticeShape& s, const std::array<uint64_t, 4>& dims, int32_t across, bool ends) {
  double all = ends ? 1 + kPlanesOutside / (last_plane(s, 3, dims[3]) + 1) : 1;
  for (size_t a = 0; a < 3; ++a)
    if (across & kAcross[a]) all *= 1 + kPlanesOutside / (last_plane(s, a, dims[a]) + 1);
  return all - 1;
}

double outside_share(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  return outside_share(s, dims, faces_of_part(s, dims), predicts_ends(s, dims));
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
  return is_bcc(shape) ? error_of(LatticeWaves(spectrum, distances), spectrum)
                       : error_of(CartesianWaves(spectrum, distances), spectrum);
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
  if (shape.faces == BCCSPLAT_FACES_PREDICT || shape.ends == BCCSPLAT_ENDS_PREDICT)
    text += ", ends predicted";
  return text;
}

} // namespace bcc4

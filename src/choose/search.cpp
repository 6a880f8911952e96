// SPDX-License-Identifier: Apache-2.0
// Begins each lattice at the density that its spectrum predicts, goes denser, then coarser while the sample
// takes fewer bytes, and gives each shape the steps that use up the error accepted. What no coding reaches is
// left to corrections.
#include "choose/search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>

#include "choose/lattice_choice.h"

namespace bccsplat::series {
namespace {

// dB by which the sample must beat the series: more takes a finer coding than needed, less writes more series
// twice.
constexpr double kPsnrReserve = 0.3;
// The share of the allowed error that the lattice may take, rounding the rest, where the search begins.
constexpr double kLatticeShare = 0.4;
// A largest error over the root of the mean square that lattice and rounding are to have: less leaves more
// samples to correct, more takes a finer coding. Twice is the least.
constexpr double kPeaks[] = {3, 2.3, 4};
// The same of rounding alone, where the lattice has the samples themselves: largest over root of an even
// spread.
constexpr double kRoundingPeak = 1.7321, kNoError = 0.01; // of the bound
constexpr double kDenser = 1.35;                          // from one density to the next
constexpr int kRoundings = 4;                             // trials for the steps of a shape
constexpr double kClose = 0.15;                           // dB above the goal that are near enough
// Once it is known what rounding adds: aimed at so much above the goal, as what is missed by a hair is lost.
constexpr double kAim = 0.04;
// A lattice that begins with so many times the bytes of the best coding so far is not searched further.
constexpr double kHopelessBytes = 1.3;
constexpr double kLeastDensity = 0.004, kMostDensity = 1.5;
constexpr double kEvenSpread = 12; // an even spread of width q has the mean square q^2 / 12
constexpr double kTimeScales[] = {8, 6, 4, 3, 2.5, 2, 1.5, 1.25};
constexpr double kGoodPsnr = 45.5; // dB that any time scale may keep
constexpr double kLostPsnr = 3;    // or dB that it may lose against scale 1
constexpr double kFewestSteps = 2; // along time on a coarser lattice

double wider(double a, double otherwise) { return a > 0 ? a : otherwise; }

} // namespace

ErrorBound usual_bound(const ErrorBound& asked, int32_t store) {
  constexpr double kUsualPsnr = 50; // dB of wavelets
  return asked.any() || store != BCCSPLAT_STORE_WAVELETS ? asked : ErrorBound{0, kUsualPsnr};
}

double peak_of(const std::vector<ChannelScan>& scans) {
  double peak = 0;
  for (const ChannelScan& s : scans)
    if (!s.empty()) peak = std::max(peak, s.max - s.min);
  return peak;
}

LatticeShape shape_of(const WriterSettings& settings, const SeriesDescription& series) {
  LatticeShape shape;
  shape.lattice = settings.lattice == BCCSPLAT_LATTICE_CC ? BCCSPLAT_LATTICE_CC
                  : series.dims[3] > 1                    ? BCCSPLAT_LATTICE_D4STAR
                                                          : BCCSPLAT_LATTICE_BCC;
  for (size_t a = 0; a < 4; ++a)
    shape.scales[a] = wider(settings.scales[a], wider(a < 3 ? settings.scale : settings.time_scale, 1));
  if (series.dims[3] == 1) shape.scales[3] = 1;
  shape.faces = settings.faces, shape.ends = settings.ends, shape.periodic = settings.periodic;
  return shape;
}

namespace {

// The search of one import.
class BoundSearch {
 public:
  BoundSearch(Trier& trier, const Spectra& spectra, const SeriesDescription& series,
              const WriterSettings& settings, const ErrorBound& bound, const std::vector<ChannelScan>& scans)
      : trier_(trier), spectra_(spectra), series_(series), settings_(settings), bound_(bound), scans_(scans) {
  }

  void run() {
    if (has_distances(settings_)) {
      const LatticeShape shape = shape_of(settings_, series_);
      LatticeShape best = shape;
      for (const Beyond beyond : {Beyond::faces, Beyond::all}) {
        const LatticeShape next = with_beyond(shape, beyond);
        if (!goes_on_alike(next, best, series_.dims) && merit_of(next) > merit_of(best)) best = next;
      }
      consider(best);
    } else {
      search_lattices();
      // All samples: what can be rounded away there no lattice knows better.
      if (may_be_cartesian())
        consider({BCCSPLAT_LATTICE_CC, {1, 1, 1, 1}, settings_.faces, settings_.ends, settings_.periodic});
    }
    if (!best_ && most_exact_) try_coding({trier_.tried()[*most_exact_].coding.shape, {}, bound_.abs});
    if (best_ && !holds(trier_.tried()[*best_])) correct_what_misses();
  }
  [[nodiscard]] size_t best() const { return best_.value_or(0); }
  [[nodiscard]] bool holds(const CodingTrial& t) const {
    return t.holds && (bound_.psnr == 0 || t.psnr >= bound_.psnr + kPsnrReserve);
  }

 private:
  [[nodiscard]] bool may_be_cartesian() const {
    return settings_.lattice == BCCSPLAT_LATTICE_CC ||
           (settings_.lattice == BCCSPLAT_LATTICE_DEFAULT && !settings_.lowpass &&
            has_cartesian(settings_.kernel));
  }
  [[nodiscard]] std::vector<int32_t> lattices() const {
    if (settings_.lattice == BCCSPLAT_LATTICE_CC) return {BCCSPLAT_LATTICE_CC};
    std::vector<int32_t> kinds{shape_of(settings_, series_).lattice};
    if (may_be_cartesian()) kinds.push_back(BCCSPLAT_LATTICE_CC);
    return kinds;
  }
  // Mean square error that a channel may have, as a root.
  [[nodiscard]] double allowed_root(size_t channel, double peak, double above = 0) const {
    if (bound_.abs > 0) return bound_.abs / peak;
    const ChannelScan& s = scans_[channel];
    return s.empty() ? 0 : (s.max - s.min) * std::pow(10, -(bound_.psnr + kPsnrReserve + above) / 20);
  }
  // Over the square of the range, of the channel that may have least.
  [[nodiscard]] double allowed_part() const {
    double least = 1;
    for (size_t c = 0; c < scans_.size(); ++c) {
      const double range = scans_[c].empty() ? 0 : scans_[c].max - scans_[c].min;
      if (range > 0) least = std::min(least, std::pow(allowed_root(c, kPeaks[0]) / range, 2));
    }
    return least;
  }

  [[nodiscard]] bool better(size_t a, size_t b) const {
    const CodingTrial &x = trier_.tried()[a], &y = trier_.tried()[b];
    if (holds(x) != holds(y)) return holds(x);
    return holds(x) || bound_.abs > 0 ? x.bytes < y.bytes : x.psnr > y.psnr;
  }
  size_t try_coding(const Coding& coding) {
    const size_t i = trier_.try_coding(coding);
    // A coding without its corrections is tried for what it is, not for its bytes.
    if (coding.abs_error == bound_.abs && (!best_ || better(i, *best_))) best_ = i;
    return i;
  }

  // Steps that bring the error of a shape up to what is allowed; `plain`: its trial in the source's values,
  // `rounded`: one in steps, if any.
  [[nodiscard]] std::vector<StepCoding> steps_of(const CodingTrial& plain, const CodingTrial* rounded,
                                                 double peak) const {
    if (settings_.quantize != BCCSPLAT_TYPE_DEFAULT) return {};
    std::vector<double> wanted;
    for (size_t c = 0; c < scans_.size(); ++c) {
      const double allowed = std::pow(allowed_root(c, peak, rounded ? kAim : 0), 2);
      const double lattice = plain.mean_squares[c];
      double gain = 1;
      if (rounded && c < rounded->coding.steps.size() && rounded->coding.steps[c].step > 0) {
        const double step = rounded->coding.steps[c].step;
        gain = std::clamp((rounded->mean_squares[c] - lattice) * kEvenSpread / (step * step), 0.05, 4.0);
      }
      wanted.push_back(std::sqrt(kEvenSpread * std::max(0.0, allowed - lattice) / gain));
    }
    return whole_steps(wanted, series_, settings_, scans_);
  }

  // Corrections mend single samples: without them the field keeps within half of the largest error.
  [[nodiscard]] bool lattice_is_near(const CodingTrial& plain) const {
    return bound_.abs == 0 || std::all_of(plain.mean_squares.begin(), plain.mean_squares.end(),
                                          [&](double m) { return m <= bound_.abs * bound_.abs / 4; });
  }

  // The best that a shape gives: its bytes, and whether the lattice alone is near enough.
  struct Outcome {
    uint64_t bytes = UINT64_MAX;
    bool near = false;
  };
  void take(size_t trial, Outcome& outcome) const {
    const CodingTrial& t = trier_.tried()[trial];
    if (holds(t)) outcome.bytes = std::min(outcome.bytes, t.bytes);
  }
  Outcome consider(const LatticeShape& shape) {
    Outcome outcome;
    const size_t exact = try_coding({shape, {}, 0});
    const CodingTrial plain = trier_.tried()[exact];
    if (!most_exact_ || plain.psnr > trier_.tried()[*most_exact_].psnr) most_exact_ = exact;
    outcome.near = bound_.abs > 0 ? lattice_is_near(plain) : holds(plain);
    if (!outcome.near) return outcome;
    if (bound_.abs > 0) {
      correct(plain, outcome);
    } else {
      take(exact, outcome);
      round_to_goal(plain, outcome);
    }
    return outcome;
  }
  void correct(const CodingTrial& plain, Outcome& outcome) {
    take(try_coding({plain.coding.shape, {}, bound_.abs}), outcome);
    const auto round_by = [&](double peak) {
      const Coding rounded{plain.coding.shape, steps_of(plain, nullptr, peak), bound_.abs};
      if (!rounded.steps.empty()) take(try_coding(rounded), outcome);
    };
    if (plain.max_abs < kNoError * bound_.abs) return round_by(kRoundingPeak);
    for (const double peak : kPeaks) round_by(peak);
  }
  // Steps for the PSNR: what rounding added is known better from trial to trial.
  void round_to_goal(const CodingTrial& plain, Outcome& outcome) {
    std::optional<CodingTrial> last;
    for (int i = 0; i < kRoundings; ++i) {
      const Coding next{plain.coding.shape, steps_of(plain, last ? &*last : nullptr, kPeaks[0]), 0};
      if (next.steps.empty() || (last && last->coding == next)) return;
      const size_t trial = try_coding(next);
      take(trial, outcome);
      last = trier_.tried()[trial];
      if (holds(*last) && last->psnr < bound_.psnr + kPsnrReserve + kClose) return;
    }
  }

  // The density at which the spectrum predicts the share of the lattice, of shapes like one of density 1/2.
  [[nodiscard]] double first_density(const LatticeShape& half, const Spectrum& spectrum) const {
    const double goal = kLatticeShare * allowed_part();
    double density = kMostDensity;
    for (double d = kMostDensity; d > kLeastDensity; d /= kDenser) {
      const LatticeShape shape = scaled_shape(half, 0.5 / d, series_.dims);
      if (predicted_error(spectrum, shape, series_.dims) > goal) break;
      density = d;
    }
    return density;
  }
  [[nodiscard]] const CodingTrial& plain_trial(const LatticeShape& shape) {
    return trier_.tried()[trier_.try_coding({shape, {}, 0})];
  }
  // Does the lattice leave most of what is allowed to rounding?
  [[nodiscard]] bool leaves_most(const CodingTrial& plain) const {
    for (size_t c = 0; c < scans_.size(); ++c)
      if (plain.mean_squares[c] > kLatticeShare * std::pow(allowed_root(c, kPeaks[0]), 2)) return false;
    return true;
  }
  [[nodiscard]] double merit_of(const LatticeShape& shape) {
    return merit(plain_trial(shape).psnr, shape, series_.dims, 1);
  }
  // Returns a shape that fits what is done beyond the ends.
  [[nodiscard]] LatticeShape fitted(int32_t lattice, double density, Beyond beyond) {
    const auto [found, is_new] = fitted_.try_emplace({lattice, density, beyond});
    if (is_new) {
      LatticeShape& shape = found->second;
      shape = fit_lattice(spectra_.of(beyond), lattice, density, series_.dims, trier_.watch());
      shape.faces = settings_.faces, shape.ends = settings_.ends, shape.periodic = settings_.periodic;
      shape = with_beyond(shape, beyond);
    }
    return found->second;
  }
  struct Start {
    double density = 0;
    Beyond beyond = Beyond::plain;
    uint64_t bytes = 0; // of the sample, UINT64_MAX if it does not keep the bound
    double merit = 0;
    [[nodiscard]] bool operator<(const Start& other) const {
      return bytes != other.bytes ? bytes < other.bytes : merit > other.merit;
    }
  };
  // The density that the spectrum predicts, and lower as long as the sample, which knows better, allows.
  Start start_of(int32_t lattice, Beyond beyond) {
    double density = first_density(fitted(lattice, 0.5, beyond), spectra_.of(beyond));
    while (density / kDenser > kLeastDensity &&
           leaves_most(plain_trial(fitted(lattice, density / kDenser, beyond))))
      density /= kDenser;
    const LatticeShape shape = fitted(lattice, density, beyond);
    return {density, beyond, consider(shape).bytes, merit_of(shape)};
  }
  Start best_start(int32_t lattice) {
    Start best = start_of(lattice, Beyond::plain);
    for (const Beyond beyond : {Beyond::faces, Beyond::all}) {
      if (fitted(lattice, 0.5, beyond) == fitted(lattice, 0.5, Beyond::plain)) continue; // as given
      best = std::min(best, start_of(lattice, beyond));
    }
    return best;
  }
  void search_lattices() {
    double least = HUGE_VAL; // bytes of a coding that holds
    for (const int32_t lattice : lattices()) {
      const Start start = best_start(lattice);
      if (start.bytes == UINT64_MAX || static_cast<double>(start.bytes) <= kHopelessBytes * least)
        search_densities(lattice, start);
      if (best_ && holds(trier_.tried()[*best_])) least = static_cast<double>(trier_.tried()[*best_].bytes);
    }
  }
  // Denser and denser until it takes more bytes, then the other way if there was nothing to gain.
  void search_densities(int32_t lattice, const Start& start) {
    const double first = start.density;
    const auto at = [&](double density) { return consider(fitted(lattice, density, start.beyond)); };
    const Outcome outcome = at(first);
    uint64_t least = outcome.bytes;
    for (double d = first * kDenser; d < kMostDensity; d *= kDenser) {
      const uint64_t bytes = at(d).bytes;
      if (bytes >= least && least != UINT64_MAX) break;
      least = std::min(least, bytes);
    }
    if (!outcome.near || least < outcome.bytes) return;
    for (double d = first / kDenser; d > kLeastDensity; d /= kDenser) {
      const uint64_t bytes = at(d).bytes;
      if (bytes >= least) break;
      least = bytes;
    }
  }
  // The last resort for a PSNR.
  void correct_what_misses() {
    if (bound_.psnr == 0) return;
    Coding c = trier_.tried()[*best_].coding;
    c.abs_error = kCorrectedPeak * peak_of(scans_) * std::pow(10, -bound_.psnr / 20);
    const size_t i = trier_.try_coding(c);
    if (better(i, *best_)) best_ = i;
  }

  Trier& trier_;
  const Spectra& spectra_;
  const SeriesDescription& series_;
  const WriterSettings& settings_;
  const ErrorBound& bound_;
  const std::vector<ChannelScan>& scans_;
  std::optional<size_t> best_, most_exact_;
  std::map<std::tuple<int32_t, double, Beyond>, LatticeShape> fitted_;
};

} // namespace

bool has_distances(const WriterSettings& s) {
  return s.scale > 0 || s.time_scale > 0 ||
         std::any_of(s.scales.begin(), s.scales.end(), [](double d) { return d > 0; });
}

CodingSearch search_coding(Trier& trier, const Spectra& spectra, const SeriesDescription& series,
                           const WriterSettings& settings, const ErrorBound& bound,
                           const std::vector<ChannelScan>& scans) {
  BoundSearch run(trier, spectra, series, settings, bound, scans);
  run.run();
  CodingSearch search;
  search.best = run.best();
  search.tried = trier.tried();
  for (CodingTrial& t : search.tried) t.holds = run.holds(t) && (bound.abs == 0 || t.coding.abs_error > 0);
  return search;
}

double prove_time_scale(Trier& trier, const Spectrum& spectrum, const SeriesDescription& series,
                        const WriterSettings& settings) {
  LatticeShape shape = shape_of(settings, series);
  const auto predicted = [&](double x) {
    shape.scales[3] = x;
    return -10 * std::log10(std::max(1e-30, predicted_error(spectrum, shape, series.dims)));
  };
  const auto psnr = [&](double x) {
    shape.scales[3] = x;
    return trier.tried()[trier.try_coding({shape, {}, 0})].psnr;
  };
  const double hoped = std::min(kGoodPsnr, predicted(1) - kLostPsnr) - kLostPsnr;
  double enough = 0;
  for (const double x : kTimeScales) {
    if ((static_cast<double>(series.dims[3]) - 1) / x < kFewestSteps || predicted(x) < hoped) continue;
    if (enough == 0) enough = std::min(kGoodPsnr, psnr(1) - kLostPsnr);
    if (psnr(x) >= enough) return x;
  }
  return 1;
}

} // namespace bccsplat::series

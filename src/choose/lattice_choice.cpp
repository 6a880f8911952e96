// SPDX-License-Identifier: Apache-2.0
// Makes candidates of about the density wished for, cubic and fitted, in each way to go on beyond the ends,
// and tries the most promising first: one that cannot beat the best tried by more than forecasts err is left
// out.
#include "choose/lattice_choice.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "series/text.h"

namespace bccsplat::series {
namespace {

// dB that a forecast may be too low; by Beyond: what is predicted beyond the ends of time does better than a
// spectrum that fades out there says.
constexpr std::array kTooLow{4.0, 4.0, 8.0};
constexpr double kGain = 0.25; // dB that prediction has to gain to be worth its trouble
// Rounding may add this share of the lattice's error power. An even spread of width q has the power q^2 / 12.
constexpr double kRoundingShare = 1.0 / 15, kCoarsestRounding = 1.0 / 512;
constexpr double kSpread = 12;
constexpr double kMostSites = 1.25;    // of those wished for
constexpr int kOutsideSteps = 3;       // to the density at which all sites are as many as wished for
constexpr double kSameDensity = 0.005; // in parts: a shape fits it, too

double decibels(double mean_square) { return mean_square > 0 ? -10 * std::log10(mean_square) : HUGE_VAL; }

// Keeps every second frame, or as many as the density leaves.
LatticeShape fewer_frames(double density) {
  return {BCCSPLAT_LATTICE_CC, {1, 1, 1, std::max(1.0, std::round(1 / density))}};
}

// dB by which a candidate must be better than one that is mirrored and has as many sites as wished for. Fewer
// are half as much of a merit as more are a fault: noise loses little with them.
double handicap(const LatticeCandidate& c, double density, const SeriesDescription& s) {
  const double more = -merit(0, c.shape, s.dims, density);
  return (more > 0 ? more : more / 2) + (c.beyond == Beyond::plain ? 0 : kGain);
}

// The widest step that a channel is worth.
double widest_step(double mean_square, double range) {
  return std::min(std::sqrt(kSpread * kRoundingShare * mean_square),
                  std::sqrt(kSpread) * kCoarsestRounding * range);
}

// The shapes worth a thought, the simplest of each lattice first.
std::vector<LatticeCandidate> find_candidates(const Spectra& spectra, const LatticeWish& wish,
                                              const SeriesDescription& series, Watch& watch) {
  std::vector<LatticeCandidate> found;
  const auto add = [&](const std::string& name, const LatticeShape& shape, Beyond beyond) {
    for (const LatticeCandidate& c : found)
      if (c.shape == shape) return;
    found.push_back(
        {name, shape, beyond, decibels(predicted_error(spectra.of(beyond), shape, series.dims)), {}});
  };
  // Adds a shape in each distinct way to go on beyond the ends, sites outside being sites.
  const auto add_all = [&](const std::string& name, const auto& shape_of) {
    constexpr std::array<const char*, 3> names{"", ", faces predicted", ", ends predicted"};
    std::vector<LatticeShape> others;
    for (const Beyond beyond : kBeyond) {
      LatticeShape shape;
      double density = wish.density, fitted = 0;
      for (int i = 0; i < kOutsideSteps && std::fabs(density / fitted - 1) > kSameDensity; ++i) {
        shape = shape_of(spectra.of(beyond), fitted = density);
        shape.faces = wish.faces, shape.ends = wish.ends, shape.periodic = wish.periodic;
        shape = with_beyond(shape, beyond);
        density = std::max(wish.density / 2, wish.density / (1 + outside_share(shape, series.dims)));
      }
      if (std::any_of(others.begin(), others.end(),
                      [&](const LatticeShape& o) { return goes_on_alike(o, shape, series.dims); }))
        continue;
      if (beyond != Beyond::plain && whole_density(shape, series.dims) > kMostSites * wish.density) continue;
      others.push_back(shape);
      add(concat(name, names[static_cast<size_t>(beyond)]), shape, beyond);
    }
  };
  if (wish.fixed) {
    add("as given", *wish.fixed, Beyond::plain);
    return found;
  }
  for (const int32_t lattice : wish.lattices) {
    const char* const name = lattice_name(lattice);
    if (lattice != BCCSPLAT_LATTICE_CC || series.dims[3] == 1)
      add_all(concat(name, ", cubic"),
              [&](const Spectrum&, double density) { return cubic_lattice(lattice, density, series.dims); });
    else
      add_all("fewer frames", [&](const Spectrum&, double density) { return fewer_frames(density); });
    add_all(name, [&](const Spectrum& spectrum, double density) {
      return fit_lattice(spectrum, lattice, density, series.dims, watch);
    });
  }
  return found;
}

// The first one, which others are compared with in reports, and then the others, those that may be best
// first.
template<class Worth>
std::vector<size_t> by_promise(const std::vector<LatticeCandidate>& candidates, const Worth& worth) {
  std::vector<size_t> order;
  for (size_t i = 0; i < candidates.size(); ++i) order.push_back(i);
  std::stable_sort(order.begin() + 1, order.end(), [&](size_t a, size_t b) {
    return worth(candidates[a].predicted, candidates[a]) > worth(candidates[b].predicted, candidates[b]);
  });
  return order;
}

} // namespace

LatticeChoice choose_lattice(Trier& trier, const Spectra& spectra, const LatticeWish& wish,
                             const SeriesDescription& series) {
  LatticeChoice choice;
  choice.labels = wish.labels;
  choice.half_the_frames = trier.half_the_frames();
  choice.candidates = find_candidates(spectra, wish, series, trier.watch());
  const auto worth = [&](double psnr, const LatticeCandidate& c) {
    return psnr - handicap(c, wish.density, series);
  };
  double best = -HUGE_VAL;
  for (const size_t i : by_promise(choice.candidates, worth)) {
    LatticeCandidate& c = choice.candidates[i];
    if (worth(c.predicted, c) + kTooLow[static_cast<size_t>(c.beyond)] < best) continue;
    const double least = i == 0 ? -HUGE_VAL : best + handicap(c, wish.density, series);
    const std::optional<size_t> trial = trier.try_above({c.shape, {}, 0}, least);
    if (!trial) continue;
    c.trial = trier.tried()[*trial];
    if (worth(c.trial->psnr, c) > best) best = worth(c.trial->psnr, c), choice.best = i;
  }
  return choice;
}

std::vector<StepCoding> worthwhile_steps(const CodingTrial& trial, const SeriesDescription& series,
                                         const WriterSettings& settings,
                                         const std::vector<ChannelScan>& ranges,
                                         const std::vector<bool>& labels) {
  std::vector<double> widest;
  for (size_t c = 0; c < series.channels.size(); ++c)
    widest.push_back(ranges[c].empty() || labels[c]
                         ? 0
                         : widest_step(trial.mean_squares[c], ranges[c].max - ranges[c].min));
  return whole_steps(widest, series, settings, ranges);
}

} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
// Chooses what a tile is coded with, and its steps. Coefficients are nearly orthonormal, so that errors are
// told from them alone.
#include "formats/bcc4/encode/choose_tile.h"

#include <bit>
#include <cmath>

#include "formats/bcc4/encode/principal_basis.h"
#include "formats/bcc4/encode/row_sums.h"
#include "formats/bcc4/wavelet/step_walk.h"

namespace bccsplat {
namespace {

struct Counting {
  const TileBands& bands;
  BitCosts& costs;
  bool row(const WalkRow& r, uint32_t expected) {
    const size_t n = r.box.size[0];
    if (expected > 0 || any_of({bands.steps.data() + place_of(bands.shape, r), n})) return true;
    costs.count(group_of(r.box), 0, 0, static_cast<uint32_t>(n));
    return false;
  }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    const int magnitude = std::abs(bands.steps[place_of(bands.shape, r) + x]);
    costs.count(group_of(r.box), s.sum, magnitude);
    return context_of(magnitude);
  }
};

struct Weighing {
  TileBands& bands;
  const TileRule& rule;
  StepErrors errors{};
  bool row(const WalkRow& r, uint32_t) {
    constexpr float least = .5F;
    const size_t first = place_of(bands.shape, r), n = r.box.size[0];
    const float* const c = bands.coefficients.data() + first;
    const float squares = sum_products<float>(c, c, n), most = rule.steps.step * least;
    if (squares > most * most && largest_magnitude({c, n}) > most) return true;
    std::fill_n(bands.steps.data() + first, n, 0);
    errors.left_out += squares;
    return false;
  }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    constexpr float bit_worth = .11F; // squared steps
    const size_t i = place_of(bands.shape, r) + x;
    const float wanted = std::fabs(bands.coefficients[i]) / rule.steps.step;
    const int top = static_cast<int>(std::lround(wanted)), level = group_of(r.box);
    int best = 0;
    float least = INFINITY;
    for (const int m : {top, top - 1, 0}) {
      if (m < 0) continue;
      const float off = wanted - static_cast<float>(m),
                  cost = off * off + bit_worth * rule.costs.bits(level, s.sum, m);
      if (cost < least) least = cost, best = m;
      if (m == 0) break;
    }
    bands.steps[i] = bands.coefficients[i] < 0 ? -best : best;
    errors.add(bands.coefficients[i], wanted, best);
    return context_of(best);
  }
};

// The bits of the layers of a basis, by their variances alone.
double rough_bits(std::span<const double> variances, double samples, double step) {
  constexpr double of_rounding = 12;
  double bits = 0;
  for (const double v : variances) bits += samples / 2 * std::log2(1 + of_rounding * v / (step * step));
  return bits;
}

// Cosines, or the principal components where these save more than they take.
bool takes_components(const TileBox& box, const FrameProducts& products, float step, const TimeBasis& own) {
  constexpr double bits_of_weight = 16, least_saved = 1.05;
  if (box.layers < 2) return false;
  const auto samples = static_cast<double>(box.layer_sites());
  const double cosines = rough_bits(variances_in(cosine_basis(box.layers), products), samples, step),
               components = rough_bits(variances_in(own, products), samples, step) +
                            bits_of_weight * box.layers * box.layers;
  return components * least_saved < cosines;
}

// Values by the mean of what rounded to them.
void learn_centres(const StepErrors& errors, StepRule& rule) {
  for (size_t i = 0; i < 2; ++i) {
    const StepErrors::Group& g = errors.groups[i];
    const double off = g.count > 0 ? g.sum / g.count * centre_unit : 0;
    rule.centres[i] = static_cast<uint8_t>(std::clamp<long>(std::lround(off) + centre_middle, 0, UINT8_MAX));
  }
}

// A step whose plain rounding, with a dead zone, makes that error.
float first_step(std::span<const TileBands> bands, double mean_square) {
  constexpr double dead = .66;
  constexpr int rounds = 24;
  constexpr size_t every = 17;
  double low = std::sqrt(mean_square), high = low * 64;
  for (int i = 0; i < rounds; ++i) {
    const double step = std::sqrt(low * high);
    double sum = 0, count = 0;
    for (const TileBands& b : bands)
      for (size_t j = 0; j < b.coefficients.size(); j += every) {
        const double v = std::fabs(b.coefficients[j]) / step, e = v < dead ? v : v - std::floor(v + .5);
        sum += e * e, ++count;
      }
    (sum < mean_square / (step * step) * count ? low : high) = step;
  }
  return static_cast<float>(low);
}

void round_steps(TileBands& b, float step) {
  constexpr float down = .38F;
  b.steps.resize(b.coefficients.size());
  for (size_t i = 0; i < b.steps.size(); ++i) {
    const int m = static_cast<int>(std::fabs(b.coefficients[i]) / step + down);
    b.steps[i] = b.coefficients[i] < 0 ? -m : m;
  }
}

// How many times larger the squares of samples are than those of their coefficients' errors: the wavelets are
// not orthogonal, and of what is left out they make up to half as much again.
double gain_of(std::span<const TileBands> bands, const StepRule& rule) {
  double of_samples = 0, of_coefficients = 0;
  for (const TileBands& b : bands) {
    const size_t layer = b.shape.samples();
    std::vector<float> off(layer);
    for (size_t first = 0; first < b.coefficients.size(); first += layer) {
      for (size_t i = 0; i < layer; ++i)
        off[i] = b.coefficients[first + i] - value_of(b.steps[first + i], rule);
      of_coefficients += sum_products<double>(off.data(), off.data(), layer);
      synthesise(b.shape, off);
      of_samples += sum_products<double>(off.data(), off.data(), layer);
    }
  }
  return of_coefficients > 0 ? of_samples / of_coefficients : 1;
}

void count_bits_of(std::span<const TileBands> bands, BitCosts& costs, WalkRoom& room) {
  for (const TileBands& b : bands) {
    if (b.steps.empty()) continue;
    BandWalk walk(b.shape, b.basis.frames, room);
    Counting visit{b, costs};
    walk.run(visit);
  }
  costs.settle();
}

double sites_of(std::span<const TileBox> boxes) {
  double sites = 0;
  for (const TileBox& b : boxes) sites += static_cast<double>(b.sites());
  return sites;
}

// Adds bits by the sizes of coefficients.
void add_size(std::span<const float> coefficients, float step, double& bits) {
  constexpr size_t every = 7;
  for (size_t i = 0; i < coefficients.size(); i += every) {
    const double v = coefficients[i] / step;
    bits += std::log2(1 + v * v) / 2;
  }
}

// Numbers to layers of a basis of time, which are not halved yet.
TileBands analyse_time(const TileBox& box, std::vector<float> values, float step) {
  constexpr float seen_rounded = 1 << 10; // steps of a value from which it is seen that bases are rounded
  TileBands b;
  const FrameProducts products(values, box.layers);
  TimeBasis own = principal_basis(products);
  b.own_basis = takes_components(box, products, step, own);
  b.basis = b.own_basis ? std::move(own) : cosine_basis(box.layers);
  b.coefficients = std::move(values);
  to_layers(b.basis, b.coefficients, largest_magnitude(b.coefficients) > seen_rounded * step);
  return b;
}

// Halves each of these layers.
void analyse_space(const TileBox& box, int along_z, TileBands& b) {
  b.shape = halved(box.size, {most_halved, most_halved, along_z});
  for (int k = 0; k < box.layers; ++k)
    analyse(b.shape, std::span(b.coefficients).subspan(k * box.layer_sites(), box.layer_sites()));
}

// The bands of all boxes, and how often z is halved: slices may lie farther apart than their samples. Fewer
// halvings are tried until they take more bits, of one box after the other, so that no more than one is there
// twice.
std::vector<TileBands> analyse_best(std::span<const TileBox> boxes, std::vector<std::vector<float>> values,
                                    float step, int& along_z) {
  int most = 0;
  std::vector<TileBands> bands;
  for (size_t i = 0; i < boxes.size(); ++i) {
    most = std::max(most, most_halvings(boxes[i].size[2]));
    bands.push_back(analyse_time(boxes[i], std::move(values[i]), step));
  }
  double fewest = INFINITY;
  for (int z = most; z >= 0; --z) {
    double bits = 0;
    for (size_t i = 0; i < boxes.size(); ++i) {
      TileBands tried = bands[i];
      analyse_space(boxes[i], z, tried);
      add_size(tried.coefficients, step, bits);
    }
    if (bits >= fewest) break;
    fewest = bits, along_z = z;
  }
  for (size_t i = 0; i < boxes.size(); ++i) analyse_space(boxes[i], along_z, bands[i]);
  return bands;
}

// Halves the layers of a box no more than that along each axis.
void halve_less(TileBands& b, int most) {
  const Halvings was = b.shape;
  for (int& t : b.shape.times) t = std::min(t, most);
  const size_t layer = was.samples();
  for (size_t first = 0; first < b.coefficients.size(); first += layer) {
    const auto frame = std::span(b.coefficients).subspan(first, layer);
    synthesise(was, frame);
    analyse(b.shape, frame);
  }
}

} // namespace

bool fit_into_steps(std::span<TileBands> bands, StepRule& rule) {
  for (bool less = false;; less = true) {
    float largest = 0;
    int most = 0;
    for (const TileBands& b : bands) {
      if (b.coefficients.empty()) continue;
      largest = std::max(largest, largest_magnitude(b.coefficients)), most = std::max(most, b.shape.levels());
    }
    if (largest > most_steps * rule.step && most == 0) rule.step = largest / most_steps;
    if (largest <= most_steps * rule.step) return less;
    for (TileBands& b : bands)
      if (!b.coefficients.empty()) halve_less(b, most - 1);
  }
}

TileBands analyse_tile(const TileBox& box, std::vector<float> values, float step, int halvings_along_z) {
  if (values.empty()) return {};
  TileBands b = analyse_time(box, std::move(values), step);
  analyse_space(box, halvings_along_z, b);
  return b;
}

double StepErrors::squares(const StepRule& rule) const {
  double of_steps = 0;
  for (size_t i = 0; i < 2; ++i) {
    const double off = (rule.centres[i] - centre_middle) / double{centre_unit};
    of_steps += groups[i].squares - 2 * off * groups[i].sum + off * off * groups[i].count;
  }
  return left_out + double{rule.step} * rule.step * of_steps;
}

StepErrors choose_steps(TileBands& bands, const TileRule& rule, WalkRoom& room) {
  if (bands.coefficients.empty()) return {};
  bands.steps.resize(bands.coefficients.size());
  BandWalk walk(bands.shape, bands.basis.frames, room);
  Weighing visit{bands, rule};
  walk.run(visit);
  return visit.errors;
}

TileRule find_tile_rule(std::span<const TileBox> boxes, std::vector<std::vector<float>> values,
                        double mean_square) {
  constexpr double squares_of_step = 12, slope = .62, near_enough = .02, coarsest = 64;
  constexpr double wider = 4; // than steps of that error, where most is left out
  constexpr int rounds = 6;
  TileRule rule;
  WalkRoom room;
  const auto hint = static_cast<float>(wider * std::sqrt(mean_square * squares_of_step));
  std::vector<TileBands> bands = analyse_best(boxes, std::move(values), hint, rule.halvings_along_z);
  rule.steps.step = first_step(bands, mean_square);
  double goal = mean_square * sites_of(boxes);
  for (int i = 0; i < rounds; ++i) {
    if (fit_into_steps(bands, rule.steps) || i == 0)
      for (TileBands& b : bands) round_steps(b, rule.steps.step);
    count_bits_of(bands, rule.costs, room);
    StepErrors errors;
    for (TileBands& b : bands) errors.add(choose_steps(b, rule, room));
    learn_centres(errors, rule.steps);
    const double error = errors.squares(rule.steps);
    if (i == 0) goal /= gain_of(bands, rule.steps);
    if (i > 0 && std::fabs(error / goal - 1) < near_enough) break;
    // The step is bounded: a slab that is next to empty errs less than it may with any.
    if (error > 0 && i + 1 < rounds)
      rule.steps.step = static_cast<float>(
          std::min({rule.steps.step * std::pow(goal / error, slope), coarsest * hint, double{largest_step}}));
  }
  return rule;
}

} // namespace bccsplat

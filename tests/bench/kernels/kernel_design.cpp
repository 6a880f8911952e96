// SPDX-License-Identifier: Apache-2.0
// Descends from random starts by Levenberg-Marquardt on the weights of all stages, the error of waves of four
// balls and bounds on the response together; of designs that are equally good it takes the one that rounding
// hurts least.
#include "tests/bench/kernels/kernel_design.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "kernel/wave_error.h"

namespace bccsplat::bench {
namespace {

using Parameters = std::vector<double>;

// Per stage: weights of 1 - mean of S, T, ST, X of the coefficients (their own weight being 1), then of 1,
// and of 1 - mean of S, T, ST of the samples. A constant passes with the sum of ones and sources; the whole
// is divided by it.
constexpr size_t stage_parameters = 8;
constexpr size_t max_stages = 8;
enum Parameter : size_t { own_s, own_t, own_st, own_x, source_1, source_s, source_t, source_st };

struct Model {
  size_t stages = 0;
  std::vector<bool> free; // of all parameters

  explicit Model(const DesignGoal& goal)
      : stages(goal.pattern.size()), free(stages * stage_parameters, false) {
    const bool temporal = goal.dimensions == 4;
    for (size_t j = 0; j < stages; ++j) {
      const auto set = [&](size_t p, bool value) { free[j * stage_parameters + p] = value; };
      const char letter = goal.pattern[j];
      const bool full = letter == 'f' || letter == 'a' || j == 0;
      const bool mixed = temporal && letter != 'n';
      set(own_s, full), set(own_t, full && temporal), set(own_st, full && mixed), set(own_x, true);
      if (j == 0 || letter == 'a') continue;
      set(source_1, true), set(source_s, true), set(source_t, temporal), set(source_st, mixed);
    }
  }

  // The response of the whole at a frequency, and its derivatives by all parameters (0 for those not free).
  double response(const Parameters& p, const NeighbourMeans& means, Parameters* gradient) const {
    const double s = 1 - means.spatial, t = 1 - means.temporal, x = 1 - means.cross;
    const double st = 1 - means.spatial * means.temporal;
    std::array<double, max_stages + 1> q{}, constant{}, pass{};
    q[0] = constant[0] = 1;
    for (size_t j = 0; j < stages; ++j) {
      const double* a = &p[j * stage_parameters];
      pass[j] = 1 + a[own_s] * s + a[own_t] * t + a[own_st] * st + a[own_x] * x;
      q[j + 1] = pass[j] * q[j] + a[source_1] + a[source_s] * s + a[source_t] * t + a[source_st] * st;
      constant[j + 1] = constant[j] + a[source_1];
    }
    const double scale = 1 / constant[stages];
    const double whole = q[stages] * scale;
    if (gradient == nullptr) return whole;
    double after = scale; // d whole / d q[j + 1]
    for (size_t j = stages; j-- > 0;) {
      double* g = &(*gradient)[j * stage_parameters];
      g[own_s] = after * q[j] * s, g[own_t] = after * q[j] * t;
      g[own_st] = after * q[j] * st, g[own_x] = after * q[j] * x;
      g[source_1] = after - whole * scale;
      g[source_s] = after * s, g[source_t] = after * t, g[source_st] = after * st;
      after *= pass[j];
    }
    for (size_t i = 0; i < free.size(); ++i)
      if (!free[i]) (*gradient)[i] = 0;
    return whole;
  }
};

struct DesignProblem {
  DesignGoal goal;
  std::vector<std::vector<WaveSample>> balls;
  std::vector<WaveSample> all;
};

constexpr double bound_weight = 300; // dB per mean square excess of the bounds
constexpr double site_weight = 0.5;  // dB per mean square deviation of the response at the sites from 1

double excess(const DesignGoal& goal, double at_sites) {
  return std::max(at_sites - goal.highest, 0.0) + std::min(at_sites - goal.lowest, 0.0);
}

double objective(const DesignProblem& problem, const Model& model, const Parameters& p, Parameters& errors) {
  double sum = 0;
  for (size_t b = 0; b < problem.balls.size(); ++b) {
    errors[b] = 0;
    for (const WaveSample& w : problem.balls[b])
      errors[b] += wave_error(w, model.response(p, w.means, nullptr));
    errors[b] /= static_cast<double>(problem.balls[b].size());
    sum += problem.goal.weights[b] * 10 * std::log10(errors[b]);
  }
  double bounds = 0;
  for (const WaveSample& w : problem.all) {
    const double at_sites = model.response(p, w.means, nullptr) * w.symbol;
    const double e = excess(problem.goal, at_sites);
    bounds += bound_weight * e * e + site_weight * (at_sites - 1) * (at_sites - 1);
    const double q = at_sites / w.symbol;
    bounds += problem.goal.tap_weight * q * q;
  }
  return sum + bounds / static_cast<double>(problem.all.size());
}

// Solves a x = b in place for a symmetric positive definite a (lower triangle given); false if it is not.
bool solve_symmetric(std::vector<Parameters>& a, Parameters& b) {
  const size_t n = b.size();
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j <= i; ++j) {
      double s = a[i][j];
      for (size_t k = 0; k < j; ++k) s -= a[i][k] * a[j][k];
      if (i == j && !(s > 0)) return false;
      a[i][j] = i == j ? std::sqrt(s) : s / a[j][j];
    }
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < n; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
  return true;
}

// Levenberg-Marquardt on the squares of Q - Q_best, weighted by 1 / error of their ball: at the optimum of
// the weighted squares with converged weights the mean of the logarithms is stationary too.
double minimise(const DesignProblem& problem, const Model& model, Parameters& p, int steps) {
  std::vector<size_t> free;
  for (size_t i = 0; i < p.size(); ++i)
    if (model.free[i]) free.push_back(i);
  const size_t n = free.size();
  Parameters errors(problem.balls.size()), gradient(p.size());
  double best = objective(problem, model, p, errors);
  double damping = 1e-2;
  for (int step = 0, stalled = 0; step < steps && stalled < 8; ++step) {
    std::vector<Parameters> normal(n, Parameters(n, 0.0));
    Parameters right(n, 0.0);
    const auto add = [&](double weight, double residual) {
      for (size_t i = 0; i < n; ++i) {
        const double g = weight * gradient[free[i]];
        right[i] -= g * residual;
        for (size_t j = 0; j <= i; ++j) normal[i][j] += g * gradient[free[j]];
      }
    };
    for (size_t b = 0; b < problem.balls.size(); ++b) {
      const double weight = 10 / std::log(10.0) * problem.goal.weights[b] /
                            (errors[b] * static_cast<double>(problem.balls[b].size()));
      for (const WaveSample& w : problem.balls[b]) {
        const double q = model.response(p, w.means, &gradient);
        const double curvature = w.pass * w.pass + w.alias2;
        add(weight * curvature, q - w.pass / curvature);
      }
    }
    for (const WaveSample& w : problem.all) {
      const double q = model.response(p, w.means, &gradient);
      const double weight = w.symbol * w.symbol / static_cast<double>(problem.all.size());
      add(weight * site_weight, q - 1 / w.symbol);
      add(problem.goal.tap_weight / static_cast<double>(problem.all.size()), q);
      if (const double e = excess(problem.goal, q * w.symbol); e != 0)
        add(weight * bound_weight, e / w.symbol);
    }
    bool better = false;
    for (int attempt = 0; attempt < 8 && !better; ++attempt) {
      std::vector<Parameters> damped = normal;
      for (size_t i = 0; i < n; ++i) damped[i][i] += damping * normal[i][i] + 1e-12;
      Parameters change = right;
      if (solve_symmetric(damped, change)) {
        Parameters next = p, next_errors(errors.size());
        for (size_t i = 0; i < n; ++i) next[free[i]] += change[i];
        const double value = objective(problem, model, next, next_errors);
        if (std::isfinite(value) && value < best) {
          stalled = best - value < 1e-5 ? stalled + 1 : 0;
          best = value, p = std::move(next), errors = std::move(next_errors);
          damping = std::max(0.3 * damping, 1e-12);
          better = true;
        }
      }
      if (!better) damping *= 4;
    }
    if (!better) break;
  }
  return best;
}

// The model's parameters as stages; every intermediate result is scaled to a largest response of 1 (all
// waves), the last to pass a constant unchanged.
std::vector<PrefilterStage> to_stages(const DesignProblem& problem, const Model& model, const Parameters& p) {
  const int cross_neighbours = problem.goal.dimensions == 4 ? 16 : 8;
  std::vector<PrefilterStage> stages;
  double scale_before = 1;
  double constant = 1;
  for (size_t j = 0; j < model.stages; ++j) {
    const double* a = &p[j * stage_parameters];
    PrefilterStage s;
    s.self = 1 + a[own_s] + a[own_t] + a[own_st] + a[own_x];
    s.spatial = -a[own_s] / 6, s.temporal = -a[own_t] / 2, s.mixed = -a[own_st] / 12;
    s.cross = -a[own_x] / cross_neighbours;
    s.source = a[source_1] + a[source_s] + a[source_t] + a[source_st];
    s.source_spatial = -a[source_s] / 6, s.source_temporal = -a[source_t] / 2;
    s.source_mixed = -a[source_st] / 12;
    constant += a[source_1];
    for (double* w : {&s.self, &s.spatial, &s.temporal, &s.mixed, &s.cross}) *w /= scale_before;
    stages.push_back(s);
    double largest = 0;
    for (const WaveSample& w : problem.all)
      largest = std::max(largest, std::abs(prefilter_symbol(stages, w.means, cross_neighbours)));
    const double scale = j + 1 == model.stages ? 1 / constant : std::copysign(1 / largest, constant);
    PrefilterStage& last = stages.back();
    for (double* w : {&last.self, &last.spatial, &last.temporal, &last.mixed, &last.cross, &last.source,
                      &last.source_spatial, &last.source_temporal, &last.source_mixed})
      *w *= scale;
    scale_before = scale;
  }
  return stages;
}

// Uniform in [-1, 1); the same on every machine.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 1) {}
  double next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) / 4503599627370496.0 - 1;
  }

 private:
  uint64_t state_;
};

} // namespace

Design design_prefilter(const Kernel& kernel, const DesignGoal& goal) {
  if (goal.pattern.empty() || goal.pattern.size() > max_stages ||
      goal.pattern.find_first_not_of("fxna") != std::string::npos)
    fail(Code::invalid_argument, "a pattern of stages is 1 to ", max_stages,
         " letters out of f, x, n and a, not '", goal.pattern, "'");
  const KernelSpectrum spectrum(kernel);
  DesignProblem problem{goal, {}, all_waves(spectrum, goal.dimensions, 1500)};
  for (const double rho : design_rhos)
    problem.balls.push_back(ball_waves(spectrum, goal.dimensions, rho, 600));
  const Model model(goal);

  Random random(goal.seed);
  // Of equally good designs (0.03 dB) the one that loses least to rounding.
  constexpr double as_good = 0.03;
  std::vector<Design> found;
  double best_value = std::numeric_limits<double>::infinity();
  for (int start = 0; start < goal.starts; ++start) {
    Parameters p(model.free.size(), 0.0);
    const double spread = start % 4 >= 2 ? 1.0 : 0.5;
    for (size_t i = 0; i < p.size(); ++i) {
      if (!model.free[i]) continue;
      p[i] = 0.5 * random.next();
      if (start % 2 == 1 && i % stage_parameters == own_x) p[i] -= 0.5;
      if (start % 2 == 1 && i % stage_parameters == source_1) p[i] += 1;
      p[i] *= 2 * spread;
    }
    // Starts far behind the best are not worth finishing.
    double value = 0;
    bool promising = true;
    for (const auto& [steps, margin] : {std::pair{20, 3.0}, std::pair{60, 0.5}}) {
      value = minimise(problem, model, p, steps);
      promising = value < best_value + margin;
      if (!promising) break;
    }
    if (!promising) continue;
    value = minimise(problem, model, p, 400);
    best_value = std::min(best_value, value);
    found.push_back({to_stages(problem, model, p), value});
  }
  const auto best = std::min_element(
      found.begin(), found.end(), [](const Design& a, const Design& b) { return a.objective < b.objective; });
  const double limit = best->objective + as_good;
  Design chosen;
  double growth = std::numeric_limits<double>::infinity();
  for (const Design& d : found) {
    const double g = rounding_growth(d.stages, goal.dimensions);
    if (d.objective > limit || g >= growth) continue;
    chosen = d, growth = g;
  }
  return chosen;
}

DesignGoal shipped_goal(std::string_view kernel_name, int dimensions) {
  // Each stage was added because it gained a dB or more at rho 0.7 or 0.9; see notes/kernels.md.
  struct Choice {
    std::string_view prefix, pattern3, pattern4;
  };
  constexpr Choice choices[] = {
      {"radial16+b2", "fxx", "fx"},   {"radial16", "fxx", "fxx"},    {"radial18", "fxx", "fxx"},
      {"radial20+b2", "fxxx", "fxx"}, {"radial20", "fxxx", "fxxx"},  {"radial24+b4", "fxxxx", "fxfxxx"},
      {"radial24", "fxxxx", "fxxxx"}, {"gauss09", "fxxxx", "fxxxx"},
  };
  for (const Choice& choice : choices) {
    if (!kernel_name.starts_with(choice.prefix)) continue;
    DesignGoal goal;
    goal.dimensions = dimensions;
    goal.pattern = dimensions == 4 ? choice.pattern4 : choice.pattern3;
    goal.tap_weight = 0.01;
    goal.starts =
        dimensions == 4 && kernel_name == "radial24+b4" ? 240 : 120; // six stages have more dead ends
    // A fine kernel is chosen for what the others blur: the upper end of the band counts more.
    if (kernel_name.starts_with("radial24")) goal.weights = {0.1, 0.2, 0.3, 0.4}, goal.tap_weight = 0.005;
    return goal;
  }
  fail(Code::not_found, "no prefilter goal for '", kernel_name, "'");
}

double rounding_growth(const std::vector<PrefilterStage>& stages, int dimensions) {
  const int cross_neighbours = dimensions == 4 ? 16 : 8;
  double worst = 0, largest = 0;
  const int planes = 13; // per axis of the box of all frequencies
  int count = 1;
  for (int a = 0; a < dimensions; ++a) count *= planes;
  for (int i = 0; i < count; ++i) {
    std::array<double, 4> xi{};
    int rest = i;
    for (size_t a = 0; a < static_cast<size_t>(dimensions); ++a, rest /= planes)
      xi[a] = rest % planes / (std::sqrt(2.0) * (planes - 1));
    const NeighbourMeans means = neighbour_means4(xi);
    double q = 1, sum = 0;
    for (const PrefilterStage& s : stages) {
      const double pass = running_symbol(s, means, cross_neighbours);
      const double next = source_symbol(s, means);
      sum = std::abs(pass) * (sum + std::abs(q)) + std::abs(next);
      q = pass * q + next;
    }
    worst = std::max(worst, sum);
    largest = std::max(largest, std::abs(q));
  }
  return worst / largest;
}

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Steps are settled in rounds: what neighbours tell is learnt from steps, then steps are weighed anew: bits
// by a table of what was seen, against squared errors.
#include "tests/bench/coder/steps.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace bccsplat::bench {
namespace {

size_t index_of(const Chain& c, const WalkRow& r, int x) {
  return ((size_t(r.k) * c.size[2] + r.box.begin[2] + r.z) * c.size[1] + r.box.begin[1] + r.y) * c.size[0] +
         r.box.begin[0] + x;
}
int group_of(const WalkRow& r) { return r.coarse ? 0 : r.box.level; }

// Walks over steps that are settled and shows each to a body.
template<class Body> struct Shown {
  const Chain& chain;
  const Slab* slab;
  Body body;
  bool row(const WalkRow&, const std::vector<uint32_t>&) { return true; }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    const int magnitude = std::abs(slab->steps[index_of(chain, r, x)]);
    body(r, x, s, magnitude);
    return static_cast<uint16_t>(std::min(magnitude, most_context));
  }
};

struct Weighing {
  const Chain& chain;
  Slab* slab;
  const BitTable& table;
  StepRule rule;
  bool row(const WalkRow& r, const std::vector<uint32_t>&) {
    const float* const c = slab->coefficients.data() + index_of(chain, r, 0);
    bool any = false;
    for (int x = 0; x < r.box.size[0]; ++x) any |= std::fabs(c[x]) > rule.step * .5;
    if (!any) std::fill_n(slab->steps.data() + index_of(chain, r, 0), r.box.size[0], 0);
    return any;
  }
  uint16_t site(const WalkRow& r, int x, const WalkSite& s) {
    const size_t i = index_of(chain, r, x);
    const float wanted = std::fabs(slab->coefficients[i]) / static_cast<float>(rule.step);
    const int bucket = bucket_of(s.sum), group = group_of(r), top = static_cast<int>(wanted + .5F);
    int best = 0;
    float least = INFINITY;
    for (const int m : {top, top - 1, 0}) {
      if (m < 0) continue;
      const float off = wanted - static_cast<float>(m), b = table.bits(group, bucket, m),
                  cost = off * off + static_cast<float>(rule.lambda) * b;
      if (cost < least) least = cost, best = m;
      if (m == 0) break;
    }
    slab->steps[i] = slab->coefficients[i] < 0 ? -best : best;
    return static_cast<uint16_t>(std::min(best, most_context));
  }
};

// Normal equations of magnitudes by the sums around them.
struct Equations {
  std::array<std::array<double, around_count + 1>, around_count> a{};
  void add(const std::array<double, around_count>& x, double y, double w) {
    for (int i = 0; i < around_count; ++i) {
      if (x[i] == 0) continue;
      for (int j = 0; j < around_count; ++j) a[i][j] += w * x[i] * x[j];
      a[i][around_count] += w * x[i] * y;
    }
  }
  // Least squares with no weight below 0: coordinate by coordinate.
  [[nodiscard]] std::array<double, around_count> solve() const {
    constexpr int sweeps = 200;
    constexpr double ridge = 1.0005;
    std::array<double, around_count> w{};
    for (int s = 0; s < sweeps; ++s)
      for (int i = 0; i < around_count; ++i) {
        if (a[i][i] <= 0) continue;
        double rest = a[i][around_count];
        for (int j = 0; j < around_count; ++j)
          if (j != i) rest -= a[i][j] * w[j];
        w[i] = std::max(0.0, rest / (a[i][i] * ridge));
      }
    return w;
  }
};

} // namespace

LevelWeights usual_weights() {
  LevelWeights w{};
  for (AroundWeights& level : w) level = {12, 4, 12, 8, 3, 4, 2, 8, 1, 4, 6, 1, 6};
  return w;
}

BitTable::BitTable() : counts_((most_levels + 1) * bucket_count), bits_(counts_.size()) {}

void BitTable::settle() {
  for (size_t i = 0; i < counts_.size(); ++i) {
    std::array<double, symbols> n{};
    double all = 0;
    for (int s = 0; s < symbols; ++s) all += n[s] = counts_[i][s] + .5 / (1 << std::min(s, 10));
    for (int s = 0; s < symbols; ++s)
      bits_[i][s] = static_cast<float>(-std::log2(n[s] / all)) + (s > 0 ? 1.0F : 0.0F);
    counts_[i] = {};
  }
}

StepPlan::StepPlan(const Chain& chain, int edge, std::vector<Slab>& slabs)
    : chain_(chain), edge_(edge), slabs_(slabs), weights_(usual_weights()) {
  for (Slab& s : slabs_) s.steps.assign(s.coefficients.size(), 0);
}

template<class Visit> void StepPlan::walk(Visit& visit) {
  for (Slab& s : slabs_) {
    visit.slab = &s;
    walk_slab(chain_, edge_, s.frames, weights_, [&](ChunkWalk& chunk) { chunk.run(visit); });
  }
}

double StepPlan::first_step(double mean_square) const {
  constexpr double dead = .66;
  double low = std::sqrt(mean_square), high = low * 64;
  for (int i = 0; i < 24; ++i) {
    const double step = std::sqrt(low * high);
    double sum = 0, count = 0;
    for (const Slab& s : slabs_)
      for (size_t j = 0; j < s.coefficients.size(); j += 17) {
        const double v = std::fabs(s.coefficients[j]) / step, e = v < dead ? v : v - std::floor(v + .5);
        sum += e * e, ++count;
      }
    (sum / count * step * step < mean_square ? low : high) = step;
  }
  return low;
}

void StepPlan::round(double step) {
  constexpr float down = .38F;
  for (Slab& s : slabs_)
    for (size_t i = 0; i < s.steps.size(); ++i) {
      const float v = s.coefficients[i] / static_cast<float>(step);
      const int m = static_cast<int>(std::fabs(v) + down);
      s.steps[i] = v < 0 ? -m : m;
    }
}

void StepPlan::learn_weights() {
  std::array<Equations, most_levels + 1> equations;
  ChunkWalk* current = nullptr;
  const auto body = [&](const WalkRow& r, int x, const WalkSite& s, int magnitude) {
    std::array<double, around_count> values{};
    for (int i = 0; i < around_count; ++i) values[i] = current->sums()[i][x];
    if (s.sum == 0 && magnitude == 0) return;
    equations[group_of(r)].add(values, std::min(magnitude, most_context),
                               1 / (.3 + s.sum / double(weight_unit)));
  };
  Shown<decltype(body)> visit{chain_, nullptr, body};
  for (Slab& s : slabs_) {
    visit.slab = &s;
    walk_slab(chain_, edge_, s.frames, weights_, [&](ChunkWalk& chunk) {
      current = &chunk;
      chunk.run(visit);
    });
  }
  for (int l = 0; l <= most_levels; ++l) {
    const auto w = equations[l].solve();
    for (int i = 0; i < around_count; ++i)
      weights_[l][i] = static_cast<uint8_t>(std::clamp(std::lround(w[i] * weight_unit), 0L, 255L));
  }
}

void StepPlan::learn_bits() {
  const auto body = [&](const WalkRow& r, int, const WalkSite& s, int m) {
    table_.count(group_of(r), bucket_of(s.sum), m);
  };
  Shown<decltype(body)> visit{chain_, nullptr, body};
  walk(visit);
  table_.settle();
}

void StepPlan::weigh(const StepRule& rule) {
  Weighing visit{chain_, nullptr, table_, rule};
  walk(visit);
}

void StepPlan::learn_centres(double step) {
  std::array<double, 2> sum{}, count{};
  for (const Slab& s : slabs_)
    for (size_t i = 0; i < s.steps.size(); ++i) {
      const int m = std::abs(s.steps[i]);
      if (m == 0) continue;
      sum[m > 1] += std::fabs(s.coefficients[i]) / step - m, ++count[m > 1];
    }
  for (int i = 0; i < 2; ++i)
    centres_[i] = static_cast<uint8_t>(
        std::clamp(std::lround(128 + 256 * (count[i] > 0 ? sum[i] / count[i] : 0)), 0L, 255L));
}

} // namespace bccsplat::bench

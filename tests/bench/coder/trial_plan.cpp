// SPDX-License-Identifier: Apache-2.0
// Chains are compared by the sizes of their coefficients alone. The step is found by rounding all of them and
// restoring the frames, five times at most.
#include "tests/bench/coder/trial_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/text.h"

namespace bccsplat::bench {
namespace {

std::vector<Slab> make_slabs(const TrialSeries& series, const TrialHead& head, bool principal) {
  std::vector<Slab> slabs;
  const size_t frame = head.chain.samples();
  for (int first = 0; first < head.dims[3]; first += head.slab) {
    Slab& s = slabs.emplace_back();
    s.first = first, s.frames = std::min(head.slab, head.dims[3] - first);
    s.coefficients.assign(series.values.begin() + first * frame,
                          series.values.begin() + (first + s.frames) * frame);
    for (float& v : s.coefficients) v -= head.mean;
    s.basis = principal ? principal_basis(s.coefficients, s.frames) : cosine_basis(s.frames);
    to_layers(s.basis, s.coefficients);
    for (int k = 0; k < s.frames; ++k)
      analyse(head.chain, std::span(s.coefficients).subspan(k * frame, frame));
  }
  return slabs;
}

std::vector<uint8_t> exact_samples(const TrialHead& head, const Slab& slab, std::span<const float> source) {
  std::vector<uint8_t> exact(source.size());
  for_positions(head, [&](const std::array<int, 3>& p) {
    mark_exact(detail_box(head, slab.frames, p), head.rule, source, exact);
  });
  return exact;
}

// The mean square error over all samples that are no holes, details but corrections counted in.
double error_of(const TrialHead& head, const std::vector<Slab>& slabs, const TrialSeries& series) {
  double sum = 0, holes = 0;
  for (const Slab& s : slabs) {
    const std::vector<float> back = restored_slab(head, s);
    const auto from = source_of(head, s, series);
    const std::vector<uint8_t> exact = exact_samples(head, s, from);
    for (size_t i = 0; i < back.size(); ++i) {
      holes += !std::isfinite(from[i]);
      if (!exact[i]) sum += (double{back[i]} - from[i]) * (double{back[i]} - from[i]);
    }
  }
  return sum / (static_cast<double>(series.values.size()) - holes);
}

// Bits of rounding the coefficients, by their sizes alone.
double rough_bits(const TrialPlan& plan, double step) {
  constexpr size_t every = 7;
  constexpr int bits_of_weight = 16;
  double bits = plan.principal ? double{bits_of_weight} * plan.head.slab * plan.head.dims[3] : 0;
  for (const Slab& s : plan.slabs)
    for (size_t i = 0; i < s.coefficients.size(); i += every) {
      const double v = s.coefficients[i] / step;
      bits += std::log2(1 + v * v) / 2 * every;
    }
  return bits;
}

int most_halvings(int size) {
  constexpr int most = 5, least_kept = 2; // halvings; bits of the samples that are left
  return std::clamp(static_cast<int>(std::bit_width(static_cast<unsigned>(size))) - least_kept, 0, most);
}

// Components or cosines first, then how often z is halved: slices lie farther apart than their samples.
TrialPlan choose(const TrialSeries& filled, TrialHead head, double step) {
  TrialPlan best;
  best.bits = INFINITY;
  for (int a = 0; a < 3; ++a) head.chain.halvings[a] = most_halvings(head.dims[a]);
  const auto attempt = [&](bool principal, int along_z) {
    TrialPlan plan{head, {}, principal, 0};
    plan.head.chain.halvings[2] = along_z;
    plan.slabs = make_slabs(filled, plan.head, principal);
    plan.bits = rough_bits(plan, step);
    if (plan.bits < best.bits) best = std::move(plan);
  };
  const int most = head.chain.halvings[2];
  for (const bool principal : {true, false}) attempt(principal, most);
  for (int z = 0; z < most; ++z) attempt(best.principal, z);
  return best;
}

// Finds the step, from one whose error is known to the next.
class StepSearch {
 public:
  StepSearch(StepPlan& steps, TrialPlan& plan, const TrialSeries& series, double goal, double lambda)
      : steps_(steps), plan_(plan), series_(series), goal_(goal), lambda_(lambda) {}

  void run() {
    constexpr int rounds = 6, more_rounds = 20;
    double step = steps_.first_step(goal_);
    steps_.round(step);
    steps_.learn_weights();
    steps_.learn_weights();
    for (int i = 0; i < more_rounds; ++i) {
      const double error = error_at(step);
      if (error <= goal_ && (error > goal_ * near_enough || i >= rounds)) break;
      step *= std::pow(goal_ * aim / error, slope) * (i < rounds ? 1 : a_bit_less);
      if (i == 0) steps_.learn_weights();
    }
    steps_.learn_weights();
    plan_.head.weights = steps_.weights();
  }

 private:
  // The error grows with the step by about this power, inverse.
  static constexpr double slope = .62, aim = .9985, near_enough = .997, a_bit_less = .998;

  double error_at(double step) {
    steps_.learn_bits();
    steps_.weigh({step, lambda_});
    steps_.learn_centres(step);
    plan_.head.step = static_cast<float>(step), plan_.head.centres = steps_.centres();
    return error_of(plan_.head, plan_.slabs, series_);
  }

  StepPlan& steps_;
  TrialPlan& plan_;
  const TrialSeries& series_;
  double goal_, lambda_;
};

} // namespace

std::span<const float> source_of(const TrialHead& head, const Slab& slab, const TrialSeries& series) {
  return std::span(series.values).subspan(slab.first * head.frame(), slab.frames * head.frame());
}

std::vector<float> restored_slab(const TrialHead& head, const Slab& slab) {
  std::vector<float> back(slab.steps.size());
  for (size_t i = 0; i < back.size(); ++i) back[i] = restored(slab.steps[i], head.step, head.centres);
  restore_frames(head, slab.basis, back);
  return back;
}

std::string TrialPlan::words() const {
  return concat(principal ? "components" : "cosines", " of ", head.slab, ", x ", head.chain.halvings[0],
                " y ", head.chain.halvings[1], " z ", head.chain.halvings[2]);
}

TrialPlan plan_trial(const TrialSeries& series, const TrialSeries& filled, const TrialHead& head,
                     double mean_square, double lambda) {
  constexpr double squares_of_step = 12; // over the mean square of what is rounded
  TrialPlan plan = choose(filled, head, std::sqrt(mean_square * squares_of_step));
  StepPlan steps(plan.head.chain, plan.head.edge, plan.slabs);
  StepSearch(steps, plan, series, mean_square, lambda).run();
  return plan;
}

} // namespace bccsplat::bench

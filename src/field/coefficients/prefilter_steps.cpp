// SPDX-License-Identifier: Apache-2.0
#include "field/coefficients/prefilter_steps.h"

#include <utility>

#include "kernel/cc_kernel.h"

namespace bccsplat {

PrefilterOfKernel prefilter_of(const Lattice4& lattice, Kernel kernel) {
  PrefilterOfKernel out{std::move(kernel), {}};
  const auto add = [&](const std::vector<PrefilterStage>& stages) {
    const auto from = static_cast<int>(out.steps.size()); // what came before has made the samples of these
    for (const PrefilterStage& stage : stages) out.steps.push_back({stage, from});
  };
  if (lattice.space.bcc) {
    add(lattice.is_static() ? out.kernel.prefilter3 : out.kernel.prefilter4);
    return out;
  }
  CcKernel cc = make_cc_kernel(out.kernel.name);
  out.kernel = std::move(cc.kernel);
  add(out.kernel.prefilter3);
  out.in_space = out.steps.size();
  if (!lattice.is_static()) add(cc.time);
  return out;
}

std::vector<double> weights_in_time(std::span<const PrefilterStep> steps) {
  std::vector<double> weights{1};
  for (const auto& [stage, source] : steps) {
    const size_t stride = stage.stride;
    std::vector<double> next(weights.size() + 2 * stride);
    for (size_t i = 0; i < weights.size(); ++i) {
      next[i] += stage.temporal * weights[i];
      next[i + stride] += stage.self * weights[i];
      next[i + 2 * stride] += stage.temporal * weights[i];
    }
    next[next.size() / 2] += stage.source; // of what all of them are made of
    weights = std::move(next);
  }
  return weights;
}

} // namespace bccsplat

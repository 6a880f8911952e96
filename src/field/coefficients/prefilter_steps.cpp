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
  if (!lattice.is_static()) add(cc.time);
  return out;
}

} // namespace bccsplat

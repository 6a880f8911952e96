// SPDX-License-Identifier: Apache-2.0
#include "store/layer_window.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "kernel/cc_kernel.h"
#include "kernel/kernel_time.h"

namespace bccsplat {
namespace {

// Stages of samples -> coefficients and the layers they reach.
struct PrefilterSize {
  int32_t layers = 0;
  size_t stages = 0;
};

PrefilterSize prefilter_size(const Lattice4& lattice, const Kernel& kernel) {
  if (lattice.space.bcc) {
    const auto& stages = lattice.is_static() ? kernel.prefilter3 : kernel.prefilter4;
    return {prefilter_reach(stages).time, stages.size()};
  }
  const CcKernel cc = make_cc_kernel(kernel.name);
  if (lattice.is_static()) return {0, cc.kernel.prefilter3.size()};
  // prefilter_reach counts two layers for each step within a coset, as on D4*; here it is one.
  return {(prefilter_reach(cc.time).time + 1) / 2, cc.kernel.prefilter3.size() + cc.time.size()};
}

int32_t support_layers(const Lattice4& lattice, const Kernel& kernel) {
  if (lattice.is_static()) return 1;
  return static_cast<int32_t>(std::ceil(kernel.time.half_width / kernel_time_per_layer(lattice) - 1e-9));
}

} // namespace

const SampleLayer& LayerWindow::layer(int32_t layer) const {
  const SampleLayer* found = find(layer);
  if (!found && lattice_.periodic) found = find(layer + lattice_.layers());
  if (!found) fail(Code::internal, "layer ", layer, " is not among ", first_, " .. ", end() - 1, " at hand");
  return *found;
}

BrickLayer LayerWindow::read_layer(int, int32_t number, const BrickBox&, const Context&) const {
  return layer(number).as_values();
}

void LayerWindow::read_samples(int, std::span<const int32_t> layers, const BrickBox&, const Context&,
                               const TakeLayer<SampleLayer>& take) const {
  for (const int32_t m : layers) take(m, SampleLayer(layer(m)));
}

const SampleLayer* LayerWindow::find(int32_t number) const {
  if (number >= first_ && number < end()) return &layers_[number - first_];
  const auto kept = kept_.find(number);
  return kept == kept_.end() ? nullptr : &kept->second;
}

int32_t layers_in_reach(const Lattice4& lattice, const std::string& kernel) {
  const Kernel k = make_kernel(kernel);
  return support_layers(lattice, k) + prefilter_size(lattice, k).layers;
}

uint64_t coefficient_cache_bytes(const Lattice4& lattice, const std::string& kernel) {
  const bool filtered = prefilter_size(lattice, make_kernel(kernel)).stages > 0;
  const uint64_t layers = 2 * layers_in_reach(lattice, kernel) + 3;
  return BrickLayer(lattice.space, 0).brick_slots() * sizeof(Brick) * layers * (filtered ? 2 : 1);
}

} // namespace bccsplat

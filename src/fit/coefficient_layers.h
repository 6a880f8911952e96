// SPDX-License-Identifier: Apache-2.0
// Layers of samples in, layers of prefiltered coefficients out: for files that spare their readers the
// prefilter and its reach.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "fit/layer_window.h"
#include "fit/quantise.h"

namespace bccsplat {

class CoefficientLayers {
 public:
  // threshold: of the channel; coefficients up to half of it are dropped, as a reader of samples would do.
  // quantiser: i32, f16 or f32, relative to air.
  CoefficientLayers(const Lattice4& lattice, const Quantiser& quantiser, float threshold,
                    const std::string& kernel)
      : CoefficientLayers(lattice, quantiser, threshold, kernel, 0, 0, lattice.layers()) {}
  // Makes only layers first .. end - 1 of coefficients; the first layer of samples is `samples`, as far
  // before `first` as the prefilter reaches.
  CoefficientLayers(const Lattice4& lattice, const Quantiser& quantiser, float threshold,
                    const std::string& kernel, int32_t samples, int32_t first, int32_t end);

  // Before any layer, of a periodic series: samples come from layer `first` on, coefficients from the first
  // whole slab on that needs none before it. Returns where that is.
  int32_t turn_from(int32_t first, int32_t slab_layers);
  // The next layers of samples; returns the layers of coefficients that are complete with them, in order and
  // as stored, but for steps (i32), to which whole slabs are rounded (coefficient_steps.h). All have come out
  // when the last layer has gone in; those of a periodic series that come before the first one last.
  [[nodiscard]] std::vector<BrickLayer> add(std::span<const SampleLayer> samples, const Context& context);

  // The series ends elsewhere than was said, with layers that have not been made yet; of a whole series.
  void set_lattice(const Lattice4& lattice);

  [[nodiscard]] const Kernel& kernel() const { return field_->kernel(); }

 private:
  void make_field();
  [[nodiscard]] int32_t ready(int32_t most) const;
  [[nodiscard]] int32_t most_at_once(const Context& context) const;

  LayerWindow window_;
  std::string kernel_;
  float prune_;
  std::optional<Coefficients> field_;
  int32_t reach_, next_, end_;
  int32_t complete_; // layers of samples
  Quantiser quantiser_;
};

// The numbers that define a radial kernel with a spline in time, as formats/bcc4.md stores them. Throws
// unsupported for other kernels.
[[nodiscard]] std::vector<double> kernel_parameters(const Kernel& kernel);

} // namespace bccsplat

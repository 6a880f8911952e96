// SPDX-License-Identifier: Apache-2.0
// Layers of samples in, slabs of prefiltered coefficients out: for files that spare their readers the
// prefilter and its reach.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "field/coefficients/prefilter.h"
#include "fit/coefficients/coefficient_steps.h"
#include "fit/coefficients/layer_window.h"
#include "fit/kept/quantise.h"

namespace bccsplat {

// Layers of coefficients as they are stored, `first` and up, and the memory that they hold.
struct CoefficientSlab {
  int32_t first = 0;
  std::vector<SampleLayer> layers;
  Reservation held;
};

// Which layers there are.
struct CoefficientSpan {
  int32_t samples = 0;        // the first one given, as far before `first` as the prefilter reaches
  int32_t first = 0, end = 0; // made: whole slabs of a series
  int32_t slab_layers = 1;
  BrickBox bricks{}; // made; of a block, of samples those beside them are there as well
};

class CoefficientLayers {
 public:
  // threshold: of the channel; coefficients up to half of it are dropped, as a reader of samples would do.
  // quantiser: i32, f16 or f32, relative to air.
  CoefficientLayers(const Lattice4& lattice, const Quantiser& quantiser, float threshold,
                    const std::string& kernel, const CoefficientSpan& span);

  // Before any layer, of a periodic series: samples come from layer `first` on, coefficients from the first
  // whole slab on that needs none before it.
  void turn_from(int32_t first);
  // The next layer of samples.
  void push(const SampleLayer& samples, const Context& context);
  // The next slab, if all it depends on has come; none of it is held any longer than the next one needs. All
  // slabs have come out when the last layer has gone in; those of a periodic series that come before the
  // first one last.
  [[nodiscard]] std::optional<CoefficientSlab> next(const Context& context);

  // The series ends elsewhere than was said, with layers that have not been made yet; of a whole series.
  void set_lattice(const Lattice4& lattice);

 private:
  void make_filter();
  [[nodiscard]] std::vector<int32_t> next_layers() const;
  [[nodiscard]] bool ready(std::span<const int32_t> layers) const;
  [[nodiscard]] std::vector<SampleLayer> make(std::span<const int32_t> layers, const Context& context) const;
  void forget();

  LayerWindow window_;
  std::map<int32_t, Reservation> held_; // by the numbers of the window
  std::string kernel_;
  Quantiser quantiser_;
  float prune_;
  std::optional<Prefilter> filter_;
  std::optional<CoefficientSteps> steps_; // of i32
  BrickBox bricks_;
  int32_t slab_layers_, next_, end_;
  int32_t complete_; // layers of samples
};

// The numbers that define a radial kernel with a spline in time, as formats/bcc4.md stores them. Throws
// unsupported for other kernels.
[[nodiscard]] std::vector<double> kernel_parameters(const Kernel& kernel);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Makes slabs of coefficients as soon as the samples that they depend on have come, and lets go of samples as
// soon as no later slab depends on them.
#include "fit/coefficients/coefficient_layers.h"

#include <algorithm>

#include "base/error.h"
#include "field/coefficients/prefilter_steps.h"
#include "fit/coefficients/round_layer.h"
#include "kernel/kernel.h"

namespace bccsplat {
namespace {

// Coefficients up to this far from air are dropped: those that are rounded to it, and those that a reader of
// samples would drop.
float dead_zone(const Quantiser& quantiser, float threshold) {
  const auto step = static_cast<float>(quantiser.type == ValueType::i32 ? quantiser.scale : 0);
  return std::max(threshold, step) / 2;
}

// Returns what a layer has in a box.
BrickLayer bricks_in(const BrickBox& box, const BrickLayer& layer) {
  if (box == BrickBox{}) return layer;
  BrickLayer out(layer.lattice(), layer.coset());
  for (size_t slot = 0; slot < layer.brick_slots(); ++slot)
    if (box.contains(layer.slot_position(slot))) out.set(slot, layer.share(slot));
  return out;
}

} // namespace

CoefficientLayers::CoefficientLayers(const Lattice4& lattice, const Quantiser& quantiser, float threshold,
                                     const std::string& kernel, const CoefficientSpan& span)
    : window_(lattice, quantiser.air, {}, span.samples), kernel_(kernel), quantiser_(quantiser),
      prune_(dead_zone(quantiser, threshold)), bricks_(span.bricks), slab_layers_(span.slab_layers),
      next_(span.first), end_(span.end), complete_(lattice.layers()) {
  make_filter();
  if (!is_float(quantiser.type) && quantiser.type != ValueType::i32)
    fail(Code::invalid_argument,
         "coefficients are stored as i32, f16 or f32: they swing further than samples");
}

void CoefficientLayers::make_filter() {
  const Lattice4& lattice = window_.lattice();
  std::vector<PrefilterStep> steps = prefilter_of(lattice, make_kernel(kernel_)).steps;
  // Others reach no further than the bricks beside their own.
  const bool whole_rows = !steps.empty() && steps.front().filter.pole != 0;
  if (whole_rows && bricks_ != BrickBox{})
    fail(Code::unsupported, "a block of space: a coefficient of kernel ", kernel_,
         " depends on all samples of its row; choose another kernel, or store samples");
  filter_.emplace(lattice, std::move(steps));
  if (quantiser_.type == ValueType::i32) steps_.emplace(lattice, quantiser_, kernel_);
}

void CoefficientLayers::set_lattice(const Lattice4& lattice) {
  window_.set_lattice(lattice);
  end_ = complete_ = lattice.layers();
  make_filter();
}

void CoefficientLayers::turn_from(int32_t first) {
  const Lattice4& lattice = window_.lattice();
  const int32_t layers = lattice.layers(), reach = prefilter_layers(lattice, kernel_);
  next_ = (first + reach + slab_layers_ - 1) / slab_layers_ * slab_layers_;
  if (next_ >= layers) next_ = 0;
  end_ = next_ + layers, complete_ = first + layers;
  // What depends on none of the last layers comes first; else all of them come together.
  window_.turn_from(first, next_ > 0 ? std::min(next_ + reach + 1, complete_) : complete_);
}

void CoefficientLayers::push(const SampleLayer& samples, const Context& context) {
  held_.emplace(window_.end(), Reservation(context.memory, samples.bytes(), "samples of a slab"));
  window_.push(samples);
}

// Returns the layers of the next slab, inside the lattice.
std::vector<int32_t> CoefficientLayers::next_layers() const {
  const Lattice4& lattice = window_.lattice();
  std::vector<int32_t> layers;
  for (int32_t m = next_; m < end_ && static_cast<int32_t>(layers.size()) < slab_layers_; ++m) {
    if (lattice.periodic && m == lattice.layers() && m > next_) break;
    layers.push_back(lattice.mirror_layer(m));
  }
  return layers;
}

// Returns whether they depend on none that is still to come.
bool CoefficientLayers::ready(std::span<const int32_t> layers) const {
  if (layers.empty()) return false;
  const Lattice4& lattice = window_.lattice();
  const int32_t reach = prefilter_layers(lattice, kernel_);
  const auto last = next_ + static_cast<int32_t>(layers.size()) - 1;
  int32_t needed = std::min(last + reach + 1, complete_);
  if (lattice.is_static()) needed = lattice.layers();
  if (lattice.periodic && next_ == 0) needed = complete_;
  return window_.end() >= needed;
}

// Coefficients of steps are rounded, and their values go, tile by tile: a slab of values takes more than all
// else that is held.
std::vector<SampleLayer> CoefficientLayers::make(std::span<const int32_t> layers,
                                                 const Context& context) const {
  const int32_t first = layers.front();
  std::map<int32_t, const SampleLayer*> samples;
  for (const int32_t m : filter_->reads(layers)) samples[m] = &window_.layer(m);
  const TakeBricks round = [&](std::span<SampleLayer> made, const BrickBox& box) {
    steps_->round(first, made, box, context);
  };
  if (filter_->empty()) {
    std::vector<BrickLayer> values;
    for (const int32_t m : layers) values.push_back(bricks_in(bricks_, window_.layer(m).as_values()));
    if (steps_) return steps_->round(first, values, context);
    return {values.begin(), values.end()};
  }
  uint64_t bytes = 0;
  for (const int32_t m : layers) bytes += steps_ ? 0 : samples.at(m)->bricks() * sizeof(Brick);
  const Reservation room(context.memory, bytes, "coefficients of some layers");
  return filter_->apply(layers, samples, {prune_, 0}, bricks_, context, steps_ ? round : TakeBricks());
}

std::optional<CoefficientSlab> CoefficientLayers::next(const Context& context) {
  const std::vector<int32_t> layers = next_layers();
  if (!ready(layers)) return std::nullopt;
  CoefficientSlab slab{layers.front(), make(layers, context), {}};
  uint64_t bytes = 0, clamped = 0; // the container counts none either: it gets what fits
  for (SampleLayer& layer : slab.layers) {
    if (quantiser_.type == ValueType::f16)
      layer = SampleLayer(round_layer(layer.as_values(), quantiser_, 0, clamped, context));
    bytes += layer.bytes();
  }
  next_ += static_cast<int32_t>(layers.size());
  forget();
  slab.held = Reservation(context.memory, bytes, "a slab of coefficients");
  return slab;
}

// A layer beyond the end mirrors one as far before it.
void CoefficientLayers::forget() {
  const Lattice4& lattice = window_.lattice();
  if (lattice.is_static()) return;
  if (lattice.periodic && window_.end() >= complete_ && next_ >= end_)
    window_.forget_all();
  else if (!lattice.periodic || window_.end() < complete_)
    window_.forget(next_ - prefilter_layers(lattice, kernel_));
  std::erase_if(held_, [&](const auto& layer) { return !window_.holds(layer.first); });
}

std::vector<double> kernel_parameters(const Kernel& kernel) {
  if (kernel.normalised || kernel.name == "exact" || kernel.time.shape != TemporalKernel::Shape::bspline)
    fail(Code::unsupported, "coefficients of kernel ", kernel.name,
         " cannot be stored; choose a radial kernel such as default");
  std::vector<double> numbers{kernel.space.radius};
  for (int j = 2; j < kernel.space.terms; ++j) numbers.push_back(kernel.space.a[j]);
  numbers.push_back(kernel.time.order);
  numbers.insert(numbers.end(), kernel.time.bend.begin(), kernel.time.bend.end());
  return numbers;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "fit/coefficient_layers.h"

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "fit/round_layer.h"

namespace bccsplat {
namespace {

// Layers that are made together, as a slab has them (slab_layers_for), and of the memory that is left the
// part that each of them may take if nothing is air.
constexpr int32_t together = 4;
constexpr uint64_t memory_parts = 8;

// Coefficients up to this far from air are dropped: those that are rounded to it, and those that a reader of
// samples would drop.
float dead_zone(const Quantiser& quantiser, float threshold) {
  const auto step = static_cast<float>(quantiser.type == ValueType::i32 ? quantiser.scale : 0);
  return std::max(threshold, step) / 2;
}

} // namespace

CoefficientLayers::CoefficientLayers(const Lattice4& lattice, const Quantiser& quantiser, float threshold,
                                     const std::string& kernel, int32_t samples, int32_t first, int32_t end)
    : window_(lattice, quantiser.air, {}, samples), kernel_(kernel), prune_(dead_zone(quantiser, threshold)),
      reach_(prefilter_layers(lattice, kernel)), next_(first), end_(end), complete_(lattice.layers()),
      quantiser_(quantiser) {
  make_field();
  if (!is_float(quantiser.type) && quantiser.type != ValueType::i32)
    fail(Code::invalid_argument,
         "coefficients are stored as i32, f16 or f32: they swing further than samples");
}

void CoefficientLayers::make_field() {
  field_.emplace(window_, 0, make_kernel(kernel_), prune_, coefficient_cache_bytes(window_, kernel_));
}

void CoefficientLayers::set_lattice(const Lattice4& lattice) {
  window_.set_lattice(lattice);
  reach_ = prefilter_layers(lattice, kernel_), end_ = complete_ = lattice.layers();
  make_field();
}

int32_t CoefficientLayers::turn_from(int32_t first, int32_t slab_layers) {
  const int32_t layers = window_.lattice().layers();
  next_ = (first + reach_ + slab_layers - 1) / slab_layers * slab_layers;
  if (next_ >= layers) next_ = 0;
  end_ = next_ + layers, complete_ = first + layers;
  // What depends on none of the last layers comes first; else all of them come together.
  window_.turn_from(first, next_ > 0 ? std::min(next_ + reach_ + 1, complete_) : complete_);
  return next_;
}

// How many of the next layers, at most `most`, depend on none that is still to come.
int32_t CoefficientLayers::ready(int32_t most) const {
  const Lattice4& lattice = window_.lattice();
  const auto needed = [&](int32_t m) {
    if (lattice.is_static()) return lattice.layers();
    return lattice.periodic && m == 0 ? complete_ : std::min(m + reach_ + 1, complete_);
  };
  int32_t count = 0;
  while (count < most && next_ + count < end_ && window_.end() >= needed(next_ + count)) ++count;
  return count;
}

// How many layers may be made at once: they share stages, and take memory.
int32_t CoefficientLayers::most_at_once(const Context& context) const {
  const uint64_t room = context.memory.limit() - context.memory.used(),
                 layer = uint64_t{BrickLayer(window_.lattice().space, 0).brick_slots()} * sizeof(Brick);
  return static_cast<int32_t>(std::clamp<uint64_t>(room / (memory_parts * layer), 1, together));
}

std::vector<BrickLayer> CoefficientLayers::add(std::span<const SampleLayer> samples, const Context& context) {
  for (const SampleLayer& layer : samples) window_.push(layer);
  const Lattice4& lattice = window_.lattice();
  std::vector<BrickLayer> out;
  while (const int32_t count = ready(most_at_once(context))) {
    std::vector<int32_t> numbers(static_cast<size_t>(count));
    std::iota(numbers.begin(), numbers.end(), next_);
    uint64_t clamped = 0; // the container counts none either: it gets what fits
    for (const auto& made : field_->layers(numbers, context))
      out.push_back(quantiser_.type == ValueType::f16 ? round_layer(*made, quantiser_, 0, clamped, context)
                                                      : *made);
    if (const int32_t next = std::min(next_ + count, lattice.layers());
        !lattice.is_static() && next_ < lattice.layers())
      field_->forget(next, next);
    next_ += count;
  }
  // A layer beyond the end mirrors one as far before it.
  if (lattice.periodic && window_.end() >= complete_)
    window_.forget_all();
  else if (!lattice.is_static())
    window_.forget(next_ - reach_ - 1);
  return out;
}

std::vector<double> kernel_parameters(const Kernel& kernel) {
  if (kernel.normalised || kernel.name == "exact" || kernel.time.shape != TemporalKernel::Shape::bspline)
    fail(Code::unsupported, "coefficients of kernel ", kernel.name,
         " cannot be stored; choose a radial kernel such as default");
  std::vector<double> numbers{kernel.space.radius};
  for (int j = 2; j < kernel.space.terms; ++j) numbers.push_back(kernel.space.a[static_cast<size_t>(j)]);
  numbers.push_back(kernel.time.order);
  numbers.insert(numbers.end(), kernel.time.bend.begin(), kernel.time.bend.end());
  return numbers;
}

} // namespace bccsplat

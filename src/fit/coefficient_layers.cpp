#include "fit/coefficient_layers.h"

#include <algorithm>

#include "base/error.h"

namespace bccsplat {

CoefficientLayers::CoefficientLayers(const Lattice4& lattice, const Quantiser& quantiser, float threshold,
                                     const std::string& kernel, int32_t samples, int32_t first, int32_t end)
    : window_(lattice, quantiser.air, {}, samples),
      field_(window_, 0, make_kernel(kernel), threshold / 2, coefficient_cache_bytes(window_, kernel)),
      reach_(prefilter_layers(lattice, kernel)), next_(first), end_(end), quantiser_(quantiser),
      relevance_(quantiser, 0) {
  if (quantiser.type != ValueType::f16 && quantiser.type != ValueType::f32)
    fail(Code::invalid_argument,
         "coefficients are stored as f16 or f32: their range is not that of the samples");
}

std::vector<BrickLayer> CoefficientLayers::add(std::span<const BrickLayer> samples, const Context& context) {
  for (const BrickLayer& layer : samples) window_.push(layer);
  const int32_t layers = window_.lattice().layers();
  std::vector<BrickLayer> out;
  for (; next_ < end_; ++next_) {
    if (window_.end() < (window_.lattice().is_static() ? layers : std::min(next_ + reach_ + 1, layers)))
      break;
    out.push_back(rounded(*field_.layer(next_, context), context));
  }
  // A layer beyond the end mirrors one as far before it.
  if (!window_.lattice().is_static()) window_.forget(next_ - reach_ - 1);
  return out;
}

BrickLayer CoefficientLayers::rounded(const BrickLayer& layer, const Context& context) const {
  if (quantiser_.type == ValueType::f32) return layer;
  BrickLayer out(layer.lattice(), layer.coset());
  context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
    const Brick* brick = layer.brick(slot);
    if (!brick) return;
    const Int3 position = layer.slot_position(slot);
    Int3 size;
    for (size_t a = 0; a < 3; ++a) size[a] = std::min(brick_edge, layer.dims()[a] - position[a] * brick_edge);
    auto made = std::make_shared<Brick>();
    if (relevance_.select(brick->value.data(), size, {brick->hole.get(), nullptr, 0}, *made).kept > 0)
      out.set(slot, std::move(made));
  });
  return out;
}

std::vector<double> kernel_parameters(const Kernel& kernel) {
  if (kernel.normalised || kernel.time.shape != TemporalKernel::Shape::bspline)
    fail(Code::unsupported, "coefficients of kernel ", kernel.name,
         " cannot be stored; choose a radial kernel such as default");
  std::vector<double> numbers{kernel.space.radius};
  for (int j = 2; j < kernel.space.terms; ++j) numbers.push_back(kernel.space.a[static_cast<size_t>(j)]);
  numbers.push_back(kernel.time.order);
  numbers.insert(numbers.end(), kernel.time.bend.begin(), kernel.time.bend.end());
  return numbers;
}

} // namespace bccsplat

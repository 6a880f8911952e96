// SPDX-License-Identifier: Apache-2.0
// The last layers of a fit as a source of samples: what a reader of the file will see, before it is a file.
//
// Layers are numbered as they come. Those of a periodic series begin anywhere, and count on behind the last
// one of the lattice: the first ones of the lattice come last.
#pragma once

#include <deque>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "points/sample_source.h"

namespace bccsplat {

class LayerWindow final : public SampleSource {
 public:
  // first: number of the first layer. sample_step: of the samples; 0: any values.
  LayerWindow(const Lattice4& lattice, float air, int32_t first = 0, double sample_step = 0)
      : lattice_(lattice), air_(air), sample_step_(sample_step), first_(first) {}

  // The next layer.
  void push(SampleLayer layer) { layers_.push_back(std::move(layer)); }
  void push(const BrickLayer& layer) { push(SampleLayer(layer)); }
  // Before any layer, of a periodic series: layer `first` comes first, and those before `kept` are needed
  // again when all have come.
  void turn_from(int32_t first, int32_t kept) { first_ = first, kept_end_ = kept; }
  // Layers before this one are not needed any more.
  void forget(int32_t before) {
    for (; first_ < before && !layers_.empty(); ++first_) {
      if (first_ < kept_end_) kept_[first_] = std::move(layers_.front());
      layers_.pop_front();
    }
  }
  // None is.
  void forget_all() {
    forget(end());
    kept_.clear();
  }
  // The series ends elsewhere than was said; what has been made of its layers must be made anew.
  void set_lattice(const Lattice4& lattice) { lattice_ = lattice; }
  [[nodiscard]] int32_t end() const { return first_ + static_cast<int32_t>(layers_.size()); }

  const Lattice4& lattice() const override { return lattice_; }
  int channels() const override { return 1; }
  float air(int) const override { return air_; }
  double sample_step(int) const override { return sample_step_; }
  BrickLayer read_layer(int, int32_t layer, const BrickBox&, const Context&) const override;
  void read_samples(int, std::span<const int32_t> layers, const BrickBox&, const Context&,
                    const TakeLayer<SampleLayer>& take) const override;
  [[nodiscard]] const SampleLayer& layer(int32_t number) const;

 private:
  Lattice4 lattice_;
  float air_;
  double sample_step_;
  [[nodiscard]] const SampleLayer* find(int32_t number) const;

  std::deque<SampleLayer> layers_;
  int32_t first_; // number of the front
  int32_t kept_end_ = 0;
  std::map<int32_t, SampleLayer> kept_; // by number
};

// Returns how many layers on either side of an instant matter under `kernel`.
[[nodiscard]] int32_t layers_in_reach(const Lattice4& lattice, const std::string& kernel);
// Returns how many bytes the coefficients of the layers in reach, and their samples, take when nothing is
// air: a cache of this size never makes them twice.
[[nodiscard]] uint64_t coefficient_cache_bytes(const Lattice4& lattice, const std::string& kernel);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// One series as coefficients in integer codes, in several ways: bytes, and how far the field and its gradient
// are from those of coefficients that are not rounded.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "field/coefficients/coefficients.h"
#include "formats/bcc4/encode/noise_shape.h"
#include "lattice/lattice.h"
#include "points/brick.h"
#include "tests/bench/fit/fit_source.h"

namespace bccsplat::bench {

struct TrialSource {
  FitSource source; // u8 or u16
  double step = 1;  // to which samples are rounded, and the unit of all steps and errors
  std::function<bool(const Vec4&)> where{}; // errors are looked at; none: all over the domain
};

// In source steps: of the field, of its gradient in space, per T. Luminance: of |n . l| in 255 grey levels
// where the gradient is at least half its root mean square.
struct FieldErrors {
  double rms = 0, largest = 0, gradient = 0, luminance = 0;
};

struct Trial {
  double step = 1; // of shift 0
  int most_shift = 0;
  bool shaped = false; // one step: errors are fed back; with shifts they are wherever the shift is not 0
  int32_t slab_layers = 8;
};

struct TrialResult {
  uint64_t bytes = 0, sites = 0; // of chunks, without the index
  FieldErrors error;
};

class CoefficientTrials {
 public:
  CoefficientTrials(const TrialSource& source, const std::string& kernel, bool quick);

  // The samples file: rounded and, by the type of the source, clamped.
  [[nodiscard]] TrialResult samples() const;
  // Samples rounded and not clamped, as only a wider type could hold them.
  [[nodiscard]] FieldErrors unclamped() const;
  [[nodiscard]] TrialResult coefficients(const Trial& trial) const;

 private:
  struct Field {
    std::vector<float> values;
    std::vector<std::array<float, 4>> gradients;
  };
  [[nodiscard]] std::vector<BrickLayer> fitted(const Quantiser& quantiser) const;
  [[nodiscard]] Field field(const std::vector<BrickLayer>& layers, bool coefficients) const;
  [[nodiscard]] FieldErrors errors(const std::vector<BrickLayer>& layers, bool coefficients) const;
  void choose_points(const std::function<bool(const Vec4&)>& where, size_t count);

  const TrialSource& source_;
  Kernel kernel_;
  Quantiser quantiser_;
  Lattice4 lattice_;
  std::vector<BrickLayer> exact_, coefficients_; // samples and coefficients, not rounded
  NoiseShape shape_;
  std::vector<Vec4> points_;
  Field truth_;
};

} // namespace bccsplat::bench

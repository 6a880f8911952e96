// SPDX-License-Identifier: Apache-2.0
// Series for measuring the container, and their way into a file in memory and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "fit/fit.h"
#include "formats/bcc4/write/writer.h"
#include "tests/bench/fit/fit_fields.h"

namespace bccsplat::bench {

// A random field of n^4 samples whose power spectrum is a Gaussian in |w|, sigma `sigma` times the Nyquist
// frequency, cut off where |w| exceeds `cut` times it: band-limited to a ball. Periodic; values -1 .. 1. n is
// a power of 2.
[[nodiscard]] FitSeries gaussian_field(uint32_t n, double sigma, double cut, uint32_t seed);

struct StoredSeries {
  std::vector<std::byte> file;
  FitReport fit;
  Bcc4Report report;
  double write_seconds = 0; // CPU time of coding the slabs
  double peak = 0;          // largest minus smallest source sample
  double site_psnr = 0;     // dB, of the stored samples against those the fit made in f32
  double field_psnr = 0;    // dB, of the reconstructed source samples; 0: not measured
};

struct StoreOptions {
  LatticeKind lattice = LatticeKind::d4star;
  Quantiser quantiser;
  int level = 9;
  std::string kernel{}; // to reconstruct with; empty: not reconstructed
  uint32_t border = 0;  // samples at the ends of each axis that field_psnr leaves out
};

[[nodiscard]] StoredSeries store(const FitSeries& series, const StoreOptions& options);

} // namespace bccsplat::bench

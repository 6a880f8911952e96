// SPDX-License-Identifier: Apache-2.0
// A trial of a third store: series coded sample by sample along a chain, to a PSNR, in chunks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace bccsplat::bench {

struct TrialSeries {
  std::array<int, 4> dims{1, 1, 1, 1};
  std::vector<float> values; // x fastest; what is not finite is a hole
};

struct TrialOptions {
  double psnr = 50;    // dB of all samples, peak: the range
  double bound = 0;    // not 0: of every sample, and psnr is not looked at
  double inside = .42; // the root mean square before corrections, of a bound
  int slab = 0;        // frames; 0: chosen
  int edge = 32;       // of a chunk, samples
  double lambda = .11; // squared steps that a bit is worth
};

struct TrialFile {
  std::vector<std::byte> bytes;
  std::string chain;    // what was chosen, in words
  uint64_t details = 0; // bytes of air, holes and corrections
};

[[nodiscard]] TrialFile trial_encode(const TrialSeries& series, const TrialOptions& options);
// Throws Error where the bytes are not those of a trial file.
[[nodiscard]] TrialSeries trial_decode(std::span<const std::byte> bytes);
// Bytes that are read for the frames first .. last: those of their slabs and what precedes all slabs.
[[nodiscard]] uint64_t trial_moment_bytes(std::span<const std::byte> bytes, int first, int last);

} // namespace bccsplat::bench

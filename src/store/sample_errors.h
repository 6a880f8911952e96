// SPDX-License-Identifier: Apache-2.0
// How far what a file gives is off at source samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "base/exact_sum.h"
#include "points/values.h"

namespace bccsplat {

// Differences over one set of samples; the same however the set is divided.
struct ErrorSum {
  double largest = 0;
  ExactSum squares;
  uint64_t count = 0;
  void add(double difference) {
    largest = std::max(largest, std::fabs(difference));
    squares.add(difference * difference);
    ++count;
  }
  void add(const ErrorSum& other);
  [[nodiscard]] double rms() const;
  // dB; infinite without any difference, NaN without samples.
  [[nodiscard]] double psnr(double peak) const;
};

// Errors at finite source samples, corrections included.
struct SampleErrors {
  ErrorSum all, non_air;  // non_air: source samples further than the threshold from air
  ErrorSum bare;          // all, before corrections; without those that lie in holes
  uint64_t lost = 0;      // samples that lie in holes of the lattice and got no correction
  uint64_t corrected = 0; // samples with a correction
  uint64_t frame = 0;     // of the largest difference, as are the next three; of equal ones the first
  std::array<uint64_t, 3> voxel{};
  double expected = 0, got = 0;
  void add(const SampleErrors& other);

 private:
  // Returns whether the other's largest difference is larger, or as large and before this one by frame, z, y
  // and x.
  [[nodiscard]] bool yields_to(const SampleErrors& other) const;
};

// Throws bound_not_met unless the errors of a channel, its range the peak, reach `psnr` dB. told: the range
// that its steps were chosen for, if they were.
void require_psnr(const std::string& channel, const SampleErrors& errors, const Range& range, double psnr,
                  const std::optional<Range>& told = {});

} // namespace bccsplat

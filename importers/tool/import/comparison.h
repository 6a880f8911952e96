// SPDX-License-Identifier: Apache-2.0
// A volume against the source it was made from, sample by sample.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "series/scan.h"
#include "tool/handles.h"
#include "tool/json_fwd.h"

namespace bcc4 {

// Differences over one set of samples.
struct Difference {
  double max = 0;
  double sum_of_squares = 0;
  uint64_t count = 0;
  void add(double difference);
  void add(const Difference& other);
  [[nodiscard]] double rmse() const;
  // Infinite for no difference at all.
  [[nodiscard]] double psnr(double peak) const;
};

struct Worst {
  uint64_t frame = 0;
  std::array<uint64_t, 3> voxel{};
  double expected = 0, got = 0;
};

struct Comparison {
  Difference all, relevant; // relevant: source samples further than the threshold from air
  Difference exported;      // of what export writes, where it rounds
  Type export_type = Type::f32;
  Worst worst;
  std::vector<Comparison> frames; // of a series: frame by frame
  ChannelScan scan;
  uint64_t holes_expected = 0; // source values that are not finite as floats
  uint64_t holes_got = 0;      // of the finite ones, those the file has as missing data
  void add(const Comparison& other);
};

// Compares all frames of the source with slices of the volume, channel by channel. progress: is a line of it
// shown?
[[nodiscard]] std::vector<Comparison> compare_series(const Volume& volume, FrameReader& source,
                                                     bool progress);

// bound: the one the file promises with this kernel; 0: none.
[[nodiscard]] Json comparison_json(const Comparison& comparison, double bound);
void print_comparison(const std::string& name, const Comparison& comparison);

} // namespace bcc4

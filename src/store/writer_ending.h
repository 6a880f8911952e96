// SPDX-License-Identifier: Apache-2.0
// How a series ends: with the frames that were said or with fewer, and what is then said about it. Holds what
// is known once the file is finished; needs all that the writer has.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.h"
#include "store/write_report.h"
#include "store/writer_output.h"

namespace bccsplat {

// The errors of a measured frame, or of the series.
struct MeasuredErrors {
  uint64_t frame = 0; // of the series: the one of the largest difference
  double peak = 0;    // range of the channel's source
  SampleErrors errors;
};

class WriterEnding {
 public:
  // All of them outlive it.
  WriterEnding(WriterOpening& opening, LevelFits& fits, Measuring& measuring, WriterOutput& output,
               const GivenData& given, const Context& context);

  // Throws wrong_state unless the series is complete.
  void check() const;
  // Returns the frames of a series that ends with what every channel has been given, where these are fewer
  // than was said. Throws where it cannot end there.
  [[nodiscard]] std::optional<uint32_t> fewer_frames() const;
  void shorten(uint32_t frames);
  // Once checked. Throws bound_not_met.
  [[nodiscard]] WriteReport finish();

  // After finish; see VolumeWriter.
  [[nodiscard]] MeasuredErrors measured(uint32_t channel, int64_t index) const;
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void require_no_fewer(uint64_t frames) const;
  void check_times(uint32_t frames) const;
  [[nodiscard]] uint32_t frames_given() const;
  [[nodiscard]] FitReport finish_fits();
  void complete_info(const FitReport& result);
  void describe_part(const FitReport& result);
  void describe_errors(const FitReport& result);
  void require_psnr_met(const FitReport& result) const;
  [[nodiscard]] WriteReport report_of(const FitReport& result);
  [[nodiscard]] size_t channels() const { return given_.added.size(); }

  WriterOpening& opening_;
  LevelFits& fits_;
  Measuring& measuring_;
  WriterOutput& output_;
  const GivenData& given_;
  Context context_;
  std::vector<Range> source_ranges_;
  std::vector<std::string> warnings_;
};

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// A series of a host: what its options say of it and want, and its frames by a callback.
#pragma once

#include "bccsplat.h"

#include "choose/series_plan.h"
#include "series/frame_reader.h"

namespace bccsplat::plan {

// What the options of the C ABI say, in the words of src/choose.
struct Request {
  series::SeriesDescription series;
  series::WriterSettings settings;
  series::SeriesWish wish;
};
// wish: options.wish as this version knows it.
[[nodiscard]] Request read_request(const bccsplat_plan_options& options, const bccsplat_writer_options& wish);

// Asks the host for each frame, or for parts of it.
class HostFrames : public series::FrameReader {
 public:
  HostFrames(series::SeriesDescription series, const bccsplat_plan_options& options)
      : series_(std::move(series)), options_(options) {}
  [[nodiscard]] const series::SeriesDescription& description() const override { return series_; }
  [[nodiscard]] series::Frame read(uint64_t frame, size_t channel) override;
  [[nodiscard]] series::Frame read_box(uint64_t frame, size_t channel,
                                       const series::SampleBox& wanted) override;
  [[nodiscard]] bool frames_fit() const override { return !(options_.set_mask & BCCSPLAT_PLAN_LARGE_FRAMES); }
  [[nodiscard]] std::string frame_name(uint64_t frame) const override;
  [[nodiscard]] bool any_thread() const override { return options_.set_mask & BCCSPLAT_PLAN_ANY_THREAD; }

 private:
  [[noreturn]] void give_up(uint64_t frame, size_t channel) const;

  series::SeriesDescription series_;
  bccsplat_plan_options options_;
};

} // namespace bccsplat::plan

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

// Asks the host for each frame.
class HostFrames : public series::FrameReader {
 public:
  HostFrames(series::SeriesDescription series, bccsplat_source_fn frame, void* user)
      : series_(std::move(series)), frame_(frame), user_(user) {}
  [[nodiscard]] const series::SeriesDescription& description() const override { return series_; }
  [[nodiscard]] series::Frame read(uint64_t frame, size_t channel) override;
  [[nodiscard]] std::string frame_name(uint64_t frame) const override;
  [[nodiscard]] bool any_thread() const override { return false; }

 private:
  series::SeriesDescription series_;
  bccsplat_source_fn frame_;
  void* user_;
};

} // namespace bccsplat::plan

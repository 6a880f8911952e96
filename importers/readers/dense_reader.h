// SPDX-License-Identifier: Apache-2.0
// The reader of every format that is one dense array (raw, NRRD, NIfTI ...): a description and the array.
#pragma once

#include <utility>

#include "readers/dense_series.h"
#include "readers/sequence.h"

namespace bcc4 {

// Makes the files of one frame each, one after the other, the slowest axis, time.
inline void stack_files(DenseLayout& layout, const Sequence& sequence) {
  std::erase_if(layout.axes, [](const FileAxis& a) { return a.role == AxisRole::t; });
  layout.axes.push_back({AxisRole::t, sequence.files.size()});
}

class DenseReader : public FrameReader {
 public:
  // `components[c]` is the index along the component axis of channel c.
  DenseReader(SeriesDescription description, DenseSeries series, std::vector<uint64_t> components = {0})
      : description_(std::move(description)), series_(std::move(series)), components_(std::move(components)) {
    for (Channel& channel : description_.channels) channel.type = series_.frame_type();
    if (const std::string passes = series_.passes_text(); !passes.empty())
      description_.notes.push_back(passes);
  }
  const SeriesDescription& description() const override { return description_; }
  Frame read(uint64_t frame, size_t channel) override { return series_.read(frame, components_[channel]); }
  Frame read_box(uint64_t frame, size_t channel, const SampleBox& wanted) override {
    return series_.read_box(frame, components_[channel], wanted);
  }
  bool frames_fit() const override { return series_.frame_fits(); }
  std::string frame_name(uint64_t frame) const override { return series_.path_of(frame); }

 private:
  SeriesDescription description_;
  DenseSeries series_;
  std::vector<uint64_t> components_;
};

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
#include "tool/import/writer_settings.h"

namespace bcc4 {
int32_t stored_type(const bccsplat_channel_options& channel) {
  if (channel.value_type != BCCSPLAT_TYPE_DEFAULT) return channel.value_type;
  const auto either = [&](int32_t a, int32_t b) {
    return channel.source_type == a || channel.source_type == b;
  };
  return either(BCCSPLAT_TYPE_U8, BCCSPLAT_TYPE_I8)     ? BCCSPLAT_TYPE_U8
         : either(BCCSPLAT_TYPE_U16, BCCSPLAT_TYPE_I16) ? BCCSPLAT_TYPE_U16
         : either(BCCSPLAT_TYPE_F16, BCCSPLAT_TYPE_F16) ? BCCSPLAT_TYPE_F16
                                                        : BCCSPLAT_TYPE_F32;
}

std::vector<bccsplat_box> library_boxes(const Frame& frame) {
  std::vector<bccsplat_box> boxes;
  boxes.reserve(frame.boxes.size());
  for (const Box& box : frame.boxes) {
    bccsplat_box& b = boxes.emplace_back(sized<bccsplat_box>());
    b.type = library_type(box.type);
    b.data = box.data;
    for (size_t a = 0; a < 3; ++a) {
      b.begin[a] = box.begin[a];
      b.dims[a] = box.dims[a];
      b.stride_bytes[a] = box.stride_bytes[a];
    }
  }
  return boxes;
}

SeriesOptions series_options(const SeriesDescription& series, const WriterSettings& settings) {
  return {series, settings, settings.values, settings.kernel, settings.mean_errors, settings.largest_errors};
}

Writer create_writer(const Device& device, const std::string& path, const SeriesDescription& series,
                     const WriterSettings& settings, uint64_t frames, const bccsplat_series_part* part) {
  SeriesOptions made = series_options(series, settings);
  bccsplat_writer_options& options = made.options;
  options.dims[3] = static_cast<uint32_t>(frames), options.part = part;
  bccsplat_writer* writer = nullptr;
  if (path.empty()) {
    options.partial = BCCSPLAT_PARTIAL_DEFAULT, options.live = 0; // of files
    const bccsplat_write_stream none = bccsplat::series::nowhere();
    check(bccsplat_writer_create_stream(device.get(), &none, &options, &writer), "");
  } else {
    check(bccsplat_writer_create(device.get(), path.c_str(), &options, &writer), path);
  }
  return Writer(writer);
}

} // namespace bcc4

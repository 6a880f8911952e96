// SPDX-License-Identifier: Apache-2.0
#include "tool/import/writer_settings.h"

#include <algorithm>
#include <utility>

#include "base/utf8.h"

namespace bcc4 {
namespace {

constexpr std::pair<Type, int32_t> kTypes[] = {
    {Type::u8, BCCSPLAT_TYPE_U8},   {Type::i8, BCCSPLAT_TYPE_I8},   {Type::u16, BCCSPLAT_TYPE_U16},
    {Type::i16, BCCSPLAT_TYPE_I16}, {Type::u32, BCCSPLAT_TYPE_U32}, {Type::i32, BCCSPLAT_TYPE_I32},
    {Type::f16, BCCSPLAT_TYPE_F16}, {Type::f32, BCCSPLAT_TYPE_F32}, {Type::f64, BCCSPLAT_TYPE_F64}};

int64_t write_nowhere(void*, uint64_t, const void*, uint64_t size) { return size; }

const char* text_or_null(const std::string& text) { return text.empty() ? nullptr : text.c_str(); }

} // namespace

int32_t library_type(Type type) {
  for (const auto& [ours, known] : kTypes)
    if (ours == type) return known;
  return BCCSPLAT_TYPE_I32; // integers of 64 bits, as which export may write them
}

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

SeriesOptions::SeriesOptions(const SeriesDescription& s, const WriterSettings& settings)
    : options(static_cast<const bccsplat_writer_options&>(settings)), channels_(settings.values),
      spatial_unit_(bccsplat::utf8_of(s.spatial_unit)), time_unit_(bccsplat::utf8_of(s.times.unit)) {
  bool has_fill = false;
  for (size_t c = 0; c < channels_.size(); ++c) {
    channels_[c].name = s.channels[c].name.c_str(), channels_[c].unit = text_or_null(s.channels[c].unit);
    has_fill |= s.channels[c].has_fill;
  }
  for (size_t a = 0; a < axes_.size(); ++a) {
    const Places& places = s.places[a];
    axis_units_[a] = bccsplat::utf8_of(places.unit);
    axes_[a] = sized<bccsplat_axis>();
    axes_[a].count = places.coordinates.size(), axes_[a].coordinates = places.coordinates.data();
    axes_[a].flags = places.down ? BCCSPLAT_AXIS_DOWN : 0;
    axes_[a].unit = text_or_null(axis_units_[a]);
  }
  options.channel_count = static_cast<uint32_t>(channels_.size()), options.channels = channels_.data();
  const auto by_channel = [&](const std::vector<double>& errors) {
    return !errors.empty() && errors.size() == channels_.size() ? errors.data() : nullptr;
  };
  options.wavelet_errors = by_channel(settings.mean_errors);
  options.abs_errors = by_channel(settings.largest_errors);
  for (size_t a = 0; a < 4; ++a) options.dims[a] = static_cast<uint32_t>(s.dims[a]);
  std::copy(s.affine.begin(), s.affine.end(), options.affine);
  options.spatial_unit = text_or_null(spatial_unit_), options.time_unit = text_or_null(time_unit_);
  options.axes = has_coordinates(s) ? axes_.data() : nullptr;
  options.recommended_kernel = text_or_null(settings.kernel);
  if (has_fill && options.nonfinite == BCCSPLAT_NONFINITE_DEFAULT)
    options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
}

Writer create_writer(const Device& device, const std::string& path, const SeriesDescription& series,
                     const WriterSettings& settings, uint64_t frames, const bccsplat_series_part* part) {
  SeriesOptions made(series, settings);
  bccsplat_writer_options& options = made.options;
  options.dims[3] = static_cast<uint32_t>(frames), options.part = part;
  bccsplat_writer* writer = nullptr;
  if (path.empty()) {
    options.partial = BCCSPLAT_PARTIAL_DEFAULT, options.live = 0; // of files
    auto nowhere = sized<bccsplat_write_stream>();
    nowhere.write_at = write_nowhere;
    check(bccsplat_writer_create_stream(device.get(), &nowhere, &options, &writer), "");
  } else {
    check(bccsplat_writer_create(device.get(), path.c_str(), &options, &writer), path);
  }
  return Writer(writer);
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
#include "series/library.h"

#include <algorithm>
#include <utility>

#include "base/utf8.h"

namespace bccsplat::series {
namespace {

constexpr std::pair<int32_t, Type> kTypes[] = {
    {BCCSPLAT_TYPE_U8, Type::u8},   {BCCSPLAT_TYPE_I8, Type::i8},   {BCCSPLAT_TYPE_U16, Type::u16},
    {BCCSPLAT_TYPE_I16, Type::i16}, {BCCSPLAT_TYPE_U32, Type::u32}, {BCCSPLAT_TYPE_I32, Type::i32},
    {BCCSPLAT_TYPE_F16, Type::f16}, {BCCSPLAT_TYPE_F32, Type::f32}, {BCCSPLAT_TYPE_F64, Type::f64}};

const char* text_or_null(const std::string& text) { return text.empty() ? nullptr : text.c_str(); }

} // namespace

int32_t library_type(Type type) {
  for (const auto& [known, ours] : kTypes)
    if (ours == type) return known;
  return BCCSPLAT_TYPE_I32; // integers of 64 bits, as which export may write them
}

Type type_of(int32_t number) {
  for (const auto& [known, ours] : kTypes)
    if (known == number) return ours;
  return Type::f32;
}

bccsplat_write_stream nowhere() {
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = [](void*, uint64_t, const void*, uint64_t size) { return static_cast<int64_t>(size); };
  return stream;
}

SeriesOptions::SeriesOptions(const SeriesDescription& s, const bccsplat_writer_options& settings,
                             std::vector<bccsplat_channel_options> of_channels, std::string of_kernel,
                             const std::vector<double>& mean_errors,
                             const std::vector<double>& largest_errors)
    : options(settings), channels(std::move(of_channels)), kernel(std::move(of_kernel)),
      spatial_unit_(utf8_of(s.spatial_unit)), time_unit_(utf8_of(s.times.unit)) {
  bool has_fill = false;
  for (size_t c = 0; c < channels.size(); ++c) {
    channels[c].name = s.channels[c].name.c_str(), channels[c].unit = text_or_null(s.channels[c].unit);
    has_fill |= s.channels[c].has_fill;
  }
  for (size_t a = 0; a < axes_.size(); ++a) {
    const Places& places = s.places[a];
    axis_units_[a] = utf8_of(places.unit);
    axes_[a] = sized<bccsplat_axis>();
    axes_[a].count = places.coordinates.size(), axes_[a].coordinates = places.coordinates.data();
    axes_[a].flags = places.down ? BCCSPLAT_AXIS_DOWN : 0;
    axes_[a].unit = text_or_null(axis_units_[a]);
  }
  options.channel_count = static_cast<uint32_t>(channels.size()), options.channels = channels.data();
  const auto by_channel = [&](const std::vector<double>& errors) {
    return !errors.empty() && errors.size() == channels.size() ? errors.data() : nullptr;
  };
  options.wavelet_errors = by_channel(mean_errors), options.abs_errors = by_channel(largest_errors);
  for (size_t a = 0; a < 4; ++a) options.dims[a] = static_cast<uint32_t>(s.dims[a]);
  std::copy(s.affine.begin(), s.affine.end(), options.affine);
  options.spatial_unit = text_or_null(spatial_unit_), options.time_unit = text_or_null(time_unit_);
  options.axes = has_coordinates(s) ? axes_.data() : nullptr;
  options.recommended_kernel = text_or_null(kernel);
  if (has_fill && options.nonfinite == BCCSPLAT_NONFINITE_DEFAULT)
    options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
}

} // namespace bccsplat::series

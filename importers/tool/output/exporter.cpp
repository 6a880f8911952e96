// SPDX-License-Identifier: Apache-2.0
// Samples a time slice at the source grid, plane by plane, and hands the values to the file of a format, or
// makes an OpenVDB grid that is like the source's own (vdb_origin.h). Values that are missing and become 0
// are counted.
#include "tool/output/exporter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tool/interrupt.h"
#include "tool/output/describe_volume.h"
#include "tool/output/export_type.h"
#include "tool/view/even_places.h"
#include "tool/view/render_function.h"
#include "tool/view/time_slice.h"
#if BCCSPLAT_WITH_OPENVDB
#include "tool/output/vdb_origin.h"
#endif

namespace bcc4 {
namespace {

uint64_t count_missing(std::span<const float> values) {
  return std::count_if(values.begin(), values.end(), [](float v) { return std::isnan(v); });
}

// Missing values (NaN) become what the file has for them, or 0 in integers, which is counted.
std::vector<std::byte> stored_values(std::span<const float> values, const VolumeOutput& output,
                                     uint64_t& holes) {
  std::vector<std::byte> bytes(values.size() * type_size(output.type));
  visit_type(output.type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 4)) {
      double low = -HUGE_VAL, high = HUGE_VAL;
      // Values that ring beyond their range are not to become the number of missing ones.
      if (std::is_integral_v<T> && output.fill) {
        low = static_cast<double>(std::numeric_limits<T>::min());
        high = static_cast<double>(std::numeric_limits<T>::max());
        (*output.fill == low ? ++low : --high);
      }
      for (size_t i = 0; i < values.size(); ++i) {
        const double value = std::isnan(values[i]) && output.fill
                                 ? *output.fill
                                 : std::clamp(static_cast<double>(values[i]), low, high);
        store_as<T>(value, bytes.data() + i * sizeof(T));
      }
    }
  });
  if (!is_float(output.type) && !output.fill) holes += count_missing(values);
  return bytes;
}

// Returns a number that is no value of the channel, for those that are missing; nothing where there is none.
std::optional<double> fill_of(Type type, const bccsplat_channel_info& channel) {
  constexpr double of_floats = 9.969209968386869e36; // NetCDF's own
  if (is_float(type)) return of_floats;
  if (channel.holes == 0 && channel.missing == 0) return std::nullopt;
  std::optional<double> fill;
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_integral_v<T>)
      for (const T end : {std::numeric_limits<T>::max(), std::numeric_limits<T>::min()})
        if (const auto value = static_cast<double>(end); value > channel.range[1] || value < channel.range[0])
          fill = value;
  });
  return fill;
}

} // namespace

Exporter::Exporter(const Volume& volume, uint32_t channel, const ExportOptions& options, StoredSites sites)
    : volume_(volume), channel_(channel), options_(options), sites_(std::move(sites)),
      info_(volume_info(volume)), channel_info_(channel_info(volume, channel)),
      type_(export_type(channel_info_)) {}

VolumeOutput Exporter::description() const {
  VolumeOutput o = describe_volume(volume_, channel_);
  o.type = type_;
  o.dims = region().dims;
  o.affine = affine();
  const SampleBox box = region();
  for (uint32_t a = 0; a < 3; ++a) {
    const bccsplat_axis axis = axis_info(volume_, a);
    if (axis.count == 0) continue;
    const double* const first = axis.coordinates + box.begin[a];
    o.coordinates[a].assign(first, first + box.dims[a]);
    o.coordinates_down[a] = (axis.flags & BCCSPLAT_AXIS_DOWN) != 0;
  }
  if (options_.format == ExportFormat::netcdf) o.fill = fill_of(type_, channel_info_);
  return o;
}

SampleBox Exporter::region() const {
  return options_.region.value_or(SampleBox{{0, 0, 0}, {info_.dims[0], info_.dims[1], info_.dims[2]}});
}

Affine Exporter::affine() const {
  Affine whole;
  std::copy(info_.affine, info_.affine + 16, whole.begin());
  if (!options_.region) return whole;
  std::array<double, 3> begin{};
  for (uint32_t i = 0; i < 3; ++i) {
    const double first = static_cast<double>(options_.region->begin[i]),
                 steps = static_cast<double>(options_.region->dims[i]) - 1;
    begin[i] = even_position(volume_, i, first);
    // An uneven axis gets even steps from the first sample of the box to the last.
    if (steps > 0 && axis_info(volume_, i).count > 0)
      for (size_t r = 0; r < 3; ++r)
        whole[4 * r + i] *= (even_position(volume_, i, first + steps) - begin[i]) / steps;
  }
  Affine moved = whole;
  for (size_t r = 0; r < 3; ++r)
    for (size_t i = 0; i < 3; ++i) moved[4 * r + 3] += info_.affine[4 * r + i] * begin[i];
  return moved;
}

double Exporter::written_index(double index) const {
  return channel_info(volume_, channel_).labels != 0 ? std::round(index) : index;
}

void Exporter::sample_frame(double index, const std::optional<SampleBox>& region,
                            const std::function<void(std::span<const float> values)>& take) {
  const SampleBox whole{{0, 0, 0}, {info_.dims[0], info_.dims[1], info_.dims[2]}},
      box = region.value_or(whole);
  if (region) check_region(*region, info_);
  std::vector<float> planes;
  const auto clear = [&](uint64_t first_plane, std::span<const float> values) {
    planes.assign(values.begin(), values.end());
    sites_.clear(index, box, first_plane, planes);
    take(planes);
  };
  bcc4::sample_frame(volume_, index, channel_, box, clear, options_.motion);
}

void Exporter::append_frame(VolumeFile& file, const VolumeOutput& output, double index) {
  sample_frame(index, options_.region,
               [&](std::span<const float> values) { file.write(stored_values(values, output, holes_)); });
}

void Exporter::write_frame(const std::string& path, const Cut& where) {
  if (options_.format == ExportFormat::vdb) {
    write_vdb_frame(path, where);
    return;
  }
  VolumeOutput output = description();
  output.times = {where.time};
  const auto file = create_volume_file(options_.format, path, output, options_.overwrite, options_.quiet);
  append_frame(*file, output, where.index);
  file->finish();
}

void Exporter::write_vdb_frame([[maybe_unused]] const std::string& path, [[maybe_unused]] const Cut& where) {
#if BCCSPLAT_WITH_OPENVDB
  VdbOutput o = vdb_like_source(volume_, channel_);
  std::vector<float> values;
  const auto take = [&](std::span<const float> planes) {
    values.insert(values.end(), planes.begin(), planes.end());
  };
  sample_frame(where.index, std::nullopt, take);
  keep_sparsity(volume_, channel_, where.index, values, o);
  if (options_.region) {
    values.clear();
    sample_frame(where.index, options_.region, take);
    for (size_t i = 0; i < 3; ++i) o.begin[i] += static_cast<int32_t>(options_.region->begin[i]);
  }
  holes_ += count_missing(values); // become background
  o.dims = region().dims;
  o.affine = affine();
  tell_time(volume_, where.time, o);
  o.overwrite = options_.overwrite;
  write_vdb(path, o, values);
#endif
}

void Exporter::write_series(const std::string& path, Progress& progress) {
  const uint64_t frames = info_.dims[3];
  VolumeOutput output = description();
  output.series = true;
  output.times.resize(frames);
  check(bccsplat_volume_get_times(volume_.get(), output.times.data(), frames, nullptr), "");
  const auto file = create_volume_file(options_.format, path, output, options_.overwrite, options_.quiet);
  for (uint64_t f = 0; f < frames; ++f) {
    stop_if_interrupted();
    append_frame(*file, output, static_cast<double>(f));
    progress.update(f + 1, concat("frame ", f + 1, "/", frames));
  }
  file->finish();
}

} // namespace bcc4

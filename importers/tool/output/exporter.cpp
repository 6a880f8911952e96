// SPDX-License-Identifier: Apache-2.0
// Samples a time slice at the source grid, plane by plane, and writes raw values, with or without an NRRD
// header before them, or an OpenVDB grid that is like the source's own (vdb_origin.h). Values that are
// missing and become 0 are counted.
#include "tool/output/exporter.h"

#include <algorithm>
#include <cmath>

#include "tool/interrupt.h"
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

// Little-endian values; NaN (missing data) becomes 0 in integers and is counted.
void append_values(OutputFile& file, std::span<const float> values, Type type, uint64_t& holes) {
  std::vector<std::byte> bytes(values.size() * type_size(type));
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 4))
      for (size_t i = 0; i < values.size(); ++i)
        store_as<T>(static_cast<double>(values[i]), bytes.data() + i * sizeof(T));
  });
  if (!is_float(type)) holes += count_missing(values);
  if constexpr (std::endian::native != std::endian::little) swap_bytes(bytes, type_size(type));
  file.write(bytes);
}

} // namespace

Exporter::Exporter(const Volume& volume, uint32_t channel, const ExportOptions& options)
    : volume_(volume), channel_(channel), options_(options), info_(volume_info(volume)),
      channel_info_(channel_info(volume, channel)), type_(export_type(channel_info_)) {}

NrrdOutput Exporter::header(bool series) const {
  NrrdOutput n;
  n.type = type_;
  n.content = channel_info_.name;
  n.sample_unit = channel_info_.unit;
  const SampleBox box = region();
  n.sizes.assign(box.dims.begin(), box.dims.end());
  n.affine = affine();
  n.spatial_unit = info_.spatial_unit;
  for (uint32_t a = 0; a < 3; ++a) {
    const bccsplat_axis axis = axis_info(volume_, a);
    if (axis.count == 0) continue;
    const double* const first = axis.coordinates + box.begin[a];
    n.coordinates[a].assign(first, first + box.dims[a]);
    n.coordinate_units[a] = axis.unit;
    n.coordinates_down[a] = (axis.flags & BCCSPLAT_AXIS_DOWN) != 0;
  }
  n.time_unit = info_.time_unit;
  const char* space = nullptr;
  if (bccsplat_volume_find_attribute(volume_.get(), "space", &space) == BCCSPLAT_OK) n.space = space;
  if (series) {
    n.sizes.push_back(info_.dims[3]);
    n.times.resize(info_.dims[3]);
    check(bccsplat_volume_get_times(volume_.get(), n.times.data(), n.times.size(), nullptr), "");
  }
  return n;
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
    // Of an uneven axis even steps from the first sample of the box to the last.
    if (steps > 0 && axis_info(volume_, i).count > 0)
      for (size_t r = 0; r < 3; ++r)
        whole[4 * r + i] *= (even_position(volume_, i, first + steps) - begin[i]) / steps;
  }
  Affine moved = whole;
  for (size_t r = 0; r < 3; ++r)
    for (size_t i = 0; i < 3; ++i) moved[4 * r + 3] += info_.affine[4 * r + i] * begin[i];
  return moved;
}

// Import keeps labels on their own grid, where frames come back as they are; what has few values and is
// smooth is on another one.
double Exporter::written_index(double index) const {
  if (index == std::round(index) || info_.lattice != BCCSPLAT_LATTICE_CC) return index;
  const bccsplat_look look = make_look(volume_, channel_, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_DEFAULT);
  return look.kind == BCCSPLAT_KIND_LABELS ? std::round(index) : index;
}

void Exporter::append_frame(OutputFile& file, double index) {
  // Of a periodic axis without sample 0 once more.
  sample_planes(
      cut_frame(volume_, index, channel_, options_.region),
      [&](uint64_t, std::span<const float> values) { append_values(file, values, type_, holes_); },
      SampleBox{{0, 0, 0}, region().dims});
}

void Exporter::write_frame(const std::string& path, const Cut& where) {
  if (options_.format == ExportFormat::vdb) {
    write_vdb_frame(path, where);
    return;
  }
  OutputFile file(path, options_.overwrite);
  if (options_.format == ExportFormat::nrrd) {
    NrrdOutput n = header(false);
    n.keys = time_keys(where.time, n.time_unit);
    const std::string text = nrrd_header_text(n);
    file.write(std::as_bytes(std::span(text)));
  }
  append_frame(file, where.index);
  file.finish();
}

void Exporter::write_vdb_frame([[maybe_unused]] const std::string& path, [[maybe_unused]] const Cut& where) {
#if BCCSPLAT_WITH_OPENVDB
  VdbOutput o = vdb_like_source(volume_, channel_);
  std::vector<float> values;
  const auto take = [&](uint64_t, std::span<const float> planes) {
    values.insert(values.end(), planes.begin(), planes.end());
  };
  const Slice slice = cut_frame(volume_, where.index, channel_);
  sample_planes(slice, take, SampleBox{{0, 0, 0}, {info_.dims[0], info_.dims[1], info_.dims[2]}});
  keep_sparsity(volume_, channel_, where.index, values, o);
  if (options_.region) {
    values.clear();
    sample_planes(slice, take, options_.region);
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
  OutputFile file(path, options_.overwrite);
  if (options_.format == ExportFormat::nrrd) {
    const std::string text = nrrd_header_text(header(true));
    file.write(std::as_bytes(std::span(text)));
  }
  for (uint64_t f = 0; f < frames; ++f) {
    stop_if_interrupted();
    append_frame(file, static_cast<double>(f));
    progress.update(f + 1, concat("frame ", f + 1, "/", frames));
  }
  file.finish();
}

} // namespace bcc4

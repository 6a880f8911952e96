// SPDX-License-Identifier: Apache-2.0
#include "tool/compare/sampled_series.h"

#include <cmath>
#include <limits>

#include "readers/places.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

class VolumeSeries : public SampledSeries {
 public:
  VolumeSeries(const Volume& volume, const std::string& file) : volume_(volume) {
    const bccsplat_volume_info v = volume_info(volume);
    name = file;
    std::copy(v.dims, v.dims + 3, dims.begin());
    std::copy(v.affine, v.affine + 16, affine.begin());
    for (uint32_t a = 0; a < 3; ++a) {
      const bccsplat_axis axis = axis_info(volume, a);
      if (axis.count > 1) even[a] = even_positions({axis.coordinates, axis.coordinates + axis.count});
    }
    units = axis_units(volume);
    space = told(volume, "space");
    clock = clock_of(volume);
    times.resize(v.dims[3]);
    check(bccsplat_volume_get_times(volume.get(), times.data(), times.size(), nullptr), file);
    for (uint32_t c = 0; c < v.channel_count; ++c) {
      const bccsplat_channel_info info = channel_info(volume, c);
      channels.push_back({info.name, info.unit});
    }
  }

  void read(uint64_t frame, uint32_t channel, const Take& take) override {
    std::vector<double> values;
    sample_frame(volume_, static_cast<double>(frame), channel, SampleBox{{0, 0, 0}, dims},
                 [&](uint64_t z, std::span<const float> planes) {
                   values.assign(planes.begin(), planes.end());
                   take(z, values);
                 });
  }

 private:
  const Volume& volume_;
};

class ReaderSeries : public SampledSeries {
 public:
  ReaderSeries(FrameReader& reader, const std::string& file, bool placed) : reader_(reader) {
    const SeriesDescription& d = reader.description();
    name = file;
    std::copy_n(d.dims.begin(), 3, dims.begin());
    affine = d.affine;
    for (size_t a = 0; a < 3; ++a) {
      if (d.places[a].coordinates.size() > 1) even[a] = even_positions(d.places[a].coordinates);
      units[a] = d.places[a].unit.empty() ? d.spatial_unit : d.places[a].unit;
    }
    space = told(d, "space");
    clock = clock_of(d);
    times = d.times.values;
    has_times = !times.empty() && !d.times.counted;
    for (uint64_t f = times.size(); f < d.dims[3]; ++f) times.push_back(static_cast<double>(f));
    has_place = placed || (d.format != "raw" && d.format != "TIFF");
    for (const Channel& c : d.channels) channels.push_back({c.name, c.unit});
  }

  void read(uint64_t frame, uint32_t channel, const Take& take) override {
    const SeriesDescription& d = reader_.description();
    const Frame values = reader_.read(frame, channel);
    std::vector<double> plane(dims[0] * dims[1]);
    for (uint64_t z = 0; z < dims[2]; ++z) {
      gather_plane(values, d.dims, z, d.channels[channel].air, plane.data());
      for (double& value : plane)
        if (!std::isfinite(static_cast<float>(value))) value = std::numeric_limits<double>::quiet_NaN();
      take(z, plane);
    }
  }

 private:
  FrameReader& reader_;
};

} // namespace

std::unique_ptr<SampledSeries> series_of_volume(const Volume& volume, const std::string& name) {
  return std::make_unique<VolumeSeries>(volume, name);
}

std::unique_ptr<SampledSeries> series_of_reader(FrameReader& reader, const std::string& name, bool placed) {
  return std::make_unique<ReaderSeries>(reader, name, placed);
}

} // namespace bcc4

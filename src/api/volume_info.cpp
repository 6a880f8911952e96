// SPDX-License-Identifier: Apache-2.0
// Tells a host what a file says of itself: lattice, levels, channels, times, attributes and sources.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/structs.h"
#include "volume/data_kind.h"
#include "volume/labels.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

template<class Map> void map_points(uint64_t n, const double* from, double* to, const Map& map) {
  if (n == 0) return;
  require(from, "from"), require(to, "to");
  require_count(n, sizeof(Vec3), "n");
  for (uint64_t i = 0; i < n; ++i) {
    const Vec3 p = map({from[3 * i], from[3 * i + 1], from[3 * i + 2]});
    std::copy(p.begin(), p.end(), to + 3 * i);
  }
}

} // namespace

extern "C" {

bccsplat_status bccsplat_volume_get_info(const bccsplat_volume* volume, bccsplat_volume_info* info) {
  return guard([&] {
    require(volume, "volume");
    const VolumeInfo& v = volume->file.info();
    bccsplat_volume_info out{};
    out.lattice = static_cast<int32_t>(v.lattice.kind);
    std::copy(v.lattice.dims.begin(), v.lattice.dims.end(), out.dims);
    out.cc_samples = v.cc_samples();
    out.sites_outside = v.lattice.sites_outside(0, v.lattice.layers());
    out.sites_total = v.lattice.sites() - out.sites_outside;
    out.layer_count = v.lattice.layers();
    out.scale = v.scale, out.time_scale = v.time_scale;
    const LatticeScales scales = v.lattice.scales();
    std::copy(scales.begin(), scales.end(), out.scales);
    std::copy(v.lattice.before.begin(), v.lattice.before.end(), out.planes_before);
    std::copy(v.lattice.behind.begin(), v.lattice.behind.end(), out.planes_behind);
    const Affine3& affine = volume->file.affine();
    for (size_t r = 0; r < 3; ++r) {
      for (size_t c = 0; c < 3; ++c) out.affine[4 * r + c] = affine.linear[r][c];
      out.affine[4 * r + 3] = affine.offset[r];
    }
    out.affine[15] = 1;
    out.time_first = v.time.at(0), out.time_last = v.time.at(v.lattice.dims[3] - 1);
    out.time_periodic = v.lattice.periodic;
    for (size_t a = 0; a < 3; ++a)
      if (v.lattice.turns(a)) out.periodic_axes |= 1u << a;
    out.time_end = volume->file.times().last();
    out.mean_voxel = std::cbrt(std::fabs(affine.determinant()));
    out.spatial_unit = v.spatial_unit.c_str(), out.time_unit = v.time.unit.c_str();
    out.kernel = volume->file.kernel().name.c_str(),
    out.recommended_kernel = volume->file.recommended_kernel().c_str();
    out.channel_count = static_cast<uint32_t>(v.channels.size());
    out.time_uniform = v.time.uniform;
    out.store = v.tile_edge > 1 ? BCCSPLAT_STORE_WAVELETS : BCCSPLAT_STORE_SAMPLES;
    for (const ChannelInfo& c : v.channels) out.has_holes |= c.holes > 0 || !c.masks.empty();
    const Bcc4Bytes& bytes = volume->file.reader()->bytes();
    out.bytes_file = bytes.file, out.bytes_runs = bytes.runs, out.bytes_values = bytes.values,
    out.bytes_index = bytes.index;
    out.bytes_read = volume->file.reader()->bytes_read();
    out.attribute_count = v.attributes.size();
    if (v.part) {
      out.part_first = v.part->block.first_frame(), out.part_end = v.part->block.end_frame();
      for (size_t a = 0; a < 3; ++a) {
        out.part_box_begin[a] = v.part->block.begin[a];
        out.part_box_end[a] = std::min(v.part->block.end[a], v.lattice.dims[a]);
      }
    }
    out.level_count = static_cast<uint32_t>(v.levels.size());
    if (v.unfinished) {
      out.frames_expected = std::max(v.expected_frames, v.lattice.dims[3]);
      out.series_state = v.expected_frames > 0 ? BCCSPLAT_SERIES_UNFINISHED : BCCSPLAT_SERIES_OPEN_END;
    }
    write_struct(info, out, "info");
  });
}

bccsplat_status bccsplat_volume_get_axis(const bccsplat_volume* volume, uint32_t axis, bccsplat_axis* info) {
  return guard([&] {
    require(volume, "volume");
    const auto& axes = volume->file.info().axes;
    if (axis >= axes.size()) fail(Code::not_found, "axis ", axis, ": space has 0, 1 and 2");
    const AxisInfo& a = axes[axis];
    bccsplat_axis out{};
    out.flags = a.down ? BCCSPLAT_AXIS_DOWN : 0;
    out.count = a.coordinates.size();
    out.coordinates = a.coordinates.empty() ? nullptr : a.coordinates.data();
    out.unit = a.unit.c_str();
    write_struct(info, out, "info");
  });
}

bccsplat_status bccsplat_volume_index_to_world(const bccsplat_volume* volume, uint64_t n, const double* from,
                                               double* to) {
  return guard([&] {
    require(volume, "volume");
    const Affine3& affine = volume->file.affine();
    map_points(n, from, to, [&](const Vec3& p) { return affine.point(volume->file.axes()->even_of(p)); });
  });
}

bccsplat_status bccsplat_volume_world_to_index(const bccsplat_volume* volume, uint64_t n, const double* from,
                                               double* to) {
  return guard([&] {
    require(volume, "volume");
    const Affine3 inverse = volume->file.affine().inverse();
    map_points(n, from, to, [&](const Vec3& p) { return volume->file.axes()->index_of(inverse.point(p)); });
  });
}

bccsplat_status bccsplat_volume_get_level_info(const bccsplat_volume* volume, uint32_t level,
                                               bccsplat_level_info* info) {
  return guard([&] {
    require(volume, "volume");
    const VolumeInfo& v = volume->file.info();
    if (level > v.levels.size())
      fail(Code::not_found, "level ", level, " of a file whose last one is ", v.levels.size());
    const Lattice4& lattice = v.level(level).lattice;
    bccsplat_level_info out{};
    const LatticeScales scales = lattice.scales();
    std::copy(scales.begin(), scales.end(), out.scales);
    out.layer_count = lattice.layers(), out.slab_layers = v.level(level).slab_layers;
    out.sites_total = lattice.sites() - lattice.sites_outside(0, lattice.layers());
    for (size_t c = 0; c < v.channels.size(); ++c)
      out.sites_kept += level == 0 ? v.channels[c].sites_kept : v.levels[level - 1].channels[c].sites_kept;
    out.bytes = volume->file.reader()->level_bytes(level);
    for (uint32_t c = 0; c < v.channels.size(); ++c)
      if (const MeasuredError* const e = find_error(v, c, level))
        out.relative_rmse = std::max(out.relative_rmse, e->rmse / e->range);
    write_struct(info, out, "info");
  });
}

bccsplat_status bccsplat_volume_get_channel_info(const bccsplat_volume* volume, uint32_t channel,
                                                 bccsplat_channel_info* info) {
  return guard([&] {
    require(volume, "volume");
    const ChannelInfo& c = volume->file.channel(channel);
    bccsplat_channel_info out{};
    out.value_type = static_cast<int32_t>(c.type);
    out.source_type = static_cast<int32_t>(c.source_type);
    out.labels = is_labels(volume->file, channel) ? 1 : 0;
    out.name = c.name.c_str(), out.unit = c.unit.c_str();
    out.air = c.air, out.air_threshold = c.threshold;
    out.value_scale = c.scale, out.value_offset = c.offset;
    out.range[0] = c.source_range.low, out.range[1] = c.source_range.high;
    out.kept_range[0] = c.kept_range.low, out.kept_range[1] = c.kept_range.high;
    out.percentile_2 = c.kept_range.low, out.percentile_998 = c.kept_range.high;
    for (const Percentile& p : c.percentiles) {
      if (p.percent == 2) out.percentile_2 = p.value;
      if (p.percent == 99.8) out.percentile_998 = p.value;
    }
    out.sites_kept = c.sites_kept, out.cc_relevant = c.cc_relevant, out.holes = c.holes;
    out.error_bound = c.residuals.bound, out.wavelet_error = c.wavelet_error;
    if (c.residuals.bound > 0) {
      const auto error = [&](MeasuredError::Kind kind) {
        const MeasuredError* const e = find_error(volume->file.info(), channel, 0, kind);
        return e ? std::pair(e->rmse, e->largest) : std::pair(0.0, 0.0);
      };
      std::tie(out.lattice_rmse, out.lattice_max_abs) = error(MeasuredError::stored);
      std::tie(out.rmse, out.max_abs) = error(MeasuredError::corrected);
    }
    if (const Corrections* const fix = volume->file.corrections(channel)) out.corrections = fix->count();
    if (const Masks* const masks = volume->file.masks(channel)) out.missing = masks->count();
    std::copy_n(c.histogram.begin(), std::min<size_t>(c.histogram.size(), 256), out.histogram);
    write_struct(info, out, "info");
  });
}

bccsplat_status bccsplat_volume_find_channel(const bccsplat_volume* volume, const char* name,
                                             uint32_t* channel) {
  return guard([&] {
    require(volume, "volume"), require(name, "name"), require(channel, "channel");
    const auto& channels = volume->file.info().channels;
    const auto it =
        std::find_if(channels.begin(), channels.end(), [&](const ChannelInfo& c) { return c.name == name; });
    if (it == channels.end()) fail(Code::not_found, "no channel named ", name, " in the file");
    *channel = static_cast<uint32_t>(it - channels.begin());
  });
}

bccsplat_status bccsplat_volume_get_times(const bccsplat_volume* volume, double* times, uint64_t capacity,
                                          uint64_t* count) {
  return guard([&] {
    require(volume, "volume");
    if (capacity > 0) require(times, "times");
    const uint64_t frames = volume->file.info().lattice.dims[3];
    for (uint64_t i = 0; i < std::min(capacity, frames); ++i) times[i] = volume->file.info().time.at(i);
    if (count) *count = frames;
  });
}

bccsplat_status bccsplat_volume_get_frame_ranges(const bccsplat_volume* volume, uint32_t channel,
                                                 double* ranges, uint64_t capacity, uint64_t* count) {
  return guard([&] {
    require(volume, "volume");
    const std::vector<Range>& frames = volume->file.channel(channel).frames;
    if (capacity > 0) require(ranges, "ranges");
    for (size_t i = 0; i < std::min<uint64_t>(capacity, frames.size()); ++i)
      ranges[2 * i] = frames[i].low, ranges[2 * i + 1] = frames[i].high;
    if (count) *count = frames.size();
  });
}

bccsplat_status bccsplat_volume_time_to_index(const bccsplat_volume* volume, double time, double* index) {
  return guard([&] {
    require(volume, "volume"), require(index, "index");
    *index = volume->file.times().index_of(time);
  });
}

bccsplat_status bccsplat_volume_index_to_time(const bccsplat_volume* volume, double index, double* time) {
  return guard([&] {
    require(volume, "volume"), require(time, "time");
    *time = volume->file.times().time_of(index);
  });
}

bccsplat_status bccsplat_volume_get_attribute(const bccsplat_volume* volume, uint64_t index, const char** key,
                                              const char** value) {
  return guard([&] {
    require(volume, "volume"), require(key, "key"), require(value, "value");
    const auto& attributes = volume->file.info().attributes;
    if (index >= attributes.size()) fail(Code::not_found, "attribute ", index, " of ", attributes.size());
    *key = attributes[index].first.c_str();
    *value = attributes[index].second.c_str();
  });
}

bccsplat_status bccsplat_volume_get_source(const bccsplat_volume* volume, uint64_t index, const char** name,
                                           uint64_t* bytes, uint32_t* crc32) {
  return guard([&] {
    require(volume, "volume");
    const auto& sources = volume->file.info().sources;
    if (index >= sources.size()) fail(Code::not_found, "source ", index, " of ", sources.size());
    if (name) *name = sources[index].name.c_str();
    if (bytes) *bytes = sources[index].bytes;
    if (crc32) *crc32 = sources[index].crc32;
  });
}

bccsplat_status bccsplat_volume_find_attribute(const bccsplat_volume* volume, const char* key,
                                               const char** value) {
  return guard([&] {
    require(volume, "volume"), require(key, "key"), require(value, "value");
    for (const auto& [k, v] : volume->file.info().attributes)
      if (k == key) {
        *value = v.c_str();
        return;
      }
    if (const char* const kind = found_kind(volume->file, key)) {
      *value = kind;
      return;
    }
    fail(Code::not_found, "no attribute named ", key);
  });
}

} // extern "C"

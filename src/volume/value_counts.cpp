// SPDX-License-Identifier: Apache-2.0
#include "volume/value_counts.h"

#include <algorithm>

#include "formats/bcc4/labels_attribute.h"
#include "shade/gradient_noise.h"
#include "volume/data_kind.h"

namespace bccsplat {

ValueCounts value_counts(const OpenVolume& volume, uint32_t channel) {
  const ChannelInfo& c = volume.channel(channel);
  const VolumeInfo& v = volume.info();
  ValueCounts counts;
  counts.bins = c.histogram;
  counts.stored = c.histogram_range, counts.source = c.source_range;
  if (c.histogram.empty() && c.sites_kept > 0) // a file may leave it out: all values are alike then
    counts.bins.assign(256, c.sites_kept / 256 + 1), counts.stored = c.kept_range;
  if (counts.source.low == 0 && counts.source.high == 0) counts.source = counts.stored; // not known
  counts.air = c.air;
  counts.incomplete = c.holes > 0 || !c.masks.empty();
  uint64_t seen = 0;
  for (const uint64_t n : counts.bins) seen += n;
  const uint64_t all = v.lattice.sites() - v.lattice.sites_outside(0, v.lattice.layers());
  // What is missing is in no bin either. A few sites that are not stored are those of a field that has air's
  // value among others.
  if (!counts.incomplete && all > seen && (all - seen) * 256 >= all) counts.air_sites = all - seen;
  const SourceType t = c.source_type;
  counts.integers = t == SourceType::u8 || t == SourceType::i8 || t == SourceType::u16 ||
                    t == SourceType::i16 || t == SourceType::u32 || t == SourceType::i32;
  // Steps of half a number to a whole one do not tell which number a sample is of.
  counts.exact = is_float(c.type) || c.scale == 1 || c.scale < 0.5;
  if (!is_float(c.type) && c.scale < 0.5) counts.rounding = 0.5 * c.scale;
  counts.voxels = 1;
  for (size_t a = 0; a < 3; ++a) counts.voxels *= v.lattice.dims[a];
  for (const auto& [key, value] : v.attributes)
    if (key == "openvdb.class." + c.name) counts.level_set = value == "level set";
  counts.labels = said_labels(v, c.name);
  counts.data = kind_of_data(v, c, counts);
  return counts;
}

GradientNoise channel_noise(const OpenVolume& volume, uint32_t channel) {
  const ValueCounts counts = value_counts(volume, channel);
  const ChannelInfo& info = volume.channel(channel);
  double step = is_float(info.type) ? 0 : info.scale;
  if (counts.integers) step = std::max(step, 1.0);
  return gradient_noise(survey_values(counts), step, info.threshold);
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "api/look.h"

#include <algorithm>

#include "api/structs.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace bccsplat::api {

ValueCounts value_counts(const bccsplat_volume& volume, uint32_t channel) {
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
  counts.voxels = 1;
  for (size_t a = 0; a < 3; ++a) counts.voxels *= v.lattice.dims[a];
  for (const auto& [key, value] : v.attributes)
    if (key == "openvdb.class." + c.name) counts.level_set = value == "level set";
  return counts;
}

} // namespace bccsplat::api

bccsplat_status bccsplat_volume_get_look(const bccsplat_volume* volume, uint32_t channel, int32_t look,
                                         int32_t mode, bccsplat_look* out) {
  return guard([&] {
    require(volume, "volume");
    if (look < 0 || look > BCCSPLAT_LOOK_LABELS) fail(Code::invalid_argument, "look ", look);
    if (mode < 0 || mode > BCCSPLAT_MODE_MAXIMUM) fail(Code::invalid_argument, "look: mode ", mode);
    const ValueCounts counts = value_counts(*volume, channel);
    const auto wanted = static_cast<Look>(look);
    const ValueSurvey survey = survey_for(counts, wanted);
    const TransferFunction f =
        look_function(survey, wanted,
                      mode == BCCSPLAT_MODE_DEFAULT ? RenderMode::composite : static_cast<RenderMode>(mode));
    bccsplat_look made{};
    made.kind = static_cast<int32_t>(survey.kind);
    made.empty[0] = survey.empty.low, made.empty[1] = survey.empty.high;
    made.range[0] = survey.colors.low, made.range[1] = survey.colors.high;
    made.iso_value = survey.boundary;
    made.color_count = static_cast<uint32_t>(std::min(f.colors.size(), std::size(made.colors)));
    made.opacity_count = static_cast<uint32_t>(std::min(f.opacities.size(), std::size(made.opacities)));
    for (uint32_t i = 0; i < made.color_count; ++i) {
      made.colors[i][0] = f.colors[i].value;
      for (size_t a = 0; a < 3; ++a) made.colors[i][a + 1] = f.colors[i].color[a];
    }
    for (uint32_t i = 0; i < made.opacity_count; ++i)
      made.opacities[i][0] = f.opacities[i].value, made.opacities[i][1] = f.opacities[i].opacity;
    write_struct(out, made, "out");
  });
}

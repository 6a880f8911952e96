// SPDX-License-Identifier: Apache-2.0
#include "tool/output/describe_volume.h"

#include "readers/records.h"

namespace bcc4 {

VolumeOutput describe_volume(const Volume& volume, uint32_t channel) {
  const bccsplat_volume_info v = volume_info(volume);
  const bccsplat_channel_info c = channel_info(volume, channel);
  VolumeOutput o;
  o.name = c.name;
  o.unit = c.unit;
  o.space = told(volume, "space");
  o.spatial_unit = v.spatial_unit;
  o.axis_units = axis_units(volume);
  for (size_t a = 0; a < o.axis_records.size(); ++a) o.axis_records[a] = told(volume, axis_record(a).c_str());
  o.record = told(volume, channel_record(c.name).c_str());
  o.time_unit = v.time_unit;
  o.epoch = told(volume, "time_epoch");
  o.calendar = told(volume, "time_calendar");
  return o;
}

} // namespace bcc4

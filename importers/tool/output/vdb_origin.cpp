// SPDX-License-Identifier: Apache-2.0
#include "tool/output/vdb_origin.h"

#include <algorithm>
#include <cmath>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr double farthest = 1 << 30; // index that a box may begin at

std::optional<std::string> attribute(const Volume& volume, const std::string& key) {
  const char* value = nullptr;
  if (bccsplat_volume_find_attribute(volume.get(), key.c_str(), &value) != BCCSPLAT_OK) return std::nullopt;
  return value;
}

} // namespace

VdbOutput vdb_like_source(const Volume& volume, uint32_t channel) {
  const bccsplat_channel_info info = channel_info(volume, channel);
  VdbOutput o;
  o.grid = attribute(volume, concat("openvdb.name.", info.name)).value_or(info.name);
  o.grid_class = lower(trim(attribute(volume, concat("openvdb.class.", info.name)).value_or(o.grid_class)));
  o.air = static_cast<float>(info.air);
  const auto [low, high] = std::minmax({info.range[0], info.range[1]});
  o.range = {std::min(static_cast<float>(low), o.air), std::max(static_cast<float>(high), o.air)};
  o.as_double = attribute(volume, concat("openvdb.type.", info.name)).value_or("") == "double";
  if (const auto begin = attribute(volume, "openvdb.begin")) {
    const auto numbers = parse_numbers(split(*begin));
    for (size_t a = 0; a < 3 && numbers && numbers->size() == 3; ++a)
      o.begin[a] = static_cast<int32_t>(std::clamp((*numbers)[a], -farthest, farthest));
  }
  o.as_half = info.source_type == BCCSPLAT_TYPE_F16;
  o.told.value_unit = info.unit;
  o.told.space_unit = volume_info(volume).spatial_unit;
  return o;
}

void tell_time(const Volume& volume, double time, VdbOutput& output) {
  output.told.time = time;
  output.told.time_unit = volume_info(volume).time_unit;
}

void keep_sparsity(const Volume& volume, uint32_t channel, double index, std::span<const float> values,
                   VdbOutput& output) {
  const auto text = attribute(volume, concat("openvdb.active.", channel_info(volume, channel).name));
  if (!text) return;
  const auto words = split(*text);
  const auto counts = parse_numbers(words);
  if (!counts || counts->size() != volume_info(volume).dims[3]) return;
  const bool periodic = volume_info(volume).time_periodic != 0;
  const size_t frames = counts->size(), before = static_cast<size_t>(index) % frames; // at the end 0 again
  const size_t after = periodic ? (before + 1) % frames : std::min(before + 1, frames - 1);
  const double part = index - std::floor(index);
  const double count = (1 - part) * (*counts)[before] + part * (*counts)[after];
  output.all_active = count >= static_cast<double>(values.size());
  output.least = least_distance(output, values, std::llround(count));
}

} // namespace bcc4

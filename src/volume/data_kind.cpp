// SPDX-License-Identifier: Apache-2.0
#include "volume/data_kind.h"

#include <array>
#include <cmath>

namespace bccsplat {
namespace {

using series::DataFacts;

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

bool holds_any(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words)
    if (text.find(word) != std::string::npos) return true;
  return false;
}

std::string told(const VolumeInfo& v, const std::string& key) {
  for (const auto& [name, value] : v.attributes)
    if (name == key) return value;
  return {};
}

// Whether x and y are in degrees: as the file says it of the world, of uneven axes, or of its source's.
bool in_degrees(const VolumeInfo& v) {
  for (size_t a = 0; a < 2; ++a)
    if (!lower(v.spatial_unit).starts_with("degree") && !lower(v.axes[a].unit).starts_with("degree") &&
        !holds_any(told(v, a == 0 ? "axis.x" : "axis.y"), {"\"units\":\"degree"}))
      return false;
  return true;
}

// Whether a world has names for its sides, as those of NRRD.
bool has_sides(const std::string& space) {
  return holds_any(space, {"right-anterior", "left-anterior", "left-posterior"}) || space == "ras" ||
         space == "rast" || space == "las" || space == "last" || space == "lps" || space == "lpst";
}

bool has_sizes(const VolumeInfo& v) {
  constexpr double near_one = 1e-6;
  if (!v.spatial_unit.empty()) return true;
  for (size_t a = 0; a < 3; ++a) {
    Vec3 axis{};
    axis[a] = 1;
    if (std::fabs(length(v.affine.vector(axis)) - 1) > near_one) return true;
  }
  return false;
}

} // namespace

series::DataKind kind_of_data(const VolumeInfo& v, const ChannelInfo& c, const ValueCounts& counts) {
  const ValueSurvey survey = survey_values(counts);
  DataFacts f;
  f.told = told(v, series::kind_attribute(c.name));
  f.labels = survey.kind == ValueKind::labels;
  f.fog = told(v, "openvdb.class." + c.name) == "fog volume";
  f.flame = holds_any(lower(told(v, "openvdb.name." + c.name)), {"flame", "fire", "heat", "temperature"});
  f.degrees = in_degrees(v);
  f.sides = has_sides(lower(told(v, "space")));
  f.sized = has_sizes(v);
  f.whole = counts.integers;
  f.both_signs = survey.kind == ValueKind::both_signs;
  f.unit = c.unit;
  f.low = counts.source.low;
  if (survey.kind == ValueKind::solid) f.air = survey.background, f.tissue = survey.object;
  return series::data_kind(f);
}

const char* found_kind(const OpenVolume& volume, std::string_view key) {
  for (uint32_t c = 0; c < volume.info().channels.size(); ++c)
    if (key == series::kind_attribute(volume.channel(c).name)) {
      const series::DataKind kind = value_counts(volume, c).data;
      return kind == series::DataKind::unknown ? nullptr : name_of(kind).data();
    }
  return nullptr;
}

} // namespace bccsplat

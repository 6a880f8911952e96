// SPDX-License-Identifier: Apache-2.0
#include "tool/output/vdb_output.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "tool/output/output_file.h"
#include "tool/output/vdb_writer.h"

namespace bcc4 {

float least_distance(const VdbOutput& o, std::span<const float> values, uint64_t count) {
  if (count == 0) return std::numeric_limits<float>::infinity();
  if (count > values.size()) return 0;
  std::vector<float> distances;
  distances.reserve(values.size());
  for (const float v : values)
    distances.push_back(distance_from_air(o, std::clamp(v, o.range[0], o.range[1])));
  const auto nth = distances.begin() + (count - 1);
  std::nth_element(distances.begin(), nth, distances.end(), std::greater<>());
  return *nth;
}

void write_vdb(const std::string& path, const VdbOutput& o, std::span<const float> values) {
  OutputFile file(path, o.overwrite);
  write_vdb_grid(file.stream(), path, o, values);
  file.finish();
}

} // namespace bcc4

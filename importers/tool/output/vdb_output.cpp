// SPDX-License-Identifier: Apache-2.0
#include "tool/output/vdb_output.h"

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "readers/error.h"
#include "tool/output/output_file.h"

namespace bcc4 {

namespace {

bool is_level_set(const VdbOutput& o) {
  return openvdb::GridBase::stringToGridClass(o.grid_class) == openvdb::GRID_LEVEL_SET;
}

// The grid is made by name, in OpenVDB: made here it has all of the tree's code compiled once more.
openvdb::FloatGrid::Ptr empty_grid(float background) {
  auto grid =
      openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::GridBase::createGrid(openvdb::FloatGrid::gridType()));
  grid->tree().root().setBackground(background, false);
  return grid;
}

openvdb::FloatGrid::Ptr make_grid(const VdbOutput& o, std::span<const float> values) {
  openvdb::FloatGrid::Ptr grid = empty_grid(o.air);
  auto accessor = grid->getAccessor();
  const auto nx = static_cast<int32_t>(o.dims[0]), ny = static_cast<int32_t>(o.dims[1]),
             nz = static_cast<int32_t>(o.dims[2]);
  const bool level_set = is_level_set(o);
  size_t i = 0;
  for (int32_t z = 0; z < nz; ++z)
    for (int32_t y = 0; y < ny; ++y)
      for (int32_t x = 0; x < nx; ++x, ++i) {
        const float value = std::clamp(values[i], o.range[0], o.range[1]),
                    distance = distance_from_air(o, value);
        if (distance > 0 && distance >= o.least)
          accessor.setValue(openvdb::Coord(x, y, z), value);
        else if (level_set && value < 0)
          accessor.setValueOff(openvdb::Coord(x, y, z), -o.air);
      }
  grid->setGridClass(openvdb::GridBase::stringToGridClass(o.grid_class));
  grid->setName(o.grid);
  grid->setSaveFloatAsHalf(o.as_half);
  openvdb::tools::prune(grid->tree());
  return grid;
}

// What OpenVDB's own file writes, into a stream that can be asked whether all of it arrived: of a full disk
// that file tells nothing.
struct StreamArchive : openvdb::io::Archive {
  void write_grid(std::ostream& stream, const openvdb::GridBase::ConstPtr& grid) const {
    constexpr bool seekable = true;
    write(stream, {grid}, seekable);
  }
};

} // namespace

float distance_from_air(const VdbOutput& o, float value) {
  if (std::isnan(value)) return 0;
  return is_level_set(o) ? o.air - std::fabs(value) : std::fabs(value - o.air);
}

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
  openvdb::initialize();
  openvdb::FloatGrid::Ptr grid = make_grid(o, values);
  openvdb::Mat4R m; // row vectors: the transpose of ours
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) m(row, column) = o.affine[column * 4 + row];
  grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
  grid->insertMeta("time", openvdb::DoubleMetadata(o.time));
  try {
    StreamArchive().write_grid(file.stream(), grid);
  } catch (const openvdb::Exception& e) {
    fail_input(path, ": OpenVDB cannot write it: ", e.what());
  }
  file.finish();
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
#include "tool/output/vdb_writer.h"

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>

#include "readers/error.h"

namespace bcc4 {
namespace {

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

void write_vdb_grid(std::ostream& stream, const std::string& path, const VdbOutput& o,
                    std::span<const float> values) {
  openvdb::initialize();
  openvdb::FloatGrid::Ptr grid = make_grid(o, values);
  openvdb::Mat4R m; // row vectors: the transpose of ours
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) m(row, column) = o.affine[column * 4 + row];
  grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
  if (o.told.time) grid->insertMeta("time", openvdb::DoubleMetadata(*o.told.time));
  for (const auto& [name, text] : vdb_texts)
    if (!(o.told.*text).empty()) grid->insertMeta(name, openvdb::StringMetadata(o.told.*text));
  try {
    StreamArchive().write_grid(stream, grid);
  } catch (const openvdb::Exception& e) {
    fail_input(path, ": OpenVDB cannot write it: ", e.what());
  }
}

} // namespace bcc4

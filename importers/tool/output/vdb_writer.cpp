// SPDX-License-Identifier: Apache-2.0
#include "tool/output/vdb_writer.h"

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>

#include "readers/error.h"

namespace bcc4 {
namespace {

// The grid is made by name, in OpenVDB: made here it has all of the tree's code compiled once more.
template<class Grid> typename Grid::Ptr empty_grid(float background) {
  auto grid = openvdb::gridPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
  grid->tree().root().setBackground(background, false);
  return grid;
}

template<class Grid> void set_voxels(Grid& grid, const VdbOutput& o, std::span<const float> values) {
  auto accessor = grid.getAccessor();
  const auto nx = static_cast<int32_t>(o.dims[0]), ny = static_cast<int32_t>(o.dims[1]),
             nz = static_cast<int32_t>(o.dims[2]);
  const openvdb::Coord begin(o.begin[0], o.begin[1], o.begin[2]);
  const bool level_set = is_level_set(o);
  size_t i = 0;
  for (int32_t z = 0; z < nz; ++z)
    for (int32_t y = 0; y < ny; ++y)
      for (int32_t x = 0; x < nx; ++x, ++i) {
        const openvdb::Coord at = begin + openvdb::Coord(x, y, z);
        const float value = std::clamp(values[i], o.range[0], o.range[1]),
                    distance = distance_from_air(o, value);
        if (o.all_active ? !std::isnan(value) : distance > 0 && distance >= o.least)
          accessor.setValue(at, value);
        else if (level_set && value < 0)
          accessor.setValueOff(at, -o.air);
      }
  openvdb::tools::prune(grid.tree());
}

template<class Grid> openvdb::GridBase::Ptr make_grid(const VdbOutput& o, std::span<const float> values) {
  typename Grid::Ptr grid = empty_grid<Grid>(o.air);
  set_voxels(*grid, o, values);
  grid->setGridClass(openvdb::GridBase::stringToGridClass(o.grid_class));
  grid->setName(o.grid);
  grid->setSaveFloatAsHalf(o.as_half);
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
  const openvdb::GridBase::Ptr grid =
      o.as_double ? make_grid<openvdb::DoubleGrid>(o, values) : make_grid<openvdb::FloatGrid>(o, values);
  const Affine affine =
      moved_origin(o.affine, {-static_cast<double>(o.begin[0]), -static_cast<double>(o.begin[1]),
                              -static_cast<double>(o.begin[2])});
  openvdb::Mat4R m; // row vectors: the transpose of ours
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) m(row, column) = affine[column * 4 + row];
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

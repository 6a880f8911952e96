// SPDX-License-Identifier: Apache-2.0
// OpenVDB grids for the end-to-end tests: vdb_probe make FILE sphere|dense|AT writes one, vdb_probe FILE
// tells of each grid of floats or doubles, as JSON, what a reader of the file sees.
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace {

// A ball with a sharp edge, densities from 0.001 in a world that is stretched; `at` moves it.
openvdb::FloatGrid::Ptr fog(double at) {
  // Made by name, in OpenVDB: create() has the code of the whole tree compiled here once more.
  const auto grid =
      openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::GridBase::createGrid(openvdb::FloatGrid::gridType()));
  auto accessor = grid->getAccessor();
  for (int z = -20; z <= 20; ++z)
    for (int y = -20; y <= 20; ++y)
      for (int x = -20; x <= 20; ++x) {
        const double r = std::sqrt((x - at) * (x - at) + y * y + z * z);
        if (r < 11 + at / 4)
          accessor.setValue({x, y, z}, static_cast<float>(0.001 + 3 * std::fabs(std::sin(x + y))));
      }
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
  return grid;
}

// Doubles, all active in a box that does not begin at 0, most of them the background.
openvdb::DoubleGrid::Ptr dense() {
  const auto grid = openvdb::gridPtrCast<openvdb::DoubleGrid>(
      openvdb::GridBase::createGrid(openvdb::DoubleGrid::gridType()));
  auto accessor = grid->getAccessor();
  for (int z = 0; z < 32; ++z)
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) accessor.setValue({x - 5, y + 7, z + 100}, x < 3 && y < 4 ? 1.5 : 0);
  grid->setName("dense");
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  return grid;
}

void make(const std::string& path, const std::string& kind) {
  if (kind == "dense") return openvdb::io::File(path).write({dense()});
  openvdb::FloatGrid::Ptr grid;
  if (kind == "sphere") { // without a name
    grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(9.f, openvdb::Vec3f(3, -4, 5), 0.5f, 3.f);
  } else {
    grid = fog(std::stod(kind));
    grid->setName("soot");
    grid->setSaveFloatAsHalf(true);
  }
  openvdb::io::File(path).write({grid});
}

template<class Grid> void tell_grid(const Grid& grid) {
  double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
  for (auto v = grid.cbeginValueOn(); v; ++v)
    low = std::min(low, static_cast<double>(*v)), high = std::max(high, static_cast<double>(*v));
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  const openvdb::Vec3d middle = grid.indexToWorld(0.5 * (box.min().asVec3d() + box.max().asVec3d()));
  std::printf(
      "{\"name\": \"%s\", \"class\": \"%s\", \"active\": %llu, \"background\": %.9g, \"low\": %.9g, "
      "\"high\": %.9g, \"half\": %d, \"middle\": [%.9g, %.9g, %.9g], \"inside\": %.9g, \"type\": \"%s\", "
      "\"box\": [%d, %d, %d, %d, %d, %d], \"voxel\": %.9g}\n",
      grid.getName().c_str(), openvdb::GridBase::gridClassToString(grid.getGridClass()).c_str(),
      static_cast<unsigned long long>(grid.activeVoxelCount()), static_cast<double>(grid.background()), low,
      high, grid.saveFloatAsHalf() ? 1 : 0, middle[0], middle[1], middle[2],
      static_cast<double>(
          grid.tree().getValue(openvdb::Coord::round(0.5 * (box.min().asVec3d() + box.max().asVec3d())))),
      grid.valueType().c_str(), box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(),
      box.max().z(), grid.voxelSize()[0]);
}

void tell(const std::string& path) {
  openvdb::io::File file(path);
  file.open();
  const openvdb::GridPtrVecPtr grids = file.getGrids();
  for (const auto& base : *grids) {
    if (const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(base)) tell_grid(*grid);
    if (const auto grid = openvdb::gridPtrCast<openvdb::DoubleGrid>(base)) tell_grid(*grid);
  }
}

} // namespace

int main(int count, char** arguments) {
  openvdb::initialize();
  if (count == 4)
    make(arguments[2], arguments[3]);
  else
    tell(arguments[1]);
}

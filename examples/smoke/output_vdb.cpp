// SPDX-License-Identifier: Apache-2.0
#include "smoke/output.h"

#ifdef SMOKE_WITH_OPENVDB
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#endif

#include <stdexcept>

namespace smoke {

#ifdef SMOKE_WITH_OPENVDB

const bool has_vdb = true;

void write_vdb(const std::filesystem::path& path, const Grid& grid, double voxel, bool half) {
  openvdb::initialize();
  // LayoutXYZ is x fastest; copyFromDense only reads.
  const openvdb::CoordBBox box({0, 0, 0}, {grid.nx - 1, grid.ny - 1, grid.nz - 1});
  const openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(
      box, const_cast<float*>(grid.samples.data()));
  // Made by name, in OpenVDB: create() has the code of the whole tree compiled here once more.
  const auto fog =
      openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::GridBase::createGrid(openvdb::FloatGrid::gridType()));
  openvdb::tools::copyFromDense(dense, *fog, 0.0f);
  fog->setName("density");
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  fog->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
  fog->setSaveFloatAsHalf(half);
  try {
    openvdb::io::File file(path.string());
    file.write(openvdb::GridCPtrVec{fog});
    file.close();
  } catch (const openvdb::Exception& e) {
    throw std::runtime_error("cannot write " + path.string() + ": " + e.what());
  }
}

#else

const bool has_vdb = false;

void write_vdb(const std::filesystem::path&, const Grid&, double, bool) {
  throw std::runtime_error("built without OpenVDB");
}

#endif

} // namespace smoke

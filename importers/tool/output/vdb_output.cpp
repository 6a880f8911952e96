#include "tool/output/vdb_output.h"

#include <openvdb/openvdb.h>

#include <cmath>
#include <filesystem>

#include "readers/error.h"
#include "tool/output/output_file.h"

namespace bcc4 {

void write_vdb(const std::string& path, const VdbOutput& o, std::span<const float> values) {
  refuse_existing(path, o.overwrite);
  openvdb::initialize();
  const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(o.air);
  auto accessor = grid->getAccessor();
  const auto nx = static_cast<int32_t>(o.dims[0]), ny = static_cast<int32_t>(o.dims[1]),
             nz = static_cast<int32_t>(o.dims[2]);
  size_t i = 0;
  for (int32_t z = 0; z < nz; ++z)
    for (int32_t y = 0; y < ny; ++y)
      for (int32_t x = 0; x < nx; ++x, ++i)
        if (values[i] != o.air && !std::isnan(values[i]))
          accessor.setValue(openvdb::Coord(x, y, z), values[i]);
  openvdb::Mat4R m; // row vectors: the transpose of ours
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      m(row, column) = o.affine[static_cast<size_t>(column * 4 + row)];
  grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
  grid->setName(o.grid);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->insertMeta("time", openvdb::DoubleMetadata(o.time));
  const std::string partial = partial_path(path);
  try {
    openvdb::io::File file(partial);
    file.write({grid});
    file.close();
  } catch (const std::exception& e) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    fail_input(path, ": OpenVDB cannot write it: ", e.what());
  }
  rename_finished(partial, path);
}

} // namespace bcc4

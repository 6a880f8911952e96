// SPDX-License-Identifier: Apache-2.0
// Reads scalar grids of OpenVDB files: names and bounds from metadata alone where a file has them, voxels as
// boxes of the blocks that hold anything but background.
#include "readers/vdb/vdb_grid.h"

#include <openvdb/openvdb.h>
#ifndef OPENVDB_USE_EXPLICIT_INSTANTIATION
#include <openvdb/tools/LevelSetUtil.h>
#endif

#include <algorithm>
#include <cstring>
#include <limits>

#include "readers/byte_stream.h"
#include "readers/error.h"
#include "readers/vdb/block_boxes.h"
#include "readers/vdb/vdb_reader.h"

#ifdef OPENVDB_USE_EXPLICIT_INSTANTIATION
// The library holds this function for the grids of floats: it is declared here, because the header that
// defines it takes as long to compile as the rest of this file.
namespace openvdb::OPENVDB_VERSION_NAME::tools {
template<class GridType> void sdfToFogVolume(GridType& grid, typename GridType::ValueType cutoffDistance);
} // namespace openvdb::OPENVDB_VERSION_NAME::tools
#endif

namespace bcc4 {
namespace {

using Scalars = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid,
                                  openvdb::Int64Grid, openvdb::BoolGrid>;

constexpr int32_t kBlock = 8;                        // voxels, the leaf size of the standard trees
constexpr int32_t kBoxBlocks = 8;                    // boxes of at most 64 voxels a side
constexpr uint64_t kExtentLimit = uint64_t{1} << 33; // blocks of the bounding box

template<class T> constexpr Type box_type() {
  if constexpr (std::is_same_v<T, float>)
    return Type::f32;
  else if constexpr (std::is_same_v<T, int32_t>)
    return Type::i32;
  else if constexpr (std::is_same_v<T, bool>)
    return Type::u8;
  else
    return Type::f64; // double, int64
}

} // namespace

// A file as OpenVDB has it, with its exceptions turned into ours.
class VdbFile::Archive {
 public:
  explicit Archive(const std::string& path) : path_(path), file_(path) {
    openvdb::initialize();
    (void)file_size(path);
    guard([&] { file_.open(false); });
  }
  [[nodiscard]] const std::string& path() const { return path_; }
  template<class F> void guard(F&& f) {
    try {
      f();
    } catch (const openvdb::Exception& e) {
      fail_input(path_, ": OpenVDB cannot read it: ", e.what());
    } catch (const std::bad_alloc&) {
      fail_resources(path_, ": out of memory while OpenVDB reads it; a damaged file may ask for any amount");
    }
  }
  std::vector<std::string> names() {
    std::vector<std::string> out;
    guard([&] {
      for (auto i = file_.beginName(); i != file_.endName(); ++i) out.push_back(i.gridName());
    });
    return out;
  }
  openvdb::GridBase::Ptr metadata(const std::string& name) {
    openvdb::GridBase::Ptr grid;
    guard([&] { grid = file_.readGridMetadata(name); });
    return grid;
  }
  openvdb::GridBase::Ptr grid(const std::string& name) {
    openvdb::GridBase::Ptr grid;
    guard([&] { grid = file_.readGrid(name); });
    return grid;
  }

  // Reads the tree without the values of its leaves, for metadata alone do not hold the background.
  openvdb::GridBase::Ptr topology(const std::string& name) {
    openvdb::GridBase::Ptr grid;
    const openvdb::Vec3d nowhere(1e30);
    guard([&] { grid = file_.readGrid(name, openvdb::BBoxd(nowhere, nowhere)); });
    return grid;
  }

 private:
  std::string path_;
  openvdb::io::File file_;
};

namespace {

bool is_points(const openvdb::GridBase& grid) {
  return grid.type().find("ptdata") != std::string::npos || grid.type().find("ptidx") != std::string::npos;
}
bool is_scalar(const openvdb::GridBase& grid) {
  return !is_points(grid) && grid.apply<Scalars>([](const auto&) {});
}

VdbBounds bounds_of(const openvdb::CoordBBox& box) {
  VdbBounds b;
  if (box.empty()) return b;
  for (int a = 0; a < 3; ++a) {
    b.begin[a] = box.min()[a];
    b.end[a] = box.max()[a] == INT32_MAX ? INT32_MAX : box.max()[a] + 1;
  }
  return b;
}

VdbTold told_by(const openvdb::GridBase& grid) {
  VdbTold told;
  if (const auto d = grid.getMetadata<openvdb::DoubleMetadata>("time"))
    told.time = d->value();
  else if (const auto f = grid.getMetadata<openvdb::FloatMetadata>("time"))
    told.time = f->value();
  else if (const auto i = grid.getMetadata<openvdb::Int32Metadata>("time"))
    told.time = i->value();
  for (const auto& [name, text] : vdb_texts)
    if (const auto m = grid.getMetadata<openvdb::StringMetadata>(name)) told.*text = m->value();
  return told;
}

void require_name(const std::string& path, const std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  std::vector<std::string> numbered;
  for (const std::string& n : names)
    if (n.starts_with(name + "[")) numbered.push_back(n);
  if (!numbered.empty())
    fail_usage(path, ": several grids are called \"", name, "\": choose one of ", join(numbered));
  fail_usage(path, ": no grid \"", name, "\"", did_you_mean(name, names),
             names.empty() ? "; it has none" : concat("; it has ", join(names)));
}

// Copies a box of blocks out of the tree, x fastest.
template<class GridT> struct BoxCopier {
  using Value = typename GridT::ValueType;
  const GridT& grid;
  typename GridT::ConstAccessor accessor;
  bool level_set;
  Value background;

  template<class Out> void copy(const openvdb::Coord& begin, const openvdb::Coord& dims, Out* out) {
    for (int32_t z = 0; z < dims[2]; z += step(begin[2] + z))
      for (int32_t y = 0; y < dims[1]; y += step(begin[1] + y))
        for (int32_t x = 0; x < dims[0]; x += step(begin[0] + x)) block(begin, {x, y, z}, dims, out);
  }

 private:
  // Returns the voxels to the next border of leaves.
  static int32_t step(int32_t index) { return kBlock - (index & (kBlock - 1)); }

  template<class Out>
  void block(const openvdb::Coord& begin, const openvdb::Coord& at, const openvdb::Coord& dims, Out* out) {
    const openvdb::Coord first = begin + at;
    const auto* leaf = accessor.probeConstLeaf(first);
    Value tile = background;
    if (!leaf && (!accessor.probeValue(first, tile) && !level_set)) tile = background;
    for (int32_t z = at[2]; z < std::min(dims[2], at[2] + step(first[2])); ++z)
      for (int32_t y = at[1]; y < std::min(dims[1], at[1] + step(first[1])); ++y) {
        Out* row = out + (z * dims[1] + y) * dims[0];
        for (int32_t x = at[0]; x < std::min(dims[0], at[0] + step(first[0])); ++x) {
          Value value = tile;
          if (leaf) {
            const auto offset = GridT::TreeType::LeafNodeType::coordToOffset(begin + openvdb::Coord(x, y, z));
            value = level_set || leaf->isValueOn(offset) ? leaf->getValue(offset) : background;
          }
          row[x] = static_cast<Out>(value);
        }
      }
  }
};

// Returns the blocks (8^3, relative to the block of `origin`) that hold anything but background.
template<class GridT>
std::vector<std::array<int32_t, 3>> filled_blocks(const GridT& grid, bool level_set,
                                                  const openvdb::CoordBBox& domain,
                                                  const openvdb::Coord& first_block) {
  std::vector<std::array<int32_t, 3>> blocks;
  const auto add = [&](openvdb::CoordBBox box) {
    box.intersect(domain);
    if (box.empty()) return;
    for (int32_t z = box.min()[2] >> 3; z <= box.max()[2] >> 3; ++z)
      for (int32_t y = box.min()[1] >> 3; y <= box.max()[1] >> 3; ++y)
        for (int32_t x = box.min()[0] >> 3; x <= box.max()[0] >> 3; ++x)
          blocks.push_back({x - first_block[0], y - first_block[1], z - first_block[2]});
  };
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    if (level_set || !leaf->isEmpty()) add(leaf->getNodeBoundingBox());
  auto tile = grid.cbeginValueAll();
  tile.setMaxDepth(GridT::TreeType::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    const bool inside = level_set && !tile.isValueOn() && *tile != grid.background();
    if (tile.isValueOn() || inside) add(tile.getBoundingBox());
  }
  return blocks;
}

template<class GridT>
Frame frame_of(const GridT& grid, const std::string& path, const std::array<int32_t, 3>& origin,
               const std::array<uint64_t, 4>& dims, uint64_t memory_limit) {
  using Value = typename GridT::ValueType;
  constexpr Type type = box_type<Value>();
  const bool level_set = grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  const openvdb::Coord begin(origin[0], origin[1], origin[2]);
  const openvdb::CoordBBox domain(begin, begin + openvdb::Coord(static_cast<int32_t>(dims[0]) - 1,
                                                                static_cast<int32_t>(dims[1]) - 1,
                                                                static_cast<int32_t>(dims[2]) - 1));
  const openvdb::Coord first_block(begin[0] >> 3, begin[1] >> 3, begin[2] >> 3);
  std::array<int32_t, 3> extent{};
  uint64_t blocks = 1;
  for (int a = 0; a < 3; ++a) {
    extent[a] = (domain.max()[a] >> 3) - first_block[a] + 1;
    blocks *= extent[a];
  }
  if (blocks > kExtentLimit)
    fail_input(path, ": the active voxels span ", dims[0], " x ", dims[1], " x ", dims[2],
               ", too much for one volume");

  Frame frame;
  uint64_t bytes = 0;
  BoxCopier<GridT> copier{grid, grid.getConstAccessor(), level_set, grid.background()};
  for (const BlockBox& b :
       merge_blocks(filled_blocks(grid, level_set, domain, first_block), extent, kBoxBlocks)) {
    openvdb::CoordBBox voxels(openvdb::Coord((first_block[0] + b.begin[0]) * kBlock,
                                             (first_block[1] + b.begin[1]) * kBlock,
                                             (first_block[2] + b.begin[2]) * kBlock),
                              openvdb::Coord((first_block[0] + b.begin[0] + b.dims[0]) * kBlock - 1,
                                             (first_block[1] + b.begin[1] + b.dims[1]) * kBlock - 1,
                                             (first_block[2] + b.begin[2] + b.dims[2]) * kBlock - 1));
    voxels.intersect(domain);
    Box box;
    box.type = type;
    uint64_t stride = type_size(type);
    for (int a = 0; a < 3; ++a) {
      const size_t i = a;
      box.begin[i] = voxels.min()[a] - begin[a];
      box.dims[i] = voxels.max()[a] - voxels.min()[a] + 1;
      box.stride_bytes[i] = stride;
      stride *= box.dims[i];
    }
    bytes += stride;
    if (bytes > memory_limit)
      fail_resources(path, ": its active voxels take more than the ",
                     byte_text(static_cast<double>(memory_limit)), " allowed: raise --max-mem");
    auto storage = std::make_shared<Bytes>(stride);
    visit_type(type, [&](auto zero) {
      using Out = decltype(zero);
      if constexpr (std::is_arithmetic_v<Out>)
        copier.copy(voxels.min(), voxels.dim(), reinterpret_cast<Out*>(storage->data()));
    });
    box.data = storage->data();
    frame.boxes.push_back(box);
    frame.storage.push_back(std::move(storage));
  }
  return frame;
}

} // namespace

void VdbBounds::unite(const VdbBounds& other) {
  if (other.empty()) return;
  for (size_t a = 0; a < 3; ++a) {
    begin[a] = std::min(begin[a], other.begin[a]);
    end[a] = std::max(end[a], other.end[a]);
  }
}

VdbFile::VdbFile(const std::string& path) : archive_(std::make_unique<Archive>(path)) {}
VdbFile::~VdbFile() = default;

const std::string& VdbFile::path() const { return archive_->path(); }

std::vector<std::string> VdbFile::names() { return archive_->names(); }

std::vector<std::string> VdbFile::scalar_names() {
  std::vector<std::string> out;
  for (const std::string& name : names())
    if (is_scalar(*archive_->metadata(name))) out.push_back(name);
  return out;
}

VdbGridInfo VdbFile::read_info(const std::string& name, bool with_background, bool fog) {
  const std::string& path = archive_->path();
  require_name(path, names(), name);
  openvdb::GridBase::Ptr grid = archive_->metadata(name);
  VdbGridInfo info;
  info.name = name;
  info.own_name = grid->getName();
  info.tree_type = grid->valueType();
  info.level_set = grid->getGridClass() == openvdb::GRID_LEVEL_SET;
  info.grid_class = openvdb::GridBase::gridClassToString(fog && info.level_set ? openvdb::GRID_FOG_VOLUME
                                                                               : grid->getGridClass());
  if (is_points(*grid))
    fail_input(path, ": grid \"", name, "\" holds points (", grid->type(),
               "), which have no values on a lattice; rasterise it first");
  if (!is_scalar(*grid))
    fail_input(path, ": grid \"", name, "\" holds ", grid->valueType(),
               " values; float, double, int and bool grids can be read");
  if (!grid->transform().isLinear())
    fail_input(path, ": grid \"", name, "\" has a ", grid->transform().mapType(),
               ", which is not linear: resample it first");
  const openvdb::Mat4R m = grid->transform().baseMap()->getAffineMap()->getMat4(); // row vectors: x' = x M
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) info.affine[column * 4 + row] = m(row, column);

  info.told = told_by(*grid);

  const auto lowest = grid->getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto highest = grid->getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  const auto count = grid->getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
  if (count && count->value() >= 0) info.active = static_cast<uint64_t>(count->value());
  if (lowest && highest) {
    info.bounds =
        bounds_of(openvdb::CoordBBox(openvdb::Coord(lowest->value()), openvdb::Coord(highest->value())));
    if (with_background) grid = archive_->topology(name);
  } else {
    grid = archive_->grid(name);
    info.bounds = bounds_of(grid->evalActiveVoxelBoundingBox());
    info.active = grid->activeVoxelCount();
  }
  grid->apply<Scalars>([&](const auto& g) {
    using Value = typename std::decay_t<decltype(g)>::ValueType;
    info.type = box_type<Value>();
    if (with_background) info.background = static_cast<double>(g.background());
  });
  if (fog && info.level_set) info.background = 0, info.active.reset(), info.told.value_unit.clear();
  info.precision = grid->saveFloatAsHalf() && is_float(info.type) ? Type::f16 : info.type;
  return info;
}

Frame VdbFile::read_frame(const std::string& name, const std::array<int32_t, 3>& origin,
                          const std::array<uint64_t, 4>& dims, double background, uint64_t memory_limit,
                          bool fog) {
  const std::string& path = archive_->path();
  require_name(path, names(), name);
  const openvdb::GridBase::Ptr grid = archive_->grid(name);
  Frame frame;
  const bool known = grid->apply<Scalars>([&](auto& g) {
    using Value = typename std::decay_t<decltype(g)>::ValueType;
    if constexpr (std::is_floating_point_v<Value>)
      if (fog && g.getGridClass() == openvdb::GRID_LEVEL_SET)
        openvdb::tools::sdfToFogVolume(g, std::numeric_limits<Value>::max()); // a ramp through all the band
    const auto own = static_cast<double>(g.background());
    if (own != background)
      fail_input(path, ": grid \"", name, "\" has background ", own, ", in the first frame ", background);
    frame = frame_of(g, path, origin, dims, memory_limit);
  });
  if (!known)
    fail_input(path, ": grid \"", name, "\" holds ", grid->valueType(), " values, other frames scalars");
  return frame;
}

} // namespace bcc4

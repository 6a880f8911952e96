// SPDX-License-Identifier: Apache-2.0
// The OpenVDB reader on grids made with the library, against the trees' own values: scattered voxels, shifts,
// level sets, types, and what is refused.
#if BCCSPLAT_WITH_OPENVDB
#include "readers/vdb/vdb_reader.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <random>

#include "openings.h"
#include "readers/vdb/vdb_grid.h"

namespace bcc4::test {
namespace {

using openvdb::Coord;

// Makes a grid by its name, in OpenVDB: create() has the code of the whole tree compiled here once more.
template<class GridT> typename GridT::Ptr make_grid(const typename GridT::ValueType& background) {
  const auto grid = openvdb::gridPtrCast<GridT>(openvdb::GridBase::createGrid(GridT::gridType()));
  grid->tree().root().setBackground(background, false);
  return grid;
}

openvdb::FloatGrid::Ptr fog(const std::string& name, double voxel = 0.5) {
  openvdb::initialize();
  const auto grid = make_grid<openvdb::FloatGrid>(0);
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
  return grid;
}

void write(const std::string& path, const openvdb::GridCPtrVec& grids, bool stats = true) {
  openvdb::io::File file(path);
  file.setGridStatsMetadataEnabled(stats);
  file.write(grids);
}

// Expects every voxel of the reader to be the tree's value where it is active, and background elsewhere.
template<class GridT>
void expect_equal(FrameReader& reader, uint64_t frame, const GridT& grid, const Coord& origin,
                  size_t channel = 0) {
  const auto& d = reader.description().dims;
  const auto values = dense(reader, frame, channel);
  size_t i = 0;
  for (int z = 0; z < static_cast<int>(d[2]); ++z)
    for (int y = 0; y < static_cast<int>(d[1]); ++y)
      for (int x = 0; x < static_cast<int>(d[0]); ++x) {
        typename GridT::ValueType v{};
        const bool on = grid.tree().probeValue(origin + Coord(x, y, z), v);
        ASSERT_EQ(values[i++], static_cast<double>(on ? v : grid.background())) << x << " " << y << " " << z;
      }
}

TEST(VdbReader, TakesTimeAndUnitsFromMetadata) {
  Scratch s;
  openvdb::Metadata::Ptr times[] = {std::make_shared<openvdb::Int32Metadata>(1),
                                    std::make_shared<openvdb::FloatMetadata>(1.5f),
                                    std::make_shared<openvdb::DoubleMetadata>(4)};
  ReaderOptions o;
  for (size_t i = 0; i < 3; ++i) {
    const auto grid = fog("density");
    grid->getAccessor().setValue(Coord(1, 2, 3), 1);
    grid->insertMeta("time", *times[i]);
    grid->insertMeta("time_unit", openvdb::StringMetadata("s"));
    grid->insertMeta("value_unit", openvdb::StringMetadata("kg/m\xb3"));
    grid->insertMeta("space_unit", openvdb::StringMetadata("m"));
    o.inputs.push_back(s.path(concat("f.", i, ".vdb")));
    write(o.inputs.back(), {grid});
  }
  const SeriesDescription d = open_series(o)->description();
  EXPECT_EQ(d.times.values, (std::vector<double>{1, 1.5, 4}));
  EXPECT_EQ(d.times.unit, "s");
  EXPECT_EQ(d.channels[0].unit, "kg/m\xc2\xb3");
  EXPECT_EQ(d.spatial_unit, "m");
  o.dt = 2;
  EXPECT_EQ(open_series(o)->description().times.values, (std::vector<double>{1, 3, 5}));
  // Frames that say the same time are counted.
  o.dt.reset();
  o.inputs = {o.inputs[0], s.path("f.1.vdb")};
  const auto grid = fog("density");
  grid->getAccessor().setValue(Coord(1, 2, 3), 1);
  grid->insertMeta("time", *times[0]);
  write(o.inputs[1], {grid});
  const SeriesDescription other = open_series(o)->description();
  EXPECT_EQ(other.times.values, (std::vector<double>{0, 1}));
  EXPECT_EQ(other.times.unit, "");
}

TEST(VdbReader, ReadsScatteredVoxelsAndTiles) {
  Scratch s;
  std::mt19937 random(3);
  const auto grid = fog("density");
  auto a = grid->getAccessor();
  for (int i = 0; i < 4000; ++i) {
    const auto c = [&] { return static_cast<int>(random() % 90) - 30; };
    a.setValue(Coord(c(), c(), c()), static_cast<float>(random() % 1000) / 10);
  }
  for (int i = 0; i < 500; ++i)
    a.setValueOff(Coord(static_cast<int>(random() % 20), 3, 3), 77); // inactive, but not background
  grid->fill(openvdb::CoordBBox(Coord(16, 16, 16), Coord(47, 31, 23)), 9.0f, true); // tiles
  for (const bool stats : {true, false}) {
    write(s.path("a.vdb"), {grid}, stats);
    const auto reader = open_series(inputs({s.path("a.vdb")}));
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    const auto& d = reader->description();
    ASSERT_EQ(d.dims, (std::array<uint64_t, 4>{static_cast<uint64_t>(box.dim()[0]),
                                               static_cast<uint64_t>(box.dim()[1]),
                                               static_cast<uint64_t>(box.dim()[2]), 1}));
    expect_equal(*reader, 0, *grid, box.min());
    EXPECT_EQ(d.affine[0], 0.5);
    EXPECT_EQ(d.affine[3], 0.5 * box.min()[0]);
  }
}

TEST(VdbReader, OpensTheFirstFileOnceToDescribeAndReadIt) {
  Scratch s;
  const auto grid = fog("density");
  grid->getAccessor().setValue(Coord(2, 3, 4), 1);
  write(s.path("f.1.vdb"), {grid});
  write(s.path("f.2.vdb"), {grid});
  expect_opened_once(s, inputs({s.path("f.%d.vdb")}), "f.1.vdb", "f.2.vdb", 0);
}

TEST(VdbReader, UnitesBoxesFollowsShiftsAndTakesEmptyFrames) {
  Scratch s;
  const auto first = fog("density"), empty = fog("density"), moved = fog("density");
  first->getAccessor().setValue(Coord(2, 3, 4), 1);
  moved->getAccessor().setValue(Coord(0, 0, 0), 5);
  moved->transform().postTranslate(openvdb::Vec3d(0.5 * 7, 0, -0.5)); // 7 voxels along x, one back along z
  write(s.path("f.0999.vdb"), {first});
  write(s.path("f.1000.vdb"), {empty});
  write(s.path("f.1001.vdb"), {moved});
  const auto reader = open_series(inputs({s.path("f.%04d.vdb")}));
  ASSERT_EQ(reader->description().dims, (std::array<uint64_t, 4>{6, 4, 6, 3}));
  const auto at = [&](uint64_t f, size_t x, size_t y, size_t z) {
    return dense(*reader, f)[(z * 4 + y) * 6 + x];
  };
  EXPECT_EQ(at(0, 0, 3, 5), 1);
  EXPECT_EQ(at(2, 5, 0, 0), 5);
  EXPECT_TRUE(reader->read(1, 0).boxes.empty());
  EXPECT_EQ(reader->description().affine[3], 0.5 * 2);

  const auto half = fog("density");
  half->getAccessor().setValue(Coord(0, 0, 0), 5);
  half->transform().postTranslate(openvdb::Vec3d(0.2, 0, 0));
  write(s.path("f.1002.vdb"), {half});
  EXPECT_REFUSED(refusal(inputs({s.path("f.%04d.vdb")})), Exit::bad_input, "moved by 0.4");
  const auto coarse = fog("density", 1.0);
  coarse->getAccessor().setValue(Coord(0, 0, 0), 5);
  write(s.path("f.1002.vdb"), {coarse});
  EXPECT_REFUSED(refusal(inputs({s.path("f.%04d.vdb")})), Exit::bad_input, "differ in size or direction");
}

TEST(VdbReader, KeepsTheSignOfLevelSets) {
  Scratch s;
  const auto sphere =
      openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(20.0f, openvdb::Vec3f(0), 1.0f, 3.0f);
  sphere->setName("surface");
  write(s.path("a.vdb"), {sphere});
  const auto reader = open_series(inputs({s.path("a.vdb")}));
  const auto& d = reader->description();
  EXPECT_EQ(d.channels[0].air, 3);
  const auto v = dense(*reader, 0);
  const auto value = [&](int x, int y, int z) {
    const int half = (static_cast<int>(d.dims[0]) - 1) / 2;
    return v[((z + half) * static_cast<int>(d.dims[1]) + y + half) * static_cast<int>(d.dims[0]) + x + half];
  };
  EXPECT_EQ(value(0, 0, 0), -3); // deep inside there are inactive tiles only
  EXPECT_NEAR(value(19, 0, 0), -1, 1e-5);
  EXPECT_NEAR(value(0, 21, 0), 1, 1e-5);
  EXPECT_EQ(value(21, 21, 21), 3);
}

TEST(VdbReader, ReadsLevelSetsAsFog) {
  Scratch s;
  const auto sphere =
      openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(20.0f, openvdb::Vec3f(0), 1.0f, 4.0f);
  sphere->setName("surface");
  write(s.path("a.vdb"), {sphere, fog("density")});
  ReaderOptions options = inputs({s.path("a.vdb")});
  options.grids = {"surface"}, options.level_set_fog = true;
  const auto reader = open_series(options);
  const auto& d = reader->description();
  EXPECT_EQ(d.channels[0].air, 0);
  const auto v = dense(*reader, 0);
  const int half = (static_cast<int>(d.dims[0]) - 1) / 2;
  size_t i = 0;
  for (int z = -half; z <= half; ++z)
    for (int y = -half; y <= half; ++y)
      for (int x = -half; x <= half; ++x) {
        // Distance over the half width of the band, at most 1.
        const double depth = 20 - std::sqrt(x * x + y * y + z * z);
        ASSERT_NEAR(v[i++], std::clamp(depth / 4, 0.0, 1.0), 1e-5) << x << " " << y << " " << z;
      }
  options.grids = {"density"};
  EXPECT_NE(refusal(options).text.find("no level set among density"), std::string::npos);
}

TEST(VdbReader, ReadsOtherTypesAndHalves) {
  Scratch s;
  openvdb::initialize();
  const auto fill = [](auto grid, auto value) {
    grid->setName("g");
    grid->getAccessor().setValue(Coord(1, 1, 1), value);
    grid->getAccessor().setValue(Coord(3, 3, 3), value);
    return grid;
  };
  const auto d = fill(make_grid<openvdb::DoubleGrid>(0.25), 1e-9);
  write(s.path("d.vdb"), {d});
  const auto doubles = open_series(inputs({s.path("d.vdb")}));
  EXPECT_EQ(doubles->description().channels[0].precision, Type::f64);
  EXPECT_EQ(doubles->description().channels[0].air, 0.25);
  expect_equal(*doubles, 0, *d, Coord(1, 1, 1));
  const auto i = fill(make_grid<openvdb::Int32Grid>(-5), 1 << 30);
  write(s.path("i.vdb"), {i});
  expect_equal(*open_series(inputs({s.path("i.vdb")})), 0, *i, Coord(1, 1, 1));
  const auto l = fill(make_grid<openvdb::Int64Grid>(0), int64_t{1} << 40);
  write(s.path("l.vdb"), {l});
  expect_equal(*open_series(inputs({s.path("l.vdb")})), 0, *l, Coord(1, 1, 1));
  const auto b = fill(make_grid<openvdb::BoolGrid>(false), true);
  write(s.path("b.vdb"), {b});
  EXPECT_EQ(dense(*open_series(inputs({s.path("b.vdb")})), 0)[0], 1);
  const auto half = fog("density");
  half->getAccessor().setValue(Coord(0, 0, 0), 0.1f);
  half->setSaveFloatAsHalf(true);
  write(s.path("h.vdb"), {half});
  const auto reader = open_series(inputs({s.path("h.vdb")}));
  EXPECT_EQ(reader->description().channels[0].precision, Type::f16);
  EXPECT_EQ(reader->description().channels[0].type, Type::f32);
}

TEST(VdbReader, ChoosesGridsByName) {
  Scratch s;
  const auto density = fog("density"), temperature = fog("temperature");
  density->getAccessor().setValue(Coord(0, 0, 0), 1);
  temperature->getAccessor().setValue(Coord(4, 0, 0), 2);
  write(s.path("a.vdb"), {density, temperature});
  ReaderOptions o = inputs({s.path("a.vdb")});
  EXPECT_EQ(open_series(o)->description().channels[0].name, "density");
  o.grids = {"temperature", "density"};
  const auto both = open_series(o);
  ASSERT_EQ(both->description().dims[0], 5u);
  EXPECT_EQ(dense(*both, 0, 0)[4], 2);
  EXPECT_EQ(dense(*both, 0, 1)[0], 1);
  o.grids = {"temprature"};
  EXPECT_REFUSED(refusal(o), Exit::usage, "did you mean temperature?");

  const auto heat = fog("heat");
  heat->getAccessor().setValue(Coord(0, 0, 0), 1);
  write(s.path("b.vdb"), {temperature, heat});
  EXPECT_REFUSED(refusal(inputs({s.path("b.vdb")})), Exit::usage, "choose with --grid");
  const auto twin = fog("density");
  twin->getAccessor().setValue(Coord(0, 0, 0), 8);
  write(s.path("c.vdb"), {density, twin});
  o = inputs({s.path("c.vdb")});
  o.grids = {"density"};
  EXPECT_REFUSED(refusal(o), Exit::usage, "density[0] and density[1]");
  o.grids = {"density[1]"};
  EXPECT_EQ(dense(*open_series(o), 0)[0], 8);
}

TEST(VdbReader, AGridThatAppearsLaterIsEmptyBefore) {
  Scratch s;
  const auto density = fog("density"), flame = fog("flame");
  density->getAccessor().setValue(Coord(0, 0, 0), 1);
  flame->getAccessor().setValue(Coord(4, 0, 0), 2);
  const auto velocity = make_grid<openvdb::Vec3SGrid>(openvdb::Vec3s(0));
  velocity->setName("vel");
  write(s.path("f.0.vdb"), {density});
  write(s.path("f.1.vdb"), {density, flame, velocity});
  ReaderOptions o = inputs({s.path("f.%d.vdb")});
  const auto one = open_series(o);
  EXPECT_EQ(one->description().dims[0], 1u);
  const auto& notes = one->description().notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("left out: flame (first in ") == 0 && note.find("vel (no scalars)") != std::string::npos;
  }));
  o.grids = {"density", "flame"};
  const auto both = open_series(o);
  ASSERT_EQ(both->description().dims, (std::array<uint64_t, 4>{5, 1, 1, 2}));
  EXPECT_TRUE(both->read(0, 1).boxes.empty());
  EXPECT_EQ(dense(*both, 1, 1)[4], 2);
  EXPECT_EQ(both->description().channels[1].active, (std::vector<uint64_t>{0, 1}));
  o.grids = {"flame"};
  EXPECT_EQ(dense(*open_series(o), 1)[0], 2);
  o.grids = {"fire"};
  EXPECT_REFUSED(refusal(o), Exit::usage, "no grid \"fire\"");
  // Nobody said what to read: a file without the grid that was taken is none of the series.
  write(s.path("f.1.vdb"), {flame});
  EXPECT_REFUSED(refusal(inputs({s.path("f.%d.vdb")})), Exit::usage, "no grid \"density\"; it has flame");
}

TEST(VdbReader, RefusesPointsVectorsAndDamage) {
  Scratch s;
  openvdb::initialize();
  const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
  const auto points =
      openvdb::points::createPointDataGrid<openvdb::points::NullCodec, openvdb::points::PointDataGrid>(
          std::vector<openvdb::Vec3R>{{0, 1, 0}, {1.5, 2, 3}}, *transform);
  points->setName("particles");
  write(s.path("p.vdb"), {points});
  EXPECT_REFUSED(refusal(inputs({s.path("p.vdb")})), Exit::bad_input, "grid \"particles\" holds points");
  const auto vectors = make_grid<openvdb::Vec3SGrid>(openvdb::Vec3s(0));
  vectors->setName("velocity");
  write(s.path("v.vdb"), {vectors});
  EXPECT_REFUSED(refusal(inputs({s.path("v.vdb")})), Exit::bad_input, "grid \"velocity\" holds vec3s");
  write(s.path("e.vdb"), {fog("density")});
  EXPECT_REFUSED(refusal(inputs({s.path("e.vdb")})), Exit::bad_input, "no active voxels");

  const auto grid = fog("density");
  grid->fill(openvdb::CoordBBox(Coord(0), Coord(20)), 1.0f);
  grid->getAccessor().setValue(Coord(5, 5, 5), 2);
  write(s.path("g.vdb"), {grid});
  std::ifstream in(s.path("g.vdb"), std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  s.file("cut.vdb", bytes.substr(0, bytes.size() / 2));
  // Sizes that stood behind the cut OpenVDB leaves to chance: it may ask for more memory than there is.
  const Exit cut = refusal(inputs({s.path("cut.vdb")})).exit;
  EXPECT_TRUE(cut == Exit::bad_input || cut == Exit::no_resources) << static_cast<int>(cut);
  ReaderOptions small = inputs({s.path("g.vdb")});
  small.max_memory = 1000;
  EXPECT_REFUSED(refusal(small), Exit::no_resources, "--max-mem");
}

} // namespace
} // namespace bcc4::test
#endif

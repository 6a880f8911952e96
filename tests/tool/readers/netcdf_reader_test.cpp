// SPDX-License-Identifier: Apache-2.0
// The NetCDF reader on files made with the library: formats and types, roles of axes, packed values and
// holes, series of files, uneven levels, and what is refused.
#include "readers/netcdf/netcdf_reader.h"

#include <algorithm>
#include <cmath>

#include "netcdf_files.h"
#include "openings.h"

namespace bcc4::test {
namespace {

TEST(NetcdfReader, ReadsEveryFormatAndType) {
  Scratch s;
  for (const int format : {0, NC_64BIT_OFFSET, NC_CDF5, NC_NETCDF4})
    for (const nc_type type : {NC_BYTE, NC_SHORT, NC_INT, NC_FLOAT, NC_DOUBLE}) {
      NcFile nc(s.path("a.nc"), plain_dims, type, format);
      nc.finish();
      const auto reader = open_series(inputs({s.path("a.nc")}));
      ASSERT_EQ(reader->description().dims, (std::array<uint64_t, 4>{2, 3, 4, 5}));
      EXPECT_EQ(reader->description().channels[0].name, "v");
      for (const uint64_t frame : {4, 1})
        EXPECT_EQ(dense(*reader, frame)[13], static_cast<double>(24 * frame + 13));
    }
}

TEST(NetcdfReader, KnowsAxesByAttributesNamesAndPlace) {
  Scratch s;
  // The order of the file is x, t, y, z from slowest to fastest; nothing in it is in its usual place.
  NcFile attributes(s.path("a.nc"), {{"a", 2, "degrees_east", 2.5},
                                     {"b", 5, "hours since 2000-01-01", 6},
                                     {"c", 3, "degrees_north", -1},
                                     {"d", 4, "hPa", 100}});
  attributes.finish();
  const auto reader = open_series(inputs({s.path("a.nc")}));
  const SeriesDescription& d = reader->description();
  ASSERT_EQ(d.dims, (std::array<uint64_t, 4>{2, 3, 4, 5}));
  EXPECT_EQ(d.times.values, (std::vector<double>{0, 6, 12, 18, 24}));
  EXPECT_EQ(d.times.unit, "hours");
  EXPECT_EQ(d.affine, (std::array<double, 16>{2.5, 0, 0, 0, 0, -1, 0, 0, 0, 0, 100, 0, 0, 0, 0, 1}));
  const std::vector<double> frame = dense(*reader, 2);
  for (size_t x = 0; x < 2; ++x)
    for (size_t y = 0; y < 3; ++y)
      for (size_t z = 0; z < 4; ++z)
        EXPECT_EQ(frame[x + 2 * (y + 3 * z)], static_cast<double>(z + 4 * (y + 3 * (2 + 5 * x))));

  NcFile places(s.path("b.nc"), {{"p", 5}, {"q", 4}, {"r", 3}, {"s", 2}});
  places.finish();
  EXPECT_EQ(open_series(inputs({s.path("b.nc")}))->description().dims, (std::array<uint64_t, 4>{2, 3, 4, 5}));
  ReaderOptions letters = inputs({s.path("b.nc")});
  letters.axes = "tzyx";
  EXPECT_EQ(open_series(letters)->description().dims, (std::array<uint64_t, 4>{5, 4, 3, 2}));

  NcFile twice(s.path("c.nc"), {{"t", 5}, {"a", 4, "degrees_north"}, {"b", 3, "degrees_north"}, {"x", 2}});
  twice.finish();
  EXPECT_REFUSED(refusal(inputs({s.path("c.nc")})), Exit::bad_input, "--axes");
}

TEST(NetcdfReader, TakesLongitudeAndLatitudeForOneUnit) {
  Scratch s;
  const auto read = [&](const char* level) {
    NcFile nc(
        s.path("a.nc"),
        {{"time", 2}, {"lev", 3, level, 100}, {"lat", 4, "degrees_north", 2}, {"lon", 5, "degrees_east", 2}});
    nc.finish();
    return open_series(inputs({s.path("a.nc")}));
  };
  const auto told = [](const SeriesDescription& d) {
    return std::any_of(d.notes.begin(), d.notes.end(), [](const std::string& note) {
      return note.find("different units") != std::string::npos && note.find("--shape") != std::string::npos;
    });
  };
  const auto same = read("degrees"), other = read("hPa");
  EXPECT_EQ(same->description().spatial_unit, "degrees");
  EXPECT_FALSE(told(same->description()));
  EXPECT_EQ(other->description().spatial_unit, "");
  EXPECT_TRUE(told(other->description()));
}

TEST(NetcdfReader, UnpacksValuesAndMarksHoles) {
  Scratch s;
  NcFile nc(s.path("a.nc"), plain_dims, NC_SHORT);
  const double scale = 0.5, offset = 10;
  const short fill = 7, range[2] = {2, 100};
  check_nc(nc_put_att_double(nc.id, nc.variable, "scale_factor", NC_DOUBLE, 1, &scale));
  check_nc(nc_put_att_double(nc.id, nc.variable, "add_offset", NC_DOUBLE, 1, &offset));
  check_nc(nc_put_att_short(nc.id, nc.variable, "_FillValue", NC_SHORT, 1, &fill));
  check_nc(nc_put_att_short(nc.id, nc.variable, "valid_range", NC_SHORT, 2, range));
  check_nc(nc_put_att_text(nc.id, nc.variable, "units", 1, "K"));
  nc.finish();
  const auto reader = open_series(inputs({s.path("a.nc")}));
  const Channel& channel = reader->description().channels[0];
  EXPECT_TRUE(channel.has_fill);
  EXPECT_EQ(channel.unit, "K");
  const std::vector<double> first = dense(*reader, 0), last = dense(*reader, 4);
  EXPECT_TRUE(std::isnan(first[7]) && std::isnan(first[1]) &&
              std::isnan(last[5])); // fill, below, above the range
  EXPECT_EQ(first[2], 11);
  EXPECT_EQ(last[4], 60);
}

TEST(NetcdfReader, JoinsFilesAlongTime) {
  Scratch s;
  for (int i = 0; i < 3; ++i) {
    NcFile nc(s.path("day" + std::to_string(i) + ".nc"),
              {{"time", 2, "hours since 2000-01-01", 12}, {"z", 4}, {"y", 3}, {"x", 2}}, NC_FLOAT, 0,
              24.0 * i);
    nc.finish();
  }
  const auto reader = open_series(inputs({s.path("day#.nc")}));
  EXPECT_EQ(reader->description().dims, (std::array<uint64_t, 4>{2, 3, 4, 6}));
  EXPECT_EQ(reader->description().times.values, (std::vector<double>{0, 12, 24, 36, 48, 60}));
  EXPECT_EQ(dense(*reader, 5)[0], 24);
  EXPECT_EQ(dense(*reader, 2)[0], 0);
  EXPECT_NE(reader->frame_name(2).find("day1"), std::string::npos);
}

TEST(NetcdfReader, ReadsTheFirstHeaderOnce) {
  Scratch s;
  for (int i = 0; i < 2; ++i) {
    NcFile nc(s.path("day" + std::to_string(i) + ".nc"),
              {{"time", 2, "hours since 2000-01-01", 12}, {"z", 4}, {"y", 3}, {"x", 2}}, NC_FLOAT, 0,
              24.0 * i);
    nc.finish();
  }
  // Described and read through one opening; the second file is opened for each.
  expect_opened_once(s, inputs({s.path("day#.nc")}), "day0.nc", "day1.nc", 0);
}

// 3 x 2 samples at depths 0, 10, 20, 50 holding depth^2; a hole at 20 in column 0.
std::string depths(const std::string& path, bool falling) {
  NcFile nc(path, {{"depth", 4, "m"}, {"y", 3}, {"x", 2}});
  check_nc(nc_put_att_text(nc.id, nc.axes[0].first, "positive", 4, "down"));
  check_nc(nc_enddef(nc.id));
  std::vector<double> at{0, 10, 20, 50}, values;
  if (falling) std::reverse(at.begin(), at.end());
  for (const double depth : at)
    for (int i = 0; i < 6; ++i) values.push_back(i == 0 && depth == 20 ? NAN : depth * depth);
  check_nc(nc_put_var_double(nc.id, nc.axes[0].first, at.data()));
  check_nc(nc_put_var_double(nc.id, nc.variable, values.data()));
  check_nc(nc_close(nc.id));
  return path;
}

TEST(NetcdfReader, KeepsUnevenDepthsAndTheirPlaces) {
  Scratch s;
  for (const bool falling : {false, true}) {
    const auto reader = open_series(inputs({depths(s.path("a.nc"), falling)}));
    const SeriesDescription& d = reader->description();
    EXPECT_TRUE(d.warnings.empty()) << d.warnings[0];
    ASSERT_EQ(d.dims, (std::array<uint64_t, 4>{2, 3, 4, 1}));
    EXPECT_NEAR(d.affine[10], falling ? 50.0 / 3 : -50.0 / 3,
                1e-12); // z = -depth, from the first to the last
    EXPECT_EQ(d.affine[11], falling ? -50 : 0);
    std::vector<double> at{0, 10, 20, 50};
    if (falling) std::reverse(at.begin(), at.end());
    EXPECT_EQ(d.places[2].coordinates, at);
    EXPECT_EQ(d.places[2].unit, "m");
    EXPECT_TRUE(d.places[2].down);
    EXPECT_TRUE(d.places[0].coordinates.empty());
    const auto values = dense(*reader, 0);
    for (size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(values[6 * k + 4], at[k] * at[k]) << k;
      EXPECT_EQ(std::isnan(values[6 * k]), at[k] == 20) << k;
    }
    // --spacing says how large the box is, and nothing else.
    ReaderOptions o = inputs({s.path("a.nc")});
    o.spacing = {1, 1, 2};
    const auto shaped = open_series(o);
    EXPECT_EQ(shaped->description().places[2].coordinates, at);
    EXPECT_TRUE(shaped->description().places[2].down);
    EXPECT_EQ(shaped->description().affine[10], falling ? 2 : -2);
    EXPECT_EQ(dense(*shaped, 0)[6 * (falling ? 0 : 3) + 1], 2500);
  }
}

TEST(NetcdfReader, WarnsOfLevelsOutOfOrderAndNeedsNoTime) {
  Scratch s;
  NcFile nc(s.path("a.nc"), {{"time", 3}, {"level", 4, "hPa"}, {"y", 3}, {"x", 2}});
  check_nc(nc_enddef(nc.id));
  const double uneven[] = {1000, 850, 900, 100};
  check_nc(nc_put_var_double(nc.id, nc.axes[0].first, uneven));
  check_nc(nc_close(nc.id));
  const auto reader = open_series(inputs({s.path("a.nc")}));
  ASSERT_EQ(reader->description().warnings.size(), 1u);
  EXPECT_NE(reader->description().warnings[0].find("level is not evenly spaced"), std::string::npos);
  EXPECT_EQ(reader->description().times.values, (std::vector<double>{0, 1, 2}));
  // What was never written is the default fill value of floats, which is no data.
  EXPECT_TRUE(std::isnan(dense(*reader, 1)[3]));
}

TEST(NetcdfReader, AsksWhichVariableAndRefusesDamage) {
  Scratch s;
  NcFile nc(s.path("a.nc"), plain_dims);
  int ids[4], other = 0;
  for (int d = 0; d < 4; ++d) check_nc(nc_inq_dimid(nc.id, plain_dims[d].name, &ids[d]));
  check_nc(nc_def_var(nc.id, "w", NC_FLOAT, 4, ids, &other));
  nc.finish();
  EXPECT_REFUSED(refusal(inputs({s.path("a.nc")})), Exit::usage, "v and w");
  ReaderOptions o = inputs({s.path("a.nc")});
  o.channels = {"u"};
  EXPECT_REFUSED(refusal(o), Exit::usage, "no variable \"u\"");
  o.channels = {"w", "v"};
  EXPECT_EQ(open_series(o)->description().channels[1].name, "v");
  o.channels = {"v"};
  o.max_memory = 95; // a frame has 96 bytes
  EXPECT_REFUSED(refusal(o), Exit::no_resources, "--max-mem");
  std::ifstream whole(s.path("a.nc"), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(whole)), {});
  for (const size_t cut : {size_t{3}, size_t{40}, bytes.size() / 2, bytes.size() - 1}) {
    ReaderOptions broken = inputs({s.file("b.nc", bytes.substr(0, cut))});
    broken.channels = {"v"};
    EXPECT_NE(static_cast<int>(refusal(broken).exit), static_cast<int>(Exit::ok)) << cut;
  }
}

} // namespace
} // namespace bcc4::test

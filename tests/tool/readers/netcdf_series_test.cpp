// SPDX-License-Identifier: Apache-2.0
// NetCDF files as series: times of every form, groups, files that differ in scale, direction and date of
// reference, and what is refused.
#include <algorithm>
#include <cmath>
#include <random>
#include <thread>

#include "netcdf_files.h"
#include "readers/netcdf/netcdf_times.h"

namespace bcc4::test {
namespace {

std::string attribute(const SeriesDescription& d, const std::string& key) {
  for (const auto& [name, value] : d.attributes)
    if (name == key) return value;
  return "";
}

TEST(NetcdfSeries, ReadsTimesThatAreText) {
  Scratch s;
  const auto write = [&](const std::string& dates) {
    NcFile nc(s.path("a.nc"), {{"Time", 2}, {"z", 4}, {"y", 3}, {"x", 2}});
    int ids[2], text = 0;
    check_nc(nc_inq_dimid(nc.id, "Time", &ids[0]));
    check_nc(nc_def_dim(nc.id, "DateStrLen", 19, &ids[1]));
    check_nc(nc_def_var(nc.id, "Times", NC_CHAR, 2, ids, &text));
    check_nc(nc_enddef(nc.id));
    check_nc(nc_put_var_text(nc.id, text, dates.c_str()));
    check_nc(nc_redef(nc.id));
    nc.finish();
    return open_series(inputs({s.path("a.nc")}));
  };
  const auto hourly = write("2013-12-31_23:30:002014-01-01_00:30:00");
  EXPECT_EQ(hourly->description().times.values, (std::vector<double>{0, 1}));
  EXPECT_EQ(hourly->description().times.unit, "hours");
  EXPECT_EQ(attribute(hourly->description(), "time_epoch"), "2013-12-31 23:30:00");
  const auto none = write("the first one      2014-01-01_00:30:00");
  ASSERT_EQ(none->description().warnings.size(), 1u);
  EXPECT_NE(none->description().warnings[0].find("the first one"), std::string::npos);
}

TEST(NetcdfSeries, ReadsDatesThatAreNumbers) {
  Scratch s;
  NcFile nc(s.path("a.nc"), {{"time", 2, "day as %Y%m%d.%f", 73}, {"z", 4}, {"y", 3}, {"x", 2}}, NC_FLOAT, 0,
            20000228.5);
  nc.finish();
  const auto reader = open_series(inputs({s.path("a.nc")}));
  EXPECT_EQ(reader->description().times.values, (std::vector<double>{0.5, 2.5})); // there is a 29th
  EXPECT_EQ(reader->description().times.unit, "days");
  EXPECT_EQ(attribute(reader->description(), "time_epoch"), "2000-02-28");
}

TEST(NetcdfSeries, SaysWhatToDoWithFramesOutOfOrder) {
  Scratch s;
  for (const double step : {-6.0, 0.0}) {
    NcFile nc(s.path("a.nc"), {{"time", 3, "hours since 2000-01-01", step}, {"z", 4}, {"y", 3}, {"x", 2}});
    nc.finish();
    EXPECT_REFUSED(refusal(inputs({s.path("a.nc")})), Exit::bad_input,
                   step < 0 ? "sort the frames" : "leave one out");
  }
}

TEST(NetcdfSeries, FindsVariablesInGroups) {
  Scratch s;
  NcFile nc(s.path("a.nc"), {{"time", 5, "s", 0.5}, {"z", 4, "m", 3}, {"y", 3}, {"x", 2}}, NC_FLOAT,
            NC_NETCDF4);
  int ids[4];
  for (int d = 0; d < 4; ++d) check_nc(nc_inq_dimid(nc.id, plain_dims[d].name, &ids[d]));
  for (const char* run : {"run1", "run2"}) {
    int group = 0, variable = 0;
    check_nc(nc_def_grp(nc.id, run, &group));
    check_nc(nc_def_var(group, "f", NC_FLOAT, 4, ids, &variable));
    const std::vector<float> values(nc.count, run[3] == '1' ? 1.f : 2.f);
    check_nc(nc_put_var_float(group, variable, values.data()));
  }
  check_nc(nc_redef(nc.id));
  nc.finish();
  EXPECT_REFUSED(refusal(inputs({s.path("a.nc")})), Exit::usage, "v, run1/f and run2/f");
  ReaderOptions o = inputs({s.path("a.nc")});
  o.channels = {"run2/f"};
  const auto reader = open_series(o);
  EXPECT_EQ(reader->description().channels[0].name, "run2/f");
  EXPECT_EQ(reader->description().times.values, (std::vector<double>{0, 0.5, 1, 1.5, 2}));
  EXPECT_EQ(reader->description().affine[10], 3);
  EXPECT_EQ(dense(*reader, 4)[0], 2);
}

// Two files of two frames each, 12 hours apart.
struct TwoFiles {
  Scratch s;
  std::string lat_units = "degrees_north";
  double lat_step = 1;

  template<class Change> ReaderOptions write(nc_type type, const Change& change) {
    for (int i = 0; i < 2; ++i) {
      const NcDim lat{"lat", 3, i == 0 ? "degrees_north" : lat_units.c_str(), i == 0 ? 1 : lat_step};
      NcFile nc(s.path(i == 0 ? "a0.nc" : "a1.nc"),
                {{"time", 2, "hours since 2000-01-01", 12}, {"z", 4}, lat, {"x", 2}}, type, 0, 24.0 * i);
      change(nc, i);
    }
    return inputs({s.path("a0.nc"), s.path("a1.nc")});
  }
};

TEST(NetcdfSeries, ReadsEachFileByItsOwnScaleAndHoles) {
  TwoFiles files;
  const auto reader = open_series(files.write(NC_SHORT, [](NcFile& nc, int i) {
    nc.put("scale_factor", i == 0 ? 0.5 : 0.25);
    nc.put("add_offset", i == 0 ? 1.0 : 20.0);
    nc.put("_FillValue", i == 0 ? 3.0 : 4.0, -1, NC_SHORT);
    nc.finish();
  }));
  EXPECT_FALSE(reader->description().channels[0].scaled());
  const std::vector<double> first = dense(*reader, 0), third = dense(*reader, 2);
  EXPECT_EQ(first[4], 3);
  EXPECT_EQ(third[3], 20.75);
  EXPECT_TRUE(std::isnan(first[3]) && std::isnan(third[4]));
}

TEST(NetcdfSeries, RefusesAnotherUnitOfValues) {
  TwoFiles files;
  EXPECT_REFUSED(refusal(files.write(NC_FLOAT,
                                     [](NcFile& nc, int i) {
                                       nc.put("units", i == 0 ? "K" : "degC");
                                       nc.finish();
                                     })),
                 Exit::bad_input, "a1.nc: v is in \"degC\"");
}

TEST(NetcdfSeries, TurnsFilesThatCountLatitudesFromTheOtherEnd) {
  TwoFiles files;
  files.lat_step = -1; // 0, -1, -2; then made 2, 1, 0 by its offset
  const auto reader = open_series(files.write(NC_FLOAT, [](NcFile& nc, int i) {
    if (i == 1) nc.put("add_offset", 2.0, nc.axes[1].first);
    nc.finish();
  }));
  EXPECT_EQ(reader->description().affine[5], 1);
  const std::vector<double> first = dense(*reader, 0), third = dense(*reader, 2);
  for (size_t i = 0; i < 24; ++i) EXPECT_EQ(first[i], static_cast<double>(i));
  for (size_t z = 0; z < 4; ++z)
    for (size_t y = 0; y < 3; ++y)
      for (size_t x = 0; x < 2; ++x) EXPECT_EQ(third[x + 2 * (y + 3 * z)], first[x + 2 * (2 - y + 3 * z)]);
}

TEST(NetcdfSeries, RefusesOtherPlaces) {
  const auto plain = [](NcFile& nc, int) { nc.finish(); };
  TwoFiles apart, unit;
  apart.lat_step = 2;
  unit.lat_units = "m";
  EXPECT_REFUSED(refusal(apart.write(NC_FLOAT, plain)), Exit::bad_input, "along lat");
  ReaderOptions by_index = apart.write(NC_FLOAT, plain);
  by_index.spacing = {1, 1, 1};
  EXPECT_EQ(open_series(by_index)->description().dims[3], 4u);
  EXPECT_REFUSED(refusal(unit.write(NC_FLOAT, plain)), Exit::bad_input,
                 "0 to 2 m, there 0 to 2 degrees_north");
}

// Two frames of days 58 and 59 of a year, two of days 1 and 2 since 1 March.
ReaderOptions two_references(const Scratch& s, const char* calendar, const char* unit) {
  for (int i = 0; i < 2; ++i) {
    const std::string units = concat(unit, i == 0 ? " since 2000-01-01" : " since 2000-3-1 00:00:00 UTC");
    NcFile nc(s.path(i == 0 ? "a0.nc" : "a1.nc"), {{"time", 2, units.c_str()}, {"z", 4}, {"y", 3}, {"x", 2}},
              NC_FLOAT, 0, i == 0 ? 58 : 1);
    nc.put("calendar", calendar, nc.axes[0].first);
    nc.finish();
  }
  return inputs({s.path("a0.nc"), s.path("a1.nc")});
}

TEST(NetcdfSeries, ConvertsDatesOfReference) {
  Scratch s;
  const auto times = [&](const char* calendar) {
    return open_series(two_references(s, calendar, "days"))->description().times.values;
  };
  EXPECT_EQ(times("noleap"), (std::vector<double>{58, 59, 60, 61}));
  EXPECT_EQ(times("standard"), (std::vector<double>{58, 59, 61, 62}));
  EXPECT_EQ(times("360_day"), (std::vector<double>{58, 59, 61, 62}));
  ReaderOptions months = two_references(s, "standard", "months");
  EXPECT_REFUSED(refusal(months), Exit::bad_input, "give --dt or --times");
  months.dt = 1;
  EXPECT_EQ(open_series(months)->description().times.values, (std::vector<double>{58, 59, 60, 61}));
}

TEST(NetcdfSeries, KeepsErrorsOfHdf5ToItself) {
  Scratch s;
  const size_t side = 16;
  NcFile nc(s.path("a.nc"), {{"time", 2}, {"z", side}, {"y", side}, {"x", side}}, NC_FLOAT, NC_NETCDF4);
  const size_t chunk[] = {1, side, side, side};
  check_nc(nc_def_var_chunking(nc.id, nc.variable, NC_CHUNKED, chunk));
  check_nc(nc_def_var_deflate(nc.id, nc.variable, 1, 1, 4));
  std::mt19937 random(1);
  std::vector<double> noise(nc.count);
  for (double& v : noise) v = std::uniform_real_distribution<double>(0, 1)(random);
  nc.finish(noise);
  std::fstream file(s.path("a.nc"), std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(s.path("a.nc")) / 2));
  file << std::string(400, '\x55');
  file.close();
  testing::internal::CaptureStderr();
  const auto reader = open_series(inputs({s.path("a.nc")}));
  Refusal refused;
  std::thread([&] {
    refused = refusal([&] {
      for (uint64_t f = 0; f < 2; ++f) (void)reader->read(f, 0);
    });
  }).join();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_REFUSED(refused, Exit::bad_input, "damaged");
}

} // namespace
} // namespace bcc4::test

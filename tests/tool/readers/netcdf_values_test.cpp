// SPDX-License-Identifier: Apache-2.0
// What numbers in NetCDF files mean: sign, holes and limits, packed coordinates, curvilinear grids.
#include "readers/netcdf/netcdf_values.h"

#include <algorithm>
#include <cmath>

#include "netcdf_files.h"

namespace bcc4::test {
namespace {

// The numbers of `bits` bits without a sign as those with one, which have the same bits.
std::vector<double> as_signed(std::vector<double> values, int bits) {
  for (double& v : values)
    if (v >= std::ldexp(1.0, bits - 1)) v -= std::ldexp(1.0, bits);
  return values;
}

TEST(NetcdfValues, ReadsBytesMeantUnsigned) {
  Scratch s;
  NcFile nc(s.path("a.nc"), plain_dims, NC_BYTE);
  nc.put("_Unsigned", "true");
  nc.put("scale_factor", 0.4);
  nc.put("add_offset", 10.0);
  nc.put("_FillValue", -1.0, -1, NC_BYTE);
  std::vector<double> stored(nc.count);
  for (size_t i = 0; i < stored.size(); ++i) stored[i] = static_cast<double>(2 * i + 15);
  stored[3] = 255;
  nc.finish(as_signed(stored, 8));
  const auto reader = open_series(inputs({s.path("a.nc")}));
  EXPECT_EQ(reader->description().channels[0].precision, Type::u8);
  const std::vector<double> first = dense(*reader, 0), last = dense(*reader, 4);
  EXPECT_TRUE(std::isnan(first[3]));
  EXPECT_NEAR(first[2], 0.4 * 19 + 10, 1e-5);
  EXPECT_NEAR(last[23], 0.4 * 253 + 10, 1e-5);
}

TEST(NetcdfValues, ReadsLimitsMeantUnsigned) {
  Scratch s;
  NcFile nc(s.path("a.nc"), plain_dims, NC_SHORT);
  const short range[] = {0, static_cast<short>(50000 - 65536)};
  nc.put("_Unsigned", "true");
  check_nc(nc_put_att_short(nc.id, nc.variable, "valid_range", NC_SHORT, 2, range));
  std::vector<double> stored(nc.count, 40000);
  stored[5] = 50001;
  nc.finish(as_signed(stored, 16));
  const std::vector<double> frame = dense(*open_series(inputs({s.path("a.nc")})), 0);
  EXPECT_EQ(frame[4], 40000);
  EXPECT_TRUE(std::isnan(frame[5]));

  NcFile turned(s.path("b.nc"), plain_dims, NC_SHORT);
  check_nc(nc_put_att_short(turned.id, turned.variable, "valid_range", NC_SHORT, 2, range));
  turned.finish();
  EXPECT_REFUSED(refusal(inputs({s.path("b.nc")})), Exit::bad_input, "no valid values");
}

TEST(NetcdfValues, ReadsUnsignedBytesMeantSigned) {
  Scratch s;
  NcFile nc(s.path("a.nc"), plain_dims, NC_UBYTE, NC_NETCDF4);
  nc.put("_Unsigned", "false");
  nc.put("missing_value", 255.0, -1, NC_UBYTE);
  std::vector<double> stored(nc.count, 250);
  stored[1] = 255;
  nc.finish(stored);
  const std::vector<double> frame = dense(*open_series(inputs({s.path("a.nc")})), 0);
  EXPECT_EQ(frame[0], -6);
  EXPECT_TRUE(std::isnan(frame[1]));
}

TEST(NetcdfValues, TakesFloatsBesidePackedIntegersForValues) {
  Scratch s;
  NcFile nc(s.path("a.nc"), plain_dims, NC_SHORT);
  nc.put("scale_factor", -0.5);
  nc.put("add_offset", 1.0);
  nc.put("missing_value", -2.5); // stored 7
  nc.put("valid_min", -49.0);    // stored 100 at most
  nc.put("valid_max", 0.0);      // stored 2 at least
  nc.finish();
  const auto reader = open_series(inputs({s.path("a.nc")}));
  const std::vector<double> first = dense(*reader, 0), last = dense(*reader, 4);
  EXPECT_TRUE(std::isnan(first[7]) && std::isnan(first[1]) && std::isnan(last[5]));
  EXPECT_EQ(first[2], 0);
  EXPECT_EQ(first[8], -3);
  EXPECT_EQ(last[4], -49);

  // No short stands for the value -32768: it is told as stored.
  NcFile stored(s.path("b.nc"), plain_dims, NC_SHORT);
  stored.put("scale_factor", 0.01);
  stored.put("missing_value", -32768.0);
  std::vector<double> values(stored.count, 100);
  values[0] = -32768;
  stored.finish(values);
  const std::vector<double> frame = dense(*open_series(inputs({s.path("b.nc")})), 0);
  EXPECT_TRUE(std::isnan(frame[0]));
  EXPECT_EQ(frame[1], 1);
}

TEST(NetcdfValues, ComparesDoublesOfAttributesAsFloats) {
  Scratch s;
  NcFile nc(s.path("a.nc"), plain_dims);
  nc.put("missing_value", -999.9);
  std::vector<double> values(nc.count, 1);
  values[2] = -999.9;
  nc.finish(values);
  EXPECT_TRUE(std::isnan(dense(*open_series(inputs({s.path("a.nc")})), 0)[2]));
}

TEST(NetcdfValues, UnpacksCoordinatesAndTimes) {
  Scratch s;
  NcFile nc(s.path("a.nc"), {{"time", 5, "days since 2000-01-01", 1, NC_SHORT},
                             {"lev", 4, "m", 1, NC_SHORT},
                             {"lat", 3, "degrees_north"},
                             {"lon", 2, "degrees_east", -1, NC_BYTE}});
  nc.put("scale_factor", 0.25, nc.axes[0].first);
  nc.put("scale_factor", 10.0, nc.axes[1].first);
  nc.put("add_offset", 5.0, nc.axes[1].first);
  nc.put("scale_factor", 0.1, nc.axes[3].first);
  nc.put("_Unsigned", "true", nc.axes[3].first);
  nc.finish();
  const auto reader = open_series(inputs({s.path("a.nc")}));
  const SeriesDescription& d = reader->description();
  EXPECT_EQ(d.times.values, (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_EQ(d.affine[10], 10);
  EXPECT_EQ(d.affine[11], 5);
  EXPECT_NEAR(d.affine[0], 25.5, 1e-9); // from 0 to 255
}

TEST(NetcdfValues, CountsCurvilinearGridsByIndex) {
  Scratch s;
  NcFile nc(s.path("a.nc"), {{"time", 5}, {"lev", 4, "m", 10}, {"y", 3}, {"x", 2}});
  int ids[2], other = 0;
  check_nc(nc_inq_dimid(nc.id, "y", &ids[0]));
  check_nc(nc_inq_dimid(nc.id, "x", &ids[1]));
  check_nc(nc_def_var(nc.id, "LON", NC_DOUBLE, 2, ids, &other));
  nc.put("units", "degrees_east", other);
  nc.put("coordinates", "LON");
  nc.finish();
  const auto reader = open_series(inputs({s.path("a.nc")}));
  const SeriesDescription& d = reader->description();
  ASSERT_EQ(d.warnings.size(), 1u);
  EXPECT_NE(d.warnings[0].find("LON"), std::string::npos);
  EXPECT_NE(d.warnings[0].find("--spacing"), std::string::npos);
  EXPECT_EQ(d.affine, (std::array<double, 16>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 10, 0, 0, 0, 0, 1}));
  EXPECT_EQ(d.spatial_unit, "");
}

} // namespace
} // namespace bcc4::test

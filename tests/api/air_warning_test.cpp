// SPDX-License-Identifier: Apache-2.0
// A host that leaves air where its values are not is told so, in the log of its device.
#include <cmath>
#include <numeric>

#include "support.h"

namespace host {
namespace {

struct Log {
  std::vector<std::string> warnings;

  static void take(void* user, int32_t level, const char* message) {
    if (level == BCCSPLAT_LOG_WARNING) static_cast<Log*>(user)->warnings.emplace_back(message);
  }
  [[nodiscard]] Device device() {
    auto o = sized<bccsplat_device_options>();
    o.log = take, o.log_user = this;
    bccsplat_device* d = nullptr;
    EXPECT_OK(bccsplat_device_create(&o, &d));
    return Device(d);
  }
};

double waves(double x, double y, double z, double t) {
  return 50 * std::sin(0.3 * x + 0.2 * y - 0.25 * z + 0.4 * t);
}

// Writes the series and returns what the device's log got; air NaN: cleared options. as_part: all of it.
std::vector<std::string> warnings_of(const Field& field, double air = NAN, double abs_error = 0,
                                     bool as_part = false) {
  Log log;
  const Folder folder;
  const Device device = log.device();
  const Series s{.field = field};
  auto options = options_of(s);
  options.abs_error = abs_error;
  std::vector<double> times(s.nt);
  std::iota(times.begin(), times.end(), 0.0);
  auto part = sized<bccsplat_series_part>();
  part.end = s.nt, part.times = times.data();
  if (as_part) options.part = &part;
  auto channel = sized<bccsplat_channel_options>();
  channel.name = "pressure";
  if (!std::isnan(air)) channel.air = air, channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
  options.channels = &channel, options.channel_count = 1;
  const Writer w = make_writer(device, folder.file("p.bcc4"), options);
  EXPECT_OK(add_frames(w.get(), s));
  EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
  return log.warnings;
}

Field around(double base) {
  return [base](double x, double y, double z, double t) { return base + waves(x, y, z, t); };
}

// Parts of a series do not know each other's values: they are corrected above air, and ripple about it.
TEST(AirWarning, ABoundOfAPartFarFromAirIsWarnedOf) {
  const std::vector<std::string> warnings = warnings_of(around(101325), NAN, 1, true);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("pressure"), std::string::npos);
  EXPECT_NE(warnings[0].find("243."), std::string::npos); // 0.24 % of 101374
  EXPECT_TRUE(warnings_of(around(101325), 101325, 1, true).empty());
  EXPECT_TRUE(warnings_of(around(101325), NAN, 0, true).empty());
  EXPECT_TRUE(warnings_of(around(101325), NAN, 1).empty()); // a whole one tells its base
  // Far is a matter of the values' range.
  EXPECT_TRUE(warnings_of(around(700), NAN, 1, true).empty());
  EXPECT_EQ(warnings_of(around(800), NAN, 1, true).size(), 1u);
  EXPECT_EQ(warnings_of(around(-800), NAN, 1, true).size(), 1u);
}

// What is stored is the distance from air, as a float.
TEST(AirWarning, StepsOfFloatsFarFromAirAreWarnedOf) {
  const std::vector<std::string> warnings = warnings_of(around(2e7));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("steps of 2;"), std::string::npos) << warnings[0];
  EXPECT_TRUE(warnings_of(around(2e7), 2e7).empty());
  EXPECT_TRUE(warnings_of(around(2e6)).empty());
}

TEST(AirWarning, WhereThereIsAirItIsMeant) {
  // A cloud of nearly constant density, cut off.
  const auto cloud = [](double x, double y, double z, double t) {
    return std::hypot(x - 9, y - 9, z - 9) < 5 ? 1 + 1e-4 * waves(x, y, z, t) : 0.0;
  };
  EXPECT_TRUE(warnings_of(cloud).empty());
  EXPECT_TRUE(warnings_of([](double, double, double, double) { return 0.0; }).empty());
}

} // namespace
} // namespace host

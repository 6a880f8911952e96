// SPDX-License-Identifier: Apache-2.0
// A gap in time: what is not measured is told, and the way to measure it of a series whose length is not
// known.
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "support.h"

using namespace host;

namespace {

// A wave that goes on while nothing is written.
Series with_gap(double gap) {
  Series s{.nt = 12};
  for (uint32_t t = 0; t < s.nt; ++t) s.times.push_back(t < 6 ? t : t + gap);
  s.field = [times = s.times](double x, double y, double z, double t) {
    return 40 * std::sin(0.3 * x + 0.2 * y - 0.1 * z + 0.35 * times[static_cast<size_t>(t)]);
  };
  return s;
}

class TimeGap : public testing::Test {
 protected:
  void SetUp() override {
    auto o = sized<bccsplat_device_options>();
    o.log = [](void* user, bccsplat_log_level level, const char* text) {
      if (level == BCCSPLAT_LOG_WARNING) static_cast<std::vector<std::string>*>(user)->emplace_back(text);
    };
    o.log_user = &warnings_;
    bccsplat_device* d = nullptr;
    ASSERT_OK(bccsplat_device_create(&o, &d));
    device_ = Device(d);
  }
  // Writes the series, and returns the largest difference at its samples.
  double write(const Series& s, bccsplat_writer_options o) {
    warnings_.clear();
    const std::string path = folder_.free_file("s.bcc4");
    {
      const Writer w = make_writer(device_, path, o);
      EXPECT_OK(add_frames(w.get(), s));
      EXPECT_OK(bccsplat_writer_finish_short(w.get(), nullptr));
    }
    const Volume v = open(device_, path);
    double off = 0;
    for (uint32_t t = 0; t < s.nt; ++t)
      for (double x = 3; x < 15; x += 3) {
        const double at[4] = {x, 9, 8, static_cast<double>(t)};
        float value = 0;
        EXPECT_OK(bccsplat_volume_evaluate(v.get(), 1, at, &value, nullptr));
        off = larger(off, std::fabs(static_cast<double>(value) - s.field(x, 9, 8, t)));
      }
    return off;
  }
  const Folder folder_;
  std::vector<std::string> warnings_;
  Device device_;
};

TEST_F(TimeGap, IsToldWhereItWasNotMeasured) {
  const Series s = with_gap(9), even = with_gap(0);
  for (const uint32_t frames : {0u, s.nt}) {
    SCOPED_TRACE(frames);
    auto o = options_of(s);
    o.dims[3] = frames;
    const double off = write(s, o);
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_[0].find("frames 5 and 6 are 10 apart, others 1"), std::string::npos) << warnings_[0];
    EXPECT_GT(off, 2 * write(even, o)) << "the case that it is about";
    EXPECT_TRUE(warnings_.empty());
  }
}

TEST_F(TimeGap, TheWayThatIsNamedKeepsTheBound) {
  const Series s = with_gap(9);
  auto o = options_of(s);
  o.dims[3] = 0, o.abs_error = 0.1;
  bccsplat_writer* w = nullptr;
  EXPECT_EQ(bccsplat_writer_create(device_.get(), folder_.file("n.bcc4").c_str(), &o, &w),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::strstr(bccsplat_last_error(), "finish_short"), nullptr) << bccsplat_last_error();
  o.dims[3] = 40; // more than come
  EXPECT_LE(write(s, o), 0.1);
  EXPECT_TRUE(warnings_.empty());
}

} // namespace

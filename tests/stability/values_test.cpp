// SPDX-License-Identifier: Apache-2.0
// Values at the edges of their types.
#include "tests/stability/stability.h"

namespace host {
namespace {

// A normal half float: sign, exponent + 15, ten bits of the mantissa.
uint16_t half_bits(double value) {
  if (std::abs(value) < 0x1p-14) return 0;
  int exponent = 0;
  const double mantissa = std::frexp(std::abs(value), &exponent); // [0.5, 1)
  const auto bits = (exponent + 14) * 1024 + static_cast<int>(std::lround((2 * mantissa - 1) * 1024));
  return static_cast<uint16_t>((value < 0 ? 0x8000 : 0) | bits);
}

Series waves(double offset, double amplitude) {
  Series s{.nx = 17, .ny = 13, .nz = 11, .nt = 9};
  s.field = [=](double x, double y, double z, double t) {
    const double c = std::cos(std::numbers::pi * x / 16) * std::cos(std::numbers::pi * y / 12) +
                     std::cos(std::numbers::pi * z / 10) * std::cos(std::numbers::pi * t / 8);
    return offset + amplitude * c;
  };
  return s;
}

TEST(StabilityValues, ConstantsOfAnySizeComeBack) {
  const Device device = make_device();
  for (const double value : {1e-30, 1.0, 1e30, -1e35}) {
    Series s{
        .nx = 9, .ny = 8, .nz = 7, .nt = 5, .field = [=](double, double, double, double) { return value; }};
    const Stored stored = store(device, s);
    Bound bound("constant " + shown(value) + ", relative", 1e-6); // what all samples have is the base
    for (const float v : values_at(stored.volume, random_points(s, 500))) bound.add(v / value - 1);
  }
}

TEST(StabilityValues, ScalingTheFieldScalesTheResult) {
  const Device device = make_device();
  const Series one = waves(3, 1); // nowhere near air, where a rule and not arithmetic decides what is kept
  const Stored stored = store(device, one);
  const std::vector<double> points = random_points(one, 400);
  const std::vector<float> values = values_at(stored.volume, points);
  // Powers of two change no bit of a mantissa, so not the slightest difference is allowed.
  for (const double factor : {0x1p-60, 0x1p10, 0x1p60}) {
    const Series s = waves(3 * factor, factor);
    const Stored scaled = store(device, s);
    const std::vector<float> got = values_at(scaled.volume, points);
    Bound bound("field times " + shown(factor), 0);
    for (size_t i = 0; i < values.size(); ++i) bound.add(got[i] / factor - values[i]);
  }
}

TEST(StabilityValues, ASmallSignalOnALargeOffsetSurvivesRelativeToAir) {
  const Device device = make_device();
  const Series s = waves(1e6, 1), plain = waves(0, 1);
  auto channel = sized<bccsplat_channel_options>();
  channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
  channel.air = 1e6;
  bccsplat_writer_options o = options_of(s);
  o.channels = &channel, o.channel_count = 1;
  const Stored stored = store(device, s, o), reference = store(device, plain);
  const std::vector<double> points = random_points(s, 400);
  const std::vector<float> got = values_at(stored.volume, points), want = values_at(reference.volume, points);
  // A float near 1e6 knows 1/16: half of that times the prefilter's gain in each of space and time.
  Bound bound("offset 1e6, signal 1", 0.25);
  for (size_t i = 0; i < got.size(); ++i) bound.add(got[i] - 1e6 - want[i]);
}

TEST(StabilityValues, DenormalsNeitherTrapNorGrow) {
  const Device device = make_device();
  const double tiny = 1e-40;
  const Series s = waves(0, tiny);
  const Stored stored = store(device, s);
  Bound bound("waves of 2e-40, largest value", 4 * tiny);
  double most = 0;
  for (const float v : values_at(stored.volume, random_points(s, 200)))
    bound.add(v), most = larger(most, std::fabs(v));
  EXPECT_GT(most, tiny); // nor vanish
}

TEST(StabilityValues, NotANumberAndInfinityFollowThePolicy) {
  const Device device = make_device();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    Series s = waves(5, 1);
    const Field field = s.field;
    s.field = [=](double x, double y, double z, double t) {
      return x == 8 && y == 6 && z == 5 && t == 4 ? bad : field(x, y, z, t);
    };
    bccsplat_writer_options o = options_of(s);
    o.nonfinite = BCCSPLAT_NONFINITE_ERROR;
    MemoryFile file;
    const Writer writer = make_writer(device, file, o);
    bccsplat_writer* const w = writer.get();
    bccsplat_status status = add_frames(w, s);
    if (status == BCCSPLAT_OK) status = bccsplat_writer_finish(w, nullptr);
    EXPECT_EQ(status, BCCSPLAT_ERROR_NONFINITE_VALUE);
    const std::string text = bccsplat_last_error();
    EXPECT_NE(text.find("frame 4: 1 values are "), std::string::npos) << text;
    EXPECT_NE(text.find("voxel (8, 6, 5)"), std::string::npos) << text;

    o.nonfinite = BCCSPLAT_NONFINITE_HOLE;
    const Stored holes = store(device, s, o);
    float value = 0;
    const double at[] = {8, 6, 5, 4}, far[] = {2, 2, 2, 1};
    EXPECT_EQ(bccsplat_volume_evaluate(holes.volume.get(), 1, at, &value, nullptr), BCCSPLAT_ERROR_HOLE);
    EXPECT_TRUE(std::isnan(value));
    ASSERT_OK(bccsplat_volume_evaluate(holes.volume.get(), 1, far, &value, nullptr));
    // The hole reaches no further than its neighbourhood.
    Bound("away from a hole left by " + shown(bad), 0.05).add(value - field(2, 2, 2, 1));

    o.nonfinite = BCCSPLAT_NONFINITE_CLAMP;
    const Stored clamped = store(device, s, o);
    EXPECT_TRUE(all_finite(values_at(clamped.volume, random_points(s, 300))));
  }
}

TEST(StabilityValues, EverySourceTypeKeepsItsEndsOfRange) {
  const Device device = make_device();
  struct Case {
    const char* name;
    int32_t type;
    double low, high, tolerance; // of the range: coding plus the kernel's error on a slow wave
  };
  for (const Case& c :
       {Case{"u8", BCCSPLAT_TYPE_U8, 0, 255, 0.006}, Case{"i8", BCCSPLAT_TYPE_I8, -128, 127, 0.006},
        Case{"u16", BCCSPLAT_TYPE_U16, 0, 65535, 0.004}, Case{"i16", BCCSPLAT_TYPE_I16, -32768, 32767, 0.004},
        Case{"u32", BCCSPLAT_TYPE_U32, 0, 4294967295.0, 0.004},
        Case{"i32", BCCSPLAT_TYPE_I32, -2e9, 2e9, 0.004},
        Case{"f16", BCCSPLAT_TYPE_F16, -65504, 65504, 0.004},
        Case{"f32", BCCSPLAT_TYPE_F32, -1e30, 1e30, 0.004},
        Case{"f64", BCCSPLAT_TYPE_F64, -1e30, 1e30, 0.004}}) {
    const Series s{.nx = 12, .ny = 11, .nz = 10, .nt = 5};
    const auto at = [&](double x) {
      return (c.low + c.high) / 2 - (c.high - c.low) / 2 * std::cos(std::numbers::pi * x / 11);
    };
    bccsplat_writer_options o = options_of(s);
    o.measure = BCCSPLAT_MEASURE_ALL;
    Stored stored;
    const Writer writer = make_writer(device, *stored.file, o);
    bccsplat_writer* const w = writer.get();
    for (uint32_t t = 0; t < s.nt; ++t) {
      std::vector<unsigned char> bytes;
      const auto put = [&](auto v) {
        const auto* raw = reinterpret_cast<const unsigned char*>(&v);
        bytes.insert(bytes.end(), raw, raw + sizeof v);
      };
      for (uint32_t i = 0; i < s.nx * s.ny * s.nz; ++i) {
        const double v = std::clamp(at(i % s.nx), c.low, c.high);
        switch (c.type) {
        case BCCSPLAT_TYPE_U8:
          put(static_cast<uint8_t>(std::lround(v)));
          break;
        case BCCSPLAT_TYPE_I8:
          put(static_cast<int8_t>(std::lround(v)));
          break;
        case BCCSPLAT_TYPE_U16:
          put(static_cast<uint16_t>(std::lround(v)));
          break;
        case BCCSPLAT_TYPE_I16:
          put(static_cast<int16_t>(std::lround(v)));
          break;
        case BCCSPLAT_TYPE_U32:
          put(static_cast<uint32_t>(std::llround(v)));
          break;
        case BCCSPLAT_TYPE_I32:
          put(static_cast<int32_t>(std::lround(v)));
          break;
        case BCCSPLAT_TYPE_F16:
          put(half_bits(v));
          break;
        case BCCSPLAT_TYPE_F32:
          put(static_cast<float>(v));
          break;
        default:
          put(v);
        }
      }
      auto box = sized<bccsplat_box>();
      box.type = c.type, box.data = bytes.data();
      box.dims[0] = s.nx, box.dims[1] = s.ny, box.dims[2] = s.nz;
      ASSERT_OK(bccsplat_writer_add_frame(w, 0, t, &box, 1));
    }
    ASSERT_OK(bccsplat_writer_finish(w, nullptr));
    // The writer's own comparison with the source reads every type, too.
    auto measured = sized<bccsplat_error_report>();
    ASSERT_OK(bccsplat_writer_get_error(w, 0, -1, &measured));
    EXPECT_EQ(measured.samples, uint64_t{s.nx} * s.ny * s.nz * s.nt);
    EXPECT_NEAR(measured.peak / (c.high - c.low), 1, 1e-3) << c.name;
    Bound(c.name + std::string(" as the writer measured it, of the range"), c.tolerance)
        .add(measured.max_abs / (c.high - c.low));
    bccsplat_volume* v = nullptr;
    ASSERT_OK(bccsplat_volume_open_memory(device.get(), stored.file->bytes.data(), stored.file->bytes.size(),
                                          nullptr, &v));
    stored.volume.reset(v);
    const std::vector<double> points = random_points(s, 300);
    const std::vector<float> got = values_at(stored.volume, points);
    Bound bound(c.name + std::string(" over its range, of the range"), c.tolerance);
    for (size_t i = 0; i < got.size(); ++i) bound.add((got[i] - at(points[4 * i])) / (c.high - c.low));
  }
}

// Air, 0, lies between two codes. What is left out is air, and the bound is kept with that.
TEST(StabilityValues, ABoundHoldsWhereAirHasNoCode) {
  const Device device = make_device();
  const Series s{.nx = 24, .ny = 22, .nz = 20, .nt = 6, .field = [](double x, double y, double z, double t) {
                   return 40 * std::sin(0.9 * x + 0.3 * t) * std::cos(0.7 * y) * std::cos(0.6 * z - 0.2 * t);
                 }};
  auto options = options_of(s);
  auto channel = sized<bccsplat_channel_options>();
  channel.value_type = BCCSPLAT_TYPE_U8;
  channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE, channel.range[0] = -40, channel.range[1] = 40;
  options.channels = &channel, options.channel_count = 1;
  options.abs_error = 0.1;
  const Stored stored = store(device, s, options);
  Bound bound("source samples of a file with a bound of 0.1", 0.1);
  for (uint32_t t = 0; t < s.nt; ++t) {
    const std::vector<float> got = grid_of(cut_time(stored.volume, t));
    size_t i = 0;
    for (uint32_t z = 0; z < s.nz; ++z)
      for (uint32_t y = 0; y < s.ny; ++y)
        for (uint32_t x = 0; x < s.nx; ++x)
          bound.add(got[i++] - static_cast<double>(static_cast<float>(s.field(x, y, z, t))));
  }
}

} // namespace
} // namespace host

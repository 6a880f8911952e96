// SPDX-License-Identifier: Apache-2.0
// Frames of any type and shape as floats relative to air, and what a scan of one finds.
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "base/half.h"
#include "fit/frame/frame.h"
#include "fit/frame/scan.h"
#include "fit/frame/unpack.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

template<class T>
std::vector<float> unpacked(SourceType type, const std::vector<T>& values, float air, size_t gap) {
  // Unaligned, with `gap` bytes between samples.
  std::vector<std::byte> bytes(1 + values.size() * (sizeof(T) + gap));
  for (size_t i = 0; i < values.size(); ++i)
    std::memcpy(bytes.data() + 1 + i * (sizeof(T) + gap), &values[i], sizeof(T));
  std::vector<float> out(values.size(), -1);
  unpack_row(type, bytes.data() + 1, sizeof(T) + gap, values.size(), air, out.data());
  return out;
}

template<class T> void check_type(SourceType type, const std::vector<T>& values) {
  EXPECT_EQ(source_bytes(type), sizeof(T));
  for (const float air : {0.0f, 3.0f})
    for (const size_t gap : {0, 3}) {
      const auto out = unpacked(type, values, air, gap);
      for (size_t i = 0; i < values.size(); ++i)
        EXPECT_EQ(out[i], static_cast<float>(static_cast<double>(values[i]) - air)) << int(type) << " " << i;
    }
}

template<class T> std::vector<T> range_of_integers() {
  std::vector<T> v{std::numeric_limits<T>::min(), 0, 1, std::numeric_limits<T>::max()};
  for (int i = 0; i < 60; ++i) v.push_back(static_cast<T>(i * 2654435761u));
  return v;
}

TEST(ResampleFrame, UnpacksEveryType) {
  check_type(SourceType::u8, range_of_integers<uint8_t>());
  check_type(SourceType::i8, range_of_integers<int8_t>());
  check_type(SourceType::u16, range_of_integers<uint16_t>());
  check_type(SourceType::i16, range_of_integers<int16_t>());
  check_type(SourceType::u32, range_of_integers<uint32_t>());
  check_type(SourceType::i32, range_of_integers<int32_t>());
  check_type(SourceType::f32, std::vector<float>{0, 1.5f, -3e38f, 1e-40f, 7e9f});
  check_type(SourceType::f64, std::vector<double>{0, 1.0 / 3, -3e38, 3 + 1e-12, 7e9 + 1});
}

TEST(ResampleFrame, UnpacksEveryHalf) {
  std::vector<uint16_t> all(65536);
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<uint16_t>(i);
  for (const size_t gap : {0, 2}) {
    const auto out = unpacked(SourceType::f16, all, 0, gap);
    for (size_t i = 0; i < all.size(); ++i) {
      const float expected = half_to_float(all[i]);
      if (std::isnan(expected))
        EXPECT_TRUE(std::isnan(out[i])) << i;
      else
        EXPECT_EQ(out[i], expected) << i;
    }
  }
}

TEST(ResampleFrame, ReadsAnyRegionOfAnyBoxes) {
  const Series s = noise({20, 9, 13, 1}, 1);
  const std::array<int64_t, 3> dims{20, 9, 13};
  const FrameBox whole = s.box(0);
  // Dense; and the same in columns whose y runs backwards in memory.
  std::vector<float> turned;
  for (int64_t z = 0; z < 13; ++z)
    for (int64_t y = 8; y >= 0; --y)
      for (int64_t x = 0; x < 20; ++x) turned.push_back(s.at(x, y, z, 0));
  std::vector<FrameBox> columns;
  for (int64_t x = 0; x < 20; ++x)
    columns.push_back(
        {turned.data() + 8 * 20 + x, SourceType::f32, {x, 0, 0}, {1, 9, 13}, {4, -80, 4 * 180}});
  const Frame dense({&whole, 1}, dims, 0.25f, "dense"), many(columns, dims, 0.25f, "many");
  const Region region{{3, 2, 1}, {19, 8, 12}};
  for (const Frame* frame : {&dense, &many}) {
    std::vector<float> out(16 * 6 * 11, 99);
    frame->read(frame->boxes_in(region), region, out.data(), 16, 96);
    size_t i = 0;
    for (int64_t z = 1; z < 12; ++z)
      for (int64_t y = 2; y < 8; ++y)
        for (int64_t x = 3; x < 19; ++x) ASSERT_EQ(out[i++], s.at(x, y, z, 0) - 0.25f);
  }
}

TEST(ResampleFrame, RefusesBoxesThatDoNotFit) {
  const float value = 0;
  const auto refused = [&](FrameBox box) {
    try {
      Frame({&box, 1}, {4, 5, 6}, 0, "frame 3");
    } catch (const Error& e) {
      EXPECT_NE(e.message().find("frame 3"), std::string::npos);
      return e.code() == Code::invalid_argument;
    }
    return false;
  };
  const FrameBox good{&value, SourceType::f32, {3, 4, 5}, {1, 1, 1}, {}};
  EXPECT_FALSE(refused(good));
  for (size_t a = 0; a < 3; ++a) {
    FrameBox b = good;
    b.begin[a] = -1;
    EXPECT_TRUE(refused(b));
    b = good;
    b.dims[a] = 2;
    EXPECT_TRUE(refused(b));
    b.dims[a] = INT64_MAX;
    EXPECT_TRUE(refused(b));
    b.dims[a] = -1;
    EXPECT_TRUE(refused(b));
    b = good;
    b.begin[a] = INT64_MAX;
    EXPECT_TRUE(refused(b));
  }
  FrameBox b = good;
  b.type = SourceType::unknown;
  EXPECT_TRUE(refused(b));
  b = good;
  b.data = nullptr;
  EXPECT_TRUE(refused(b));
}

TEST(ResampleFrame, ScanCountsWhatIsThere) {
  Series s = noise({37, 21, 10, 1}, 2);
  s.values[5] = 7.5f;
  s.values[77] = -8.25f;
  const std::array<int64_t, 3> dims{37, 21, 10};
  const FrameBox box = s.box(0);
  for (const int threads : {1, 4}) {
    Bench bench(threads);
    const FrameScan scan = scan_frame(Frame({&box, 1}, dims, 0.5f, ""), 0.25f, bench.context);
    uint64_t relevant = 0;
    for (const float v : s.values) relevant += std::fabs(v - 0.5f) > 0.25f;
    EXPECT_EQ(scan.relevant, relevant);
    EXPECT_EQ(scan.nonfinite, 0u);
    EXPECT_EQ(scan.finite, s.values.size());
    EXPECT_EQ(scan.low, -8.25);
    EXPECT_EQ(scan.high, 7.5);
    // Cells bound their samples.
    for (int64_t z = 0; z < 10; ++z)
      for (int64_t y = 0; y < 21; ++y)
        for (int64_t x = 0; x < 37; ++x) {
          const auto cell = scan.cells.cell[scan.cells.index(x / 16, y / 8, z / 8)];
          ASSERT_LE(cell.low, s.at(x, y, z, 0) - 0.5f);
          ASSERT_GE(cell.high, s.at(x, y, z, 0) - 0.5f);
        }
  }
}

TEST(ResampleFrame, ScanFindsWhatIsNotFinite) {
  Series s = noise({40, 20, 12, 1}, 3);
  const auto put = [&](int64_t x, int64_t y, int64_t z, float v) { s.values[(z * 20 + y) * 40 + x] = v; };
  put(30, 2, 5, NAN);
  put(3, 9, 5, INFINITY);
  put(39, 19, 11, -INFINITY);
  const FrameBox box = s.box(0);
  for (const int threads : {1, 3}) {
    Bench bench(threads);
    const FrameScan scan = scan_frame(Frame({&box, 1}, {40, 20, 12}, 0, ""), 0, bench.context);
    EXPECT_EQ(scan.nonfinite, 3u);
    EXPECT_EQ(scan.finite, s.values.size() - 3);
    EXPECT_EQ(scan.first_nonfinite, (std::array<int64_t, 3>{30, 2, 5}));
    EXPECT_EQ(scan.nonfinite_region.begin, (std::array<int64_t, 3>{3, 2, 5}));
    EXPECT_EQ(scan.nonfinite_region.end, (std::array<int64_t, 3>{40, 20, 12}));
    EXPECT_LE(scan.high, 1);
  }
}

TEST(ResampleFrame, UncoveredSamplesAreAir) {
  const std::vector<float> values(8, 5.0f);
  const FrameBox box{values.data(), SourceType::f32, {4, 4, 4}, {2, 2, 2}, {}};
  Bench bench;
  const FrameScan scan = scan_frame(Frame({&box, 1}, {64, 64, 64}, 2, ""), 0, bench.context);
  EXPECT_EQ(scan.low, 2);
  EXPECT_EQ(scan.high, 5);
  EXPECT_EQ(scan.relevant, 8u);
  EXPECT_TRUE(scan.cells.range({{16, 0, 0}, {64, 64, 64}}).air());
  EXPECT_EQ(scan.cells.range({{0, 0, 0}, {16, 8, 8}}).low, 0);
  EXPECT_EQ(scan.cells.range({{0, 0, 0}, {16, 8, 8}}).high, 3);
}

} // namespace
} // namespace bccsplat::test

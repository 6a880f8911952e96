// SPDX-License-Identifier: Apache-2.0
// Masks of files: the one rule of what is missing, for points and for slices, and what becomes of damage.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "field/slice_mask.h"
#include "formats/bcc4/read/frame_sources.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr std::array<int64_t, 4> n{20, 11, 9, 5}; // of masked_file()

// What masked_file() says of its second channel.
bool missing(int64_t x, int64_t y, int64_t z, int64_t t) {
  const int64_t row = z * n[1] + y;
  return t < 2 && (x < 3 + row % 4 || (z == 8 && x >= 20 - 5 * t));
}

struct File {
  Bench bench;
  std::vector<std::byte> bytes = masked_file();
  std::shared_ptr<const Bcc4Reader> reader;
  explicit File(const Bcc4Limits& limits = {}) { open(limits); }
  void open(const Bcc4Limits& limits) { reader = Bcc4Reader::open(open_memory_source(bytes), limits); }
  [[nodiscard]] Masks masks() { return Masks(std::make_unique<Bcc4Masks>(reader, 1), bench.memory, 1 << 20); }
};

int64_t near(double p, int64_t count) {
  return std::clamp(static_cast<int64_t>(std::floor(p + 0.5)), int64_t{0}, count - 1);
}

TEST(Masks, TheNearestSourceSampleDecides) {
  File file;
  const Masks masks = file.masks();
  std::mt19937 random(3);
  std::vector<Vec4> points;
  for (int i = 0; i < 20000; ++i) {
    Vec4 p;
    for (size_t a = 0; a < 4; ++a) {
      p[a] = std::uniform_real_distribution<double>(-0.3, static_cast<double>(n[a]) - 0.7)(random);
      if (i % 4 == 0) p[a] = std::nearbyint(2 * p[a]) / 2; // half way: the later one
    }
    points.push_back(p);
  }
  std::vector<float> values(points.size(), 7);
  values[5] = NAN;
  std::vector<std::array<float, 4>> slopes(points.size());
  std::vector<uint8_t> marks(points.size());
  const uint64_t hidden = masks.hide(points, values, slopes, file.bench.context);
  masks.mark(points, marks, file.bench.context);
  uint64_t expected = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec4& p = points[i];
    const bool none = missing(near(p[0], n[0]), near(p[1], n[1]), near(p[2], n[2]), near(p[3], n[3]));
    expected += none && i != 5;
    EXPECT_EQ(std::isnan(values[i]), none || i == 5) << i;
    EXPECT_EQ(std::isnan(slopes[i][2]), none) << i;
    EXPECT_EQ(marks[i], none) << i;
  }
  EXPECT_EQ(hidden, expected);
  EXPECT_GT(expected, 1000u);
}

TEST(Masks, FramesShareWhatIsTheSame) {
  File file;
  const Masks masks(std::make_unique<Bcc4Masks>(file.reader, 0), file.bench.memory, 1 << 20);
  EXPECT_EQ(masks.frame(0), masks.frame(3));
  EXPECT_EQ(masks.frame(4), nullptr);
  EXPECT_EQ(masks.count(), 4 * masks.frame(0)->count());
  // Without a cache, too, as long as one of them is in use.
  const Masks bare(std::make_unique<Bcc4Masks>(file.reader, 0), file.bench.memory, 0);
  const auto held = bare.frame(0);
  EXPECT_EQ(held, bare.frame(2));
  const uint64_t used = file.bench.memory.used();
  EXPECT_GE(used, held->bytes());
}

TEST(Masks, SlicesMissWhatTheVolumeMisses) {
  File file;
  const Masks masks = file.masks();
  const Vec4 origin{16, 5, 8, 0.7};
  const std::array<Vec4, 3> basis{Vec4{0.6, 0, 0, 0.8}, Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}};
  const SliceMask slice(masks, origin, basis, 0, {masks.frame(0), masks.frame(1), masks.frame(2)});
  EXPECT_TRUE(slice.any());
  std::mt19937 random(4);
  size_t found = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 uvw{std::uniform_real_distribution<double>(-0.8, 2)(random),
                   std::uniform_real_distribution<double>(-5, 5)(random),
                   std::uniform_real_distribution<double>(-8, 0)(random)};
    const std::array<int64_t, 4> at{near(16 + 0.6 * uvw[0], n[0]), near(5 + uvw[1], n[1]),
                                    near(8 + uvw[2], n[2]), near(0.7 + 0.8 * uvw[0], n[3])};
    const bool none = missing(at[0], at[1], at[2], at[3]);
    ASSERT_EQ(slice.missing(uvw), none) << i;
    found += none;
  }
  EXPECT_GT(found, 0u);
  // What two instants have in common.
  const auto one = std::make_shared<const SliceMask>(masks, Vec4{}, basis, 1, std::vector{masks.frame(1)});
  const auto all = std::make_shared<const SliceMask>(masks, Vec4{}, basis, 0, std::vector{masks.frame(0)});
  const SliceMask both = one->also({one, all});
  EXPECT_TRUE(one->missing({18 / 0.6, 2, 8}));
  EXPECT_FALSE(both.missing({18 / 0.6, 2, 8}));
  EXPECT_TRUE(both.missing({0, 2, 8}));
}

// Boxes of samples, by their blocks or exactly: never none or all where it is not so, and exact where they
// are small.
TEST(Masks, BoxesOfAFrame) {
  const std::array<int64_t, 3> size{70, 19, 13};
  MemoryBudget budget(1 << 20);
  FrameMask mask(size, Reservation(budget, FrameMask::bytes_of(size), "a mask"), false);
  std::mt19937 random(7);
  const auto pick = [&](int64_t end) { return std::uniform_int_distribution<int64_t>(0, end - 1)(random); };
  for (int run = 0; run < 40; ++run) {
    const uint64_t begin = pick(70 * 19 * 13 - 200);
    mask.add(begin, begin + pick(200));
  }
  mask.add(0, 70 * 19 * 3); // the lowest planes
  mask.count_blocks();
  size_t told = 0;
  for (int i = 0; i < 20000; ++i) {
    std::array<int64_t, 3> first, last;
    for (size_t a = 0; a < 3; ++a) {
      first[a] = pick(size[a]), last[a] = std::min(size[a] - 1, first[a] + pick(i % 2 ? 4 : size[a]));
      if (i % 8 == 0) first[a] = 0;
    }
    uint64_t missing = 0, samples = 0;
    for (int64_t z = first[2]; z <= last[2]; ++z)
      for (int64_t y = first[1]; y <= last[1]; ++y)
        for (int64_t x = first[0]; x <= last[0]; ++x) missing += mask.at({x, y, z}), ++samples;
    const Missing truth = missing == 0 ? Missing::none : missing == samples ? Missing::all : Missing::some;
    const Missing said = mask.within(first, last);
    if (said != Missing::some || i % 2) {
      ASSERT_EQ(said, truth) << i;
    }
    told += said != Missing::some;
  }
  EXPECT_GT(told, 5000u);
  const FrameMask all(size, Reservation(budget, FrameMask::bytes_of(size), "a mask"), true);
  EXPECT_EQ(all.within({0, 0, 0}, {69, 18, 12}), Missing::all);
  EXPECT_EQ(all.within({65, 3, 12}, {69, 18, 12}), Missing::all);
}

// A plane of points says of each point what the slice says, and of rectangles nothing that does not hold for
// all of them.
TEST(Masks, PlanesOfSlices) {
  File file;
  const Masks masks = file.masks();
  const std::array<Vec4, 3> basis{Vec4{0.6, 0, 0, 0.8}, Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}};
  const SliceMask slice(masks, {6, 5, 4, 0.7}, basis, 0, {masks.frame(0), masks.frame(1), masks.frame(2)});
  const auto other = std::make_shared<const SliceMask>(masks, Vec4{}, basis, 0, std::vector{masks.frame(0)});
  const Vec3 o{-7, -4, -5}, u{0.31, 0.02, 0.11}, v{-0.07, 0.21, 0.13};
  for (const SliceMask& mask : {slice, slice.also({other})}) {
    const MaskPlane plane(mask, o, u, v);
    std::array<size_t, 3> said{};
    for (int j = 0; j < 60; j += 3)
      for (int i = 0; i < 90; i += 3) {
        const Missing within = plane.within({1.0 * i, i + 2.0}, {1.0 * j, j + 2.0});
        ++said[static_cast<size_t>(within)];
        for (int at = 0; at < 9; ++at) {
          const double x = i + at % 3, y = j + at / 3;
          const bool missing = mask.missing(o + x * u + y * v);
          ASSERT_EQ(plane.missing(x, y), missing) << x << ' ' << y;
          if (within != Missing::some) {
            ASSERT_EQ(missing, within == Missing::all) << x << ' ' << y;
          }
        }
      }
    for (const size_t count : said) EXPECT_GT(count, 10u);
  }
}

// Of a salvaged file the nearest whole mask tells; where none is whole, nothing is missing.
TEST(Masks, DamageIsMendedFromTheNearestFrame) {
  File file;
  const auto damage = [&](int channel, size_t frame) {
    const auto& block = file.reader->info().channels[channel].masks[frame];
    file.bytes[block.offset + 1] ^= std::byte{1};
  };
  damage(1, 1);
  file.open({});
  EXPECT_THROW((void)file.masks().frame(1), Error);
  EXPECT_NO_THROW((void)file.masks().frame(0));
  file.open({.salvage = true});
  const Masks mended = file.masks();
  // Frame 2, as near as frame 0 and later, misses nothing.
  EXPECT_EQ(mended.frame(1), nullptr);
  EXPECT_NE(mended.frame(0), nullptr);
  damage(0, 0);
  file.open({.salvage = true});
  const Masks lost(std::make_unique<Bcc4Masks>(file.reader, 0), file.bench.memory, 1 << 20);
  for (int64_t f = 0; f < 5; ++f) EXPECT_EQ(lost.frame(f), nullptr) << f;
  EXPECT_GT(lost.count(), 0u) << "as the metadata have it";
}

TEST(Masks, TheBudgetBoundsThem) {
  File file;
  MemoryBudget small(100);
  const Masks masks(std::make_unique<Bcc4Masks>(file.reader, 0), small, 1 << 20);
  try {
    (void)masks.frame(0);
    ADD_FAILURE() << "no budget was needed";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::memory_budget);
  }
}

} // namespace
} // namespace bccsplat

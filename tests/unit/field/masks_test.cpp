// SPDX-License-Identifier: Apache-2.0
// Masks of files: the one rule of what is missing, for points and for slices, and what becomes of damage.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "field/masks.h"
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
  [[nodiscard]] Masks masks() { return Masks(reader, 1, bench.memory, 1 << 20); }
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
  const Masks masks(file.reader, 0, file.bench.memory, 1 << 20);
  EXPECT_EQ(masks.frame(0), masks.frame(3));
  EXPECT_EQ(masks.frame(4), nullptr);
  EXPECT_EQ(masks.count(), 4 * masks.frame(0)->count());
  // Without a cache, too, as long as one of them is in use.
  const Masks bare(file.reader, 0, file.bench.memory, 0);
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

// Of a salvaged file the nearest whole mask tells; where none is whole, nothing is missing.
TEST(Masks, DamageIsMendedFromTheNearestFrame) {
  File file;
  const auto damage = [&](int channel, size_t frame) {
    const auto& block = file.reader->info().channels[static_cast<size_t>(channel)].masks[frame];
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
  const Masks lost(file.reader, 0, file.bench.memory, 1 << 20);
  for (int64_t f = 0; f < 5; ++f) EXPECT_EQ(lost.frame(f), nullptr) << f;
  EXPECT_EQ(lost.count(), 0u);
}

TEST(Masks, TheBudgetBoundsThem) {
  File file;
  MemoryBudget small(100);
  const Masks masks(file.reader, 0, small, 1 << 20);
  try {
    (void)masks.frame(0);
    ADD_FAILURE() << "no budget was needed";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::memory_budget);
  }
}

} // namespace
} // namespace bccsplat

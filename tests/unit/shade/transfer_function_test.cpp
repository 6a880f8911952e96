// SPDX-License-Identifier: Apache-2.0
// Transfer functions: values between and beyond their points, the tables made of them, what is refused, and
// the default.
#include "shade/transfer_function.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

TransferFunction example() {
  TransferFunction f;
  f.colors = {{0, {1, 0, 0}}, {2, {0, 1, 0}}, {4, {0, 0, 1}}};
  f.opacities = {{1, 0}, {2, 0.5}, {2, 0.1}, {3, 1}};
  return f;
}

TEST(TransferFunction, IsLinearBetweenPointsAndConstantBeyond) {
  const TransferFunction f = example();
  EXPECT_EQ(f.color(-1), (Vec3{1, 0, 0}));
  EXPECT_EQ(f.color(1), (Vec3{0.5, 0.5, 0}));
  EXPECT_EQ(f.color(2), (Vec3{0, 1, 0}));
  EXPECT_EQ(f.color(9), (Vec3{0, 0, 1}));
  EXPECT_EQ(f.opacity(0), 0);
  EXPECT_DOUBLE_EQ(f.opacity(1.5), 0.25);
  EXPECT_DOUBLE_EQ(f.opacity(2), 0.1); // a step belongs to the right
  EXPECT_DOUBLE_EQ(f.opacity(2.5), 0.55);
  EXPECT_EQ(f.opacity(7), 1);
}

TEST(TransferFunction, TableHoldsTheFunctionAtItsEntries) {
  const TransferFunction f = example();
  const ClassTable table = make_class_table(f, -10, 10, -10, 2.0, 401);
  ASSERT_EQ(table.size(), 401);
  for (const double value : {-9.0, 0.0, 0.51, 1.0, 1.99, 2.2, 3.0, 4.0, 9.5}) {
    const auto& e = table.entry[table.index(static_cast<float>(value))];
    const double half_entry = 0.5 * 4 / 400;
    EXPECT_NEAR(e[0], f.color(value)[0], half_entry) << value;
    EXPECT_NEAR(e[2], f.color(value)[2], half_entry) << value;
    const double opacity = -std::expm1(-e[3] * 2.0);
    EXPECT_NEAR(opacity, f.opacity(value), half_entry) << value;
  }
  // Only the values that occur get entries.
  EXPECT_NEAR(make_class_table(f, 1, 2, 1, 1, 101).low, 1, 1e-6);
  EXPECT_EQ(make_class_table(f, 5, 5, 0, 1, 101).size(), 1);
}

TEST(TransferFunction, TableKnowsWhatIsVisible) {
  TransferFunction f = example();
  f.opacities = {{1, 0}, {1.5, 0.5}, {2, 0}, {3, 0}, {3.5, 1}};
  const ClassTable table = make_class_table(f, 0, 4, 0, 1, 4001);
  EXPECT_FALSE(table.visible(0, 1));
  EXPECT_TRUE(table.visible(0, 1.1));
  EXPECT_FALSE(table.visible(2.01, 2.99));
  EXPECT_TRUE(table.visible(2.01, 3.2));
  EXPECT_TRUE(table.visible(0, 4));
  for (int i = 0; i < table.size(); ++i)
    if (table.entry[i][3] > 0) {
      EXPECT_GE(i, table.first_visible);
      EXPECT_LE(i, table.last_visible);
    }
}

TEST(TransferFunction, RefusesSenselessPoints) {
  const auto bad = [](auto change) {
    TransferFunction f = example();
    change(f);
    try {
      f.check();
      return false;
    } catch (const Error& e) {
      return e.code() == Code::invalid_argument;
    }
  };
  EXPECT_FALSE(bad([](TransferFunction&) {}));
  EXPECT_TRUE(bad([](TransferFunction& f) { f.colors.clear(); }));
  EXPECT_TRUE(bad([](TransferFunction& f) { f.opacities.clear(); }));
  EXPECT_TRUE(bad([](TransferFunction& f) { f.opacities[1].opacity = 1.5; }));
  EXPECT_TRUE(bad([](TransferFunction& f) { f.opacities[1].value = 0; }));
  EXPECT_TRUE(bad([](TransferFunction& f) { f.colors[1].value = std::nan(""); }));
  EXPECT_TRUE(bad([](TransferFunction& f) { f.unit_distance = -1; }));
}

TEST(TransferFunction, ViridisEndsWhereItShould) {
  // 8-bit sRGB 68 1 84 and 253 231 37.
  EXPECT_NEAR(viridis(0)[2], 0.0887, 1e-3);
  EXPECT_NEAR(viridis(1)[0], 0.9823, 1e-3);
  EXPECT_NEAR(viridis(1)[1], 0.7991, 1e-3);
  double before = 0;
  for (int i = 0; i <= 100; ++i) { // lightness rises throughout
    const Vec3 c = viridis(i / 100.0);
    const double luminance = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    EXPECT_GT(luminance, before);
    before = luminance;
  }
}

TEST(ClassTable, AirStandsOnAnEntry) {
  TransferFunction f;
  f.colors = {{0, {1, 1, 1}}};
  f.opacities = {{-0.0213, 0.1}, {0, 0}, {0.97, 0.3}};
  for (const int entries : {64, 1024, 2048}) {
    const ClassTable table = make_class_table(f, -0.0431, 1.02, 0, 1, entries);
    EXPECT_FALSE(table.visible(0, 0)) << entries;
    EXPECT_TRUE(table.visible(0.9 / entries, 2.0 / entries));
  }
}

} // namespace
} // namespace bccsplat

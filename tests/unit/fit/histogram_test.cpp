// SPDX-License-Identifier: Apache-2.0
// Percentiles and bins of stored samples, against sorting them.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "fit/kept/histogram.h"

namespace bccsplat {
namespace {

Brick brick_of(std::span<const float> values) {
  Brick b;
  for (size_t i = 0; i < values.size(); ++i) {
    b.value[i] = values[i];
    b.kept[i / 16] = static_cast<uint16_t>(b.kept[i / 16] | 1u << (i % 16));
  }
  return b;
}

TEST(QuantizeHistogram, PercentilesOfFloatsAreCloseWhateverTheirScale) {
  std::mt19937 random(1);
  std::lognormal_distribution<float> wide(0, 4); // ten decades
  for (const float sign : {1.0f, -1.0f}) {
    SampleHistogram h(quantiser_of_source(SourceType::f32, 0));
    std::vector<float> all;
    for (int b = 0; b < 20; ++b) {
      std::vector<float> values(4000);
      for (float& v : values) v = sign * wide(random);
      h.add(brick_of(values));
      all.insert(all.end(), values.begin(), values.end());
    }
    std::sort(all.begin(), all.end());
    EXPECT_EQ(h.count(), all.size());
    EXPECT_EQ(h.range(), (Range{all.front(), all.back()}));
    for (const double p : {0.001, 0.02, 0.3, 0.5, 0.9, 0.998}) {
      const double truth = all[static_cast<size_t>(std::ceil(p * static_cast<double>(all.size()))) - 1];
      EXPECT_NEAR(h.percentile(p), truth, std::fabs(truth) / 2048);
    }
    EXPECT_EQ(h.percentile(0), h.range().low);
    EXPECT_EQ(h.percentile(1), h.range().high);
  }
}

// Rows of which all sites count go side by side, others one by one.
TEST(QuantizeHistogram, WholeRowsCountAsTheirSites) {
  std::mt19937 random(7);
  SampleHistogram together(quantiser_of_source(SourceType::f32, 0)), apart = together;
  for (const float reach : {3.0f, 300.0f, 3e9f, 3e-12f}) {
    std::uniform_real_distribution<float> even(-reach, reach);
    std::vector<float> values(brick_sites);
    for (float& v : values) v = even(random);
    values[40] = -0.0f;
    const Brick whole = brick_of(values);
    together.add(whole);
    Brick even_sites = brick_of(values), odd_sites = brick_of(values);
    for (uint16_t& row : even_sites.kept) row = 0x5555;
    for (uint16_t& row : odd_sites.kept) row = 0xaaaa;
    apart.add(even_sites), apart.add(odd_sites);
  }
  ByteWriter a, b;
  together.write(a), apart.write(b);
  EXPECT_EQ(a.release(), b.release());
  EXPECT_EQ(together.range(), apart.range());
}

TEST(QuantizeHistogram, CodesCountAsTheirValues) {
  std::mt19937 random(6);
  for (const ValueType type : {ValueType::u8, ValueType::u16})
    for (const uint32_t most : {255u, largest_code(type) + 0u}) {
      const Quantiser quantiser{type, 0.37, -11, 5};
      SampleHistogram values(quantiser), codes(quantiser);
      for (int b = 0; b < 3; ++b) {
        std::vector<uint32_t> c(1 + random() % brick_sites);
        std::vector<float> v;
        for (uint32_t& code : c) code = static_cast<uint32_t>(random()) % (most + 1);
        for (const uint32_t code : c) v.push_back(relative_value(quantiser, code));
        values.add(brick_of(v));
        codes.add_codes(c);
      }
      codes.add_codes({});
      ByteWriter expected, found;
      values.write(expected), codes.write(found);
      EXPECT_EQ(found.release(), expected.release());
      EXPECT_EQ(codes.count(), values.count());
    }
}

// Samples that are what coefficients add up to lie beyond the codes that there are.
TEST(QuantizeHistogram, WhatIsBeyondCodesCountsAsTheNearest) {
  SampleHistogram h(quantiser_of_source(SourceType::u8, 0));
  h.add(brick_of(std::vector<float>{-3.25F, -1.75F, 0, 128, 255, 257.5F}));
  EXPECT_EQ(h.range(), (Range{-3.25, 257.5}));
  EXPECT_EQ(h.percentile(.5), 0);
  EXPECT_EQ(h.percentile(.66), 128);
  EXPECT_EQ(h.percentile(.9), 255);
}

TEST(QuantizeHistogram, CodesAreExact) {
  const Quantiser q = quantiser_of_range(ValueType::u16, {-2, 5}, 1);
  SampleHistogram h(q);
  std::mt19937 random(2);
  std::vector<uint32_t> codes;
  for (int b = 0; b < 4; ++b) {
    std::vector<float> values;
    for (int i = 0; i < 4096; ++i) {
      codes.push_back(random() % 65536);
      values.push_back(relative_value(q, codes.back()));
    }
    h.add(brick_of(values));
  }
  std::sort(codes.begin(), codes.end());
  for (size_t i = 0; i < codes.size(); i += 97) {
    const double p = static_cast<double>(i + 1) / static_cast<double>(codes.size());
    EXPECT_EQ(h.percentile(p), 1 + static_cast<double>(relative_value(q, codes[i])));
  }
}

TEST(QuantizeHistogram, BinsHoldEverySampleOnce) {
  SampleHistogram h(quantiser_of_source(SourceType::u8, 3));
  std::vector<float> values;
  for (int i = 0; i < 4096; ++i) values.push_back(static_cast<float>(i * i % 200 - 3));
  h.add(brick_of(values));
  const Range range = h.range();
  EXPECT_EQ(range, (Range{0, 196}));
  const auto bins = h.bins(7); // 28 codes each, but for the last, which has its end too
  std::vector<uint64_t> truth(7);
  for (const float v : values)
    ++truth[std::min<size_t>(6, static_cast<size_t>((static_cast<double>(v) + 3) * 7 / 196))];
  EXPECT_EQ(bins, truth);
}

TEST(QuantizeHistogram, MergingIsAdding) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0, 2);
  for (const SourceType type : {SourceType::f32, SourceType::u8}) {
    const Quantiser q = quantiser_of_source(type, 0);
    SampleHistogram whole(q), a(q), b(q), empty(q);
    for (int i = 0; i < 10; ++i) {
      std::vector<float> values(3000);
      for (float& v : values)
        v = type == SourceType::u8 ? static_cast<float>(random() % 256) : normal(random);
      const Brick brick = brick_of(values);
      whole.add(brick);
      (i % 3 ? a : b).add(brick);
    }
    a.merge(empty);
    empty.merge(b);
    empty.merge(a);
    EXPECT_EQ(empty.count(), whole.count());
    EXPECT_EQ(empty.range(), whole.range());
    EXPECT_EQ(empty.bins(256), whole.bins(256));
    for (const double p : {0.02, 0.5, 0.998}) EXPECT_EQ(empty.percentile(p), whole.percentile(p));
  }
}

TEST(QuantizeHistogram, HolesAndAirDoNotCount) {
  SampleHistogram h(quantiser_of_source(SourceType::f32, 10));
  EXPECT_EQ(h.range(), Range{});
  EXPECT_EQ(h.percentile(0.5), 10);
  EXPECT_EQ(h.bins(4), std::vector<uint64_t>(4, 0));
  Brick b = brick_of(std::vector<float>{1, 2, 3});
  b.hole = std::make_unique<BrickMask>();
  (*b.hole)[0] = 4;
  h.add(b);
  EXPECT_EQ(h.count(), 2u);
  EXPECT_EQ(h.range(), (Range{11, 12}));
}

} // namespace
} // namespace bccsplat

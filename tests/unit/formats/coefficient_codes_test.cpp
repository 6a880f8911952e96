// SPDX-License-Identifier: Apache-2.0
// Rounding of coefficients: the units that a chunk gets, how large errors may be and where they go, what is
// kept of air, gaps and holes; and the weights that errors are handed on with.
#include "formats/bcc4/encode/coefficient_codes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "base/error.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/encode/encode_chunk.h"
#include "kernel/autocorrelation.h"
#include "kernel/kernel.h"
#include "tests/support/larger.h"

namespace bccsplat {
namespace {

constexpr int layers = 8;

const NoiseShape& default_shape() {
  static const NoiseShape shape = noise_shape(make_kernel("default"), false);
  return shape;
}

CoefficientCoding coding_of(double step, int most_shift) { return {step, most_shift, default_shape()}; }

using Values = std::function<double(int layer, const Int3& site)>;

// A chunk of D4*, and its bricks.
struct Given {
  ChunkShape shape;
  std::vector<std::shared_ptr<Brick>> bricks;
  [[nodiscard]] CoefficientChunk round(const CoefficientCoding& coding) const {
    std::vector<const Brick*> all;
    for (const auto& b : bricks) all.push_back(b.get());
    return round_coefficients(shape, all, coding);
  }
  [[nodiscard]] float& value(int layer, const Int3& s) const {
    return bricks[layer]->value[(s[2] * 16 + s[1]) * 16 + s[0]];
  }
};

Given make(const Values& value, const std::array<uint32_t, 4>& dims = {60, 60, 60, 20},
           const Int3& brick = {0, 0, 0}) {
  Given g;
  g.shape = chunk_shape(Lattice4::fit(LatticeKind::d4star, dims), 0, layers, brick);
  for (int m = 0; m < layers; ++m) {
    g.bricks.push_back(g.shape.empty(m) ? nullptr : std::make_shared<Brick>());
    const Int3 n = g.shape.box[m];
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) g.value(m, {x, y, z}) = static_cast<float>(value(m, {x, y, z}));
  }
  return g;
}

Values noise(double sigma) {
  const auto random = std::make_shared<std::mt19937>(1);
  return [=](int, const Int3&) { return std::normal_distribution<double>(0, sigma)(*random); };
}

// What a reader makes of a chunk: it is coded and decoded on the way.
Given read_back(const Given& given, const CoefficientChunk& chunk, const CoefficientCoding& coding) {
  const EncodedChunk coded = encode_chunk(chunk.sites, i32_codes, 6);
  ChunkScratch scratch;
  const ChunkData data = decode_chunk(given.shape, i32_codes, coded.entry, coded.bytes, scratch);
  Given back = make([](int, const Int3&) { return 0; });
  size_t next = 0;
  for (size_t m = 0; m < data.kept.size(); ++m)
    for (size_t i = 0; i < brick_sites; ++i) {
      if (!(data.kept[m][i / 16] >> (i % 16) & 1)) continue;
      uint32_t code = 0;
      const size_t width = data.coded.bytes();
      std::memcpy(&code, data.codes.data() + width * next++, width);
      back.bricks[m]->value[i] = static_cast<float>(coefficient_of(data.coded.ordered(code), coding));
    }
  return back;
}

TEST(CoefficientCodes, ConstantsAndSlowRampsKeepTheFilesStep) {
  EXPECT_EQ(make([](int, const Int3&) { return 101; }).round(coding_of(1, 3)).shift, 0);
  const Given ramp = make([](int m, const Int3& s) { return 100 + .1 * (s[0] + s[1]) + .02 * m; });
  const CoefficientChunk chunk = ramp.round(coding_of(1, 3));
  EXPECT_EQ(chunk.shift, 0);
  const Given back = read_back(ramp, chunk, coding_of(1, 3));
  for (size_t i = 0; i < brick_sites; ++i)
    EXPECT_NEAR(back.bricks[5]->value[i], ramp.bricks[5]->value[i], .5001) << i;
}

TEST(CoefficientCodes, WhatCannotBePredictedGetsTheCoarsestStep) {
  for (const int most : {0, 1, 2, 3}) EXPECT_EQ(make(noise(20)).round(coding_of(1, most)).shift, most);
  // A doubling has to save something.
  EXPECT_EQ(make(noise(1)).round(coding_of(1, 3)).shift, 1);
}

TEST(CoefficientCodes, TheContainerFindsTheUnits) {
  for (const int most : {0, 1, 2}) {
    const CoefficientChunk chunk = make(noise(20)).round(coding_of(1, most));
    EXPECT_EQ(encode_chunk(chunk.sites, i32_codes, 6).entry.shift(), most);
  }
}

TEST(CoefficientCodes, HugeValuesKeepTheirSign) {
  for (const int most : {0, 1, 2}) {
    const Given given = make([](int, const Int3& s) { return (s[0] % 2 ? -1 : 1) * (1e9 + 4e6 * s[1]); });
    const CoefficientChunk chunk = given.round(coding_of(1, most));
    for (size_t i = 0; i < 16; ++i)
      EXPECT_EQ(static_cast<int32_t>(chunk.sites.codes[i] - i32_air) < 0, i % 2 == 1) << most << " " << i;
  }
}

// Each value comes back within half a step and what neighbours gave: the sum of the weights.
TEST(CoefficientCodes, ErrorsAreBounded) {
  const CoefficientCoding coding = coding_of(.5, 2);
  double most = 1;
  for (const Weights& w : coding.shape.weights) {
    double sum = 1;
    for (const int16_t v : w) sum += std::abs(v) / 4096.0;
    most = larger(most, sum);
  }
  const Given given = make(noise(20));
  const CoefficientChunk chunk = given.round(coding);
  ASSERT_EQ(chunk.shift, 2);
  const Given back = read_back(given, chunk, coding);
  double squares = 0;
  for (int m = 0; m < layers; ++m)
    for (size_t i = 0; i < brick_sites; ++i) {
      const double e = static_cast<double>(back.bricks[m]->value[i]) - given.bricks[m]->value[i];
      EXPECT_LE(std::fabs(e), most) << m << " " << i;
      squares += e * e;
    }
  EXPECT_GT(squares, 0);
}

// The mean square of the errors under the kernel, from pairs of sites that are not too far from each other.
double field_error(const Given& given, const Given& back) {
  const Kernel kernel = make_kernel("default");
  const auto error = [&](int m, const Int3& s) {
    return static_cast<double>(back.value(m, s)) - given.value(m, s);
  };
  double sum = 0;
  for (int m = 3; m < 5; ++m)
    for (int dm = -3; dm <= 3; ++dm)
      for (int d = 0; d < 343; ++d) {
        const Int3 by{d % 7 - 3, d / 7 % 7 - 3, d / 49 - 3};
        const int shift = dm % 2 == 0 ? 0 : m % 2 == 0 ? 1 : -1; // of coset 1 in planes
        double squares = 0;
        for (const int v : by) squares += .5 * (2 * v + shift) * (2 * v + shift);
        const double overlap = autocorrelation(kernel.space, std::sqrt(squares)) *
                               autocorrelation(kernel.time, dm * std::sqrt(.5));
        for (int z = 4; z < 12 && overlap != 0; ++z)
          for (int y = 4; y < 12; ++y)
            for (int x = 4; x < 12; ++x)
              sum += overlap * error(m, {x, y, z}) * error(m + dm, {x + by[0], y + by[1], z + by[2]});
      }
  return sum;
}

TEST(CoefficientCodes, ErrorsGoWhereTheKernelDoesNotPassThem) {
  const Given given = make(noise(20));
  CoefficientCoding coding = coding_of(1, 0);
  const double plain = field_error(given, read_back(given, given.round(coding), coding));
  coding.shape_all = true;
  const double shaped = field_error(given, read_back(given, given.round(coding), coding));
  EXPECT_LT(shaped, .6 * plain); // 3 dB where all layers around are there
  EXPECT_GT(shaped, .3 * plain);
}

// Without it a constant between two steps would come back off everywhere.
TEST(CoefficientCodes, AConstantIsRightInTheMean) {
  const Given given = make([](int, const Int3&) { return 101; });
  CoefficientCoding coding = coding_of(4, 0);
  const auto mean = [&] {
    const Given back = read_back(given, given.round(coding), coding);
    double sum = 0;
    for (const auto& b : back.bricks)
      for (const float v : b->value) sum += static_cast<double>(v) / (layers * brick_sites);
    return sum;
  };
  EXPECT_NEAR(mean(), 100, 1e-6);
  coding.shape_all = true;
  EXPECT_NEAR(mean(), 101, .2);
}

TEST(CoefficientCodes, AirIsDroppedAndShortGapsAreKept) {
  // Along x: kept at 0, 5 (a gap of 4), 11 (a gap of 5); nothing else.
  const Given given = make([](int m, const Int3& s) {
    const bool there = m == 2 && s[1] == 3 && s[2] == 4 && (s[0] == 0 || s[0] == 5 || s[0] == 11);
    return there ? 50 : m == 4 ? .3 : 0;
  });
  const CoefficientChunk chunk = given.round(coding_of(1, 0));
  EXPECT_EQ(chunk.sites.kept[2][4 * 16 + 3], 0b1000'0011'1111);
  EXPECT_EQ(chunk.sites.kept[4], BrickMask{});
  std::vector<uint32_t> steps = chunk.sites.codes;
  for (uint32_t& s : steps) s -= i32_air;
  EXPECT_EQ(steps, (std::vector<uint32_t>{50, 0, 0, 0, 0, 50, 50}));
}

TEST(CoefficientCodes, HolesStay) {
  const Given given = make([](int, const Int3& s) { return s[0] < 4 ? 7 : 0; });
  given.bricks[1]->hole = std::make_unique<BrickMask>();
  (*given.bricks[1]->hole)[0] = 0b1000'0000'0000'0001;
  const CoefficientChunk chunk = given.round(coding_of(1, 0));
  EXPECT_EQ(chunk.sites.holes(), 2u);
  EXPECT_EQ(chunk.sites.kept[1][0], 0b1000'0000'0000'1111);
  EXPECT_EQ(chunk.sites.hole[1][0], 0b1000'0000'0000'0001);
}

// Bricks at the end of the lattice, and chunks in which a coset has none.
TEST(CoefficientCodes, PartialBricks) {
  for (const Int3& brick : {Int3{2, 2, 2}, Int3{1, 0, 2}}) {
    const Given given =
        make([](int m, const Int3& s) { return 40 + s[0] * s[1] + 3 * m; }, {65, 67, 65, 20}, brick);
    const CoefficientCoding coding = coding_of(1, 2);
    const CoefficientChunk chunk = given.round(coding);
    EXPECT_EQ(chunk.sites.codes.size(), given.shape.sites());
    for (size_t m = 0; m < layers; ++m) {
      const bool none = given.shape.box[m][0] == 0;
      EXPECT_EQ(chunk.sites.kept[m] == BrickMask{}, none) << m;
    }
    EXPECT_EQ(encode_chunk(chunk.sites, i32_codes, 6).entry.kept, given.shape.sites());
  }
}

TEST(NoiseShape, StaticLatticesHaveNoLayersBefore) {
  const NoiseShape shape = noise_shape(make_kernel("default"), true);
  EXPECT_NE(shape.weights[1], Weights{});
  EXPECT_EQ(shape.weights[2], Weights{});
  EXPECT_EQ(shape.weights[3], Weights{});
}

// An error is taken back where there are sites that come later, whatever those have had before.
TEST(NoiseShape, WeightsHangOnTheLayersBehind) {
  const auto part = [](const Weights& w, size_t first, size_t count) {
    return std::vector<int16_t>(w.begin() + first, w.begin() + first + count);
  };
  const ClassWeights& all = default_shape().weights;
  const ChunkShape moving = make([](int, const Int3&) { return 0; }).shape;
  const auto taps = [&](int m) { return taps_of_layer(default_shape(), moving, m); };
  EXPECT_EQ(part(taps(0), 0, own_taps), part(all[3], 0, own_taps));
  EXPECT_EQ(part(taps(0), own_taps, max_taps - own_taps), std::vector<int16_t>(max_taps - own_taps));
  EXPECT_EQ(taps(4), all[3]);
  EXPECT_EQ(part(taps(6), 0, own_taps), part(all[1], 0, own_taps));
  EXPECT_EQ(part(taps(7), 0, own_taps), part(all[0], 0, own_taps));
  EXPECT_EQ(part(taps(7), own_taps, cross_taps), part(all[1], own_taps, cross_taps));
  EXPECT_EQ(part(taps(7), own_taps + cross_taps, previous_taps),
            part(all[3], own_taps + cross_taps, previous_taps));

  const NoiseShape still = noise_shape(make_kernel("default"), true);
  const ChunkShape two = chunk_shape(Lattice4::fit(LatticeKind::bcc, {60, 60, 60, 1}), 0, 2, {0, 0, 0});
  EXPECT_EQ(part(taps_of_layer(still, two, 0), 0, own_taps), part(still.weights[1], 0, own_taps));
  EXPECT_EQ(part(taps_of_layer(still, two, 1), 0, own_taps), part(still.weights[0], 0, own_taps));
  EXPECT_EQ(part(taps_of_layer(still, two, 1), own_taps, cross_taps),
            part(still.weights[1], own_taps, cross_taps));
}

// Files are the same on every machine: the weights must not depend on a libm.
TEST(NoiseShape, IsAsItWas) {
  const Weights& w = default_shape().weights[3];
  std::array<int, 4> sums{};
  for (size_t i = 0; i < max_taps; ++i)
    sums[i < 3 ? 0 : i < own_taps ? 1 : i < own_taps + cross_taps ? 2 : 3] += w[i];
  EXPECT_EQ(sums, (std::array<int, 4>{-2060, 1908, -5724, 2938}));
}

TEST(CoefficientCodes, MoreStepsThanThereAreAreRefused) {
  const Given g = make(noise(1));
  g.value(2, {3, 4, 5}) = -2e6F;
  EXPECT_FALSE(g.round(coding_of(.002, 0)).sites.codes.empty()); // 10^9, fewer than 2^30
  try {
    (void)g.round(coding_of(.001, 1));
    ADD_FAILURE() << "2 * 10^9 steps were taken";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::limit_exceeded) << e.message();
  }
}

} // namespace
} // namespace bccsplat

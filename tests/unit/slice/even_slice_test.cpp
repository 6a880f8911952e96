// SPDX-License-Identifier: Apache-2.0
// Slices of uneven axes, resampled evenly: they are the slice they were made of, and pictures of them those
// of the field.
#include "slice/even_slice.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "base/error.h"
#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "slice/hyperslice.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr uint32_t samples_across = 28, levels_of_z = 24;

// As close as 1 to 12 along z, falling along y; x is even.
std::shared_ptr<const UnevenAxes> stretched() {
  std::vector<double> z{0}, y{0};
  for (uint32_t i = 1; i < levels_of_z; ++i) z.push_back(z.back() + std::pow(1.12, i));
  for (uint32_t i = 1; i < samples_across; ++i) y.push_back(y.back() - 1 - 0.4 * std::sin(0.3 * i));
  return std::make_shared<const UnevenAxes>(std::array<std::vector<double>, 3>{std::vector<double>{}, y, z});
}

// The slice of a field that is given at indices.
Slice slice_of(const std::function<double(const Vec3&)>& f, const std::array<uint32_t, 3>& dims,
               LatticeKind kind = LatticeKind::bcc) {
  return make_slice(
      dims,
      [&](double x, double y, double z) {
        return f({x, y, z});
      },
      "default", {}, 0, kind);
}

std::array<uint32_t, 3> dims_of() { return {samples_across, samples_across, levels_of_z}; }

// SNR of the even slice against the slice itself, at random points.
double likeness(const Slice& slice, const Slice& even, const UnevenAxes& axes) {
  std::mt19937 random(3);
  std::vector<Vec3> at_even, at_index;
  const std::array<uint32_t, 3> dims = dims_of();
  for (int i = 0; i < 4000; ++i) {
    Vec3 index;
    for (size_t a = 0; a < 3; ++a)
      index[a] = std::uniform_real_distribution<double>(0, dims[a] - 1.0)(random);
    at_index.push_back(index), at_even.push_back(axes.even_of(index));
  }
  std::vector<float> expected(at_index.size()), got(at_index.size());
  TestContext context;
  EXPECT_EQ(sample_points(slice, at_index, expected, {}, context.get()).outside, 0u);
  EXPECT_EQ(sample_points(even, at_even, got, {}, context.get()).outside, 0u);
  double signal = 0, error = 0;
  for (size_t i = 0; i < got.size(); ++i)
    signal += expected[i] * expected[i], error += std::pow(static_cast<double>(got[i]) - expected[i], 2);
  return 10 * std::log10(signal / error);
}

TEST(EvenSlice, IsTheSliceItIsMadeOf) {
  const auto axes = stretched();
  TestContext context;
  for (const LatticeKind kind : {LatticeKind::bcc, LatticeKind::cc})
    for (const double frequency : {0.3, 0.8, 1.5}) { // radians per index; 3.1 is the samples' limit
      const Slice slice = slice_of(
          [&](const Vec3& p) {
            return 2 + std::sin(frequency * p[2] + 0.3) * std::cos(0.8 * frequency * p[1]) +
                   std::sin(0.5 * p[0] + frequency * p[2]);
          },
          dims_of(), kind);
      const Slice even = even_slice(slice, axes, context.get());
      const double snr = likeness(slice, even, *axes);
      RecordProperty("snr", std::to_string(snr));
      std::printf("  kind %d, %g per index: %.1f dB, %lld points of %lld\n", static_cast<int>(kind),
                  frequency, snr, static_cast<long long>(even.points()),
                  static_cast<long long>(slice.points()));
      EXPECT_GE(snr, 45) << frequency;
      EXPECT_EQ(even.lacking, 1);
    }
}

TEST(EvenSlice, TellsWhatItLacks) {
  std::vector<double> z{0};
  for (uint32_t i = 1; i < levels_of_z; ++i) z.push_back(z.back() + (i == 5 ? 1e-4 : 1));
  const auto axes =
      std::make_shared<const UnevenAxes>(std::array<std::vector<double>, 3>{std::vector<double>{}, {}, z});
  TestContext context;
  const Slice slice = slice_of([](const Vec3& p) { return 1 + p[0] + 0.1 * p[2]; }, dims_of());
  const Slice even = even_slice(slice, axes, context.get());
  EXPECT_GT(even.lacking, 100);
  EXPECT_LE(even.lattice.last[2], most_refined * slice.lattice.last[2] + 5);
  EXPECT_EQ(even.lattice.last[0], slice.lattice.last[0]);
}

TEST(EvenSlice, IsCoarserWhereMemoryIsShort) {
  const auto axes = stretched();
  TestContext context;
  const Slice slice = slice_of([](const Vec3& p) { return 1 + p[0]; }, dims_of());
  const Slice fine = even_slice(slice, axes, context.get());
  const Context whole = context.get();
  MemoryBudget budget(static_cast<uint64_t>(fine.sites()) * 64); // half of it is for half of the sites
  const Slice coarse = even_slice(slice, axes, Context{whole.tasks, budget, whole.progress});
  EXPECT_LT(coarse.sites(), fine.sites() / 2 + 1);
  EXPECT_GT(coarse.lacking, 1);
}

TEST(EvenSlice, KeepsTheDomainAndTheWorld) {
  const auto axes = stretched();
  TestContext context;
  const Slice slice = slice_of([](const Vec3& p) { return 1 + p[0]; }, dims_of());
  const Slice even = even_slice(slice, axes, context.get());
  EXPECT_EQ(even.slice_to_world, slice.slice_to_world);
  for (size_t a = 0; a < 3; ++a) {
    const auto end = [&](const Slice& s, const Vec3& p) { return s.lattice_to_slice.point(p)[a]; };
    EXPECT_NEAR(end(even, even.domain_begin), end(slice, slice.domain_begin), 1e-9);
    EXPECT_NEAR(end(even, even.domain_end), end(slice, slice.domain_end), 1e-9);
  }
}

TEST(EvenSlice, ABoxIsThatPartOfIt) {
  const auto axes = stretched();
  TestContext context;
  const auto f = [](const Vec3& p) { return 2 + std::sin(0.7 * p[2]) + std::cos(0.5 * p[1] + 0.2 * p[0]); };
  Slice slice = slice_of(f, dims_of());
  const Slice whole = even_slice(slice, axes, context.get());
  const IndexBox box{{3, 5, 2}, {20, 17, 9}};
  cut_to_box(slice, index_box(box, *axes));
  const Slice part = even_slice(slice, axes, context.get());
  std::vector<Vec3> points;
  for (double s = 0; s <= 1; s += 0.01)
    points.push_back({3 + 17 * s, 5 + 12 * std::fabs(std::sin(9 * s)), 2 + 7 * s * s});
  std::vector<float> a(points.size()), b(points.size());
  EXPECT_EQ(sample_points(whole, points, a, {}, context.get()).outside, 0u);
  EXPECT_EQ(sample_points(part, points, b, {}, context.get()).outside, 0u);
  for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 0.03); // each ripples in its distance from 0
  const std::vector<Vec3> beyond{{2.9, 8, 5}, {8, 8, 9.1}};
  std::vector<float> none(beyond.size());
  EXPECT_EQ(sample_points(part, beyond, none, {}, context.get()).outside, beyond.size());
}

TEST(EvenSlice, PicturesAreThoseOfTheField) {
  const auto axes = stretched();
  TestContext context;
  // A field of the world: a soft ball with shells, transparent at the faces, where slices of bare lattices
  // bend.
  const auto field = [](const Vec3& e) {
    const double r = std::hypot((e[0] - 13) / 13, (e[1] - 14) / 13, (e[2] - 11) / 11);
    return std::exp(-3 * r * r) * (0.8 + 0.2 * std::cos(6 * r));
  };
  const Slice slice = slice_of([&](const Vec3& p) { return field(axes->even_of(p)); }, dims_of());
  const Slice even = even_slice(slice, axes, context.get());
  for (const bool perspective : {false, true}) {
    const RenderOptions options;
    Scene scene =
        make_scene(even, ramp_function(0.12, 1, 0.12), fit_camera(even, perspective, 25, 40, 64, 64));
    ImageStorage got(64, 64), truth(64, 64), uneven(64, 64);
    draw(scene, options, got);
    const FieldAt at = [&](const Vec3& p, Vec3* gradient) {
      const Vec3 e = even.lattice_to_slice.point(p);
      if (gradient) {
        Vec3 slope;
        constexpr double h = 1e-5;
        for (size_t a = 0; a < 3; ++a) {
          Vec3 low = e, high = e;
          low[a] -= h, high[a] += h;
          slope[a] = (field(high) - field(low)) / (2 * h);
        }
        *gradient = even.lattice_to_slice.transposed(slope);
      }
      return field(e);
    };
    render_reference(scene, options, at, {0.02}, context.get(), truth.image);
    const double db = compare(got, truth).db();
    scene.slice = &slice; // what a picture is that takes indices for places
    draw(scene, options, uneven);
    const double wrong = compare(uneven, truth).db();
    std::printf("  picture%s: %.1f dB; of the slice as it is %.1f dB\n", perspective ? ", perspective" : "",
                db, wrong);
    EXPECT_GE(db, 45);
    EXPECT_LT(wrong, 35);
  }
}

TEST(EvenSlice, ObliqueAxesOfSliceSpaceAreRefused) {
  const auto axes = stretched();
  TestContext context;
  Slice slice = slice_of([](const Vec3& p) { return p[0]; }, dims_of());
  slice.basis[0] = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};
  EXPECT_THROW((void)even_slice(slice, axes, context.get()), Error);
}

// Hyperplanes of even positions, of a series: every way to cut gives the field at their indices.
TEST(EvenSlice, AnyHyperplaneIsThatOfEvenPositions) {
  std::vector<double> z{0};
  for (int i = 1; i < 16; ++i) z.push_back(z.back() + std::pow(1.1, i));
  const auto axes =
      std::make_shared<const UnevenAxes>(std::array<std::vector<double>, 3>{std::vector<double>{}, {}, z});
  TestContext context;
  const auto field = [](const Vec4& p) {
    return 2 + std::sin(0.4 * p[0] + 0.3 * p[3]) * std::cos(0.35 * p[1]) + std::sin(0.5 * p[2] - 0.2 * p[3]);
  };
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {16, 17, 16, 14});
  const auto samples = sample_field(lattice, field);
  const Coefficients coefficients(samples, 0, make_kernel("default"), 0, 1u << 30);
  HypersliceOptions options;
  options.even = axes;
  for (const Hyperplane& h : {Hyperplane(0, 0, 0, 1, -6.3), Hyperplane(0, 0, 1, 0, -4.2),
                              Hyperplane(1, 0, 0, 0, -7.4), Hyperplane(0.2, 0.1, 0.6, 0.7, -9)}) {
    const Slice slice = hyperslice(coefficients, h, options, {}, context.get());
    ASSERT_FALSE(slice.empty());
    std::mt19937 random(9);
    double signal = 0, error = 0;
    size_t count = 0;
    for (int tries = 0; tries < 4000; ++tries) {
      Vec3 uvw;
      for (size_t k = 0; k < 3; ++k) {
        const double low = slice.lattice_to_slice.point(slice.domain_begin)[k],
                     high = slice.lattice_to_slice.point(slice.domain_end)[k];
        uvw[k] = std::uniform_real_distribution<double>(low, high)(random);
      }
      Vec4 even = slice.origin;
      for (size_t k = 0; k < 3; ++k)
        for (size_t a = 0; a < 4; ++a) even[a] += uvw[k] * slice.basis[k][a];
      EXPECT_NEAR(height(h, even), 0, 1e-9);
      float value = 0;
      sample_points(slice, std::span(&uvw, 1), std::span(&value, 1), {}, context.get());
      if (std::isnan(value)) continue;
      const Vec3 index = axes->index_of({even[0], even[1], even[2]});
      bool inner = true; // where mirrors at the ends of this bare lattice are out of reach
      for (size_t a = 0; a < 3; ++a)
        inner = inner && index[a] > 3.5 && index[a] < lattice.domain_end(a) - 3.5;
      if (!inner || even[3] < 3.5 || even[3] > 9.5) continue;
      const double truth = field({index[0], index[1], index[2], even[3]});
      signal += truth * truth, error += (value - truth) * (value - truth);
      ++count;
    }
    EXPECT_GT(count, 20u);
    EXPECT_GE(10 * std::log10(signal / error), 45) << h[0] << ' ' << h[1] << ' ' << h[2] << ' ' << h[3];
  }
  options.thickness.length = 2;
  EXPECT_THROW((void)hyperslice(coefficients, Hyperplane(0, 0, 1, 0, -4.2), options, {}, context.get()),
               Error);
  EXPECT_THROW((void)hyperslice(coefficients, Hyperplane(0.2, 0.1, 0.6, 0.7, -9), options, {}, context.get()),
               Error);
  EXPECT_NO_THROW((void)hyperslice(coefficients, Hyperplane(1, 0, 0, 0, -7.4), options, {}, context.get()));
}

} // namespace
} // namespace bccsplat

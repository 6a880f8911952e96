// SPDX-License-Identifier: Apache-2.0
// Hyperplanes on the verge of something else.
#include "tests/stability/stability.h"

namespace host {
namespace {

const Series slow{
    .nx = 20, .ny = 18, .nz = 16, .nt = 14, .field = [](double x, double y, double z, double t) {
      return 10 + 3 * std::cos(std::numbers::pi * x / 19) * std::cos(std::numbers::pi * t / 13) +
             2 * std::cos(std::numbers::pi * y / 17) * std::cos(std::numbers::pi * z / 15);
    }};

TEST(StabilityHyperplane, ATiltOfATrillionthIsNoTilt) {
  const Device device = make_device();
  const Stored stored = store(device, slow);
  for (int axis = 0; axis < 4; ++axis) {
    double exact[4] = {}, tilted[4];
    exact[axis] = 1;
    std::copy_n(exact, 4, tilted);
    tilted[(axis + 1) % 4] = 1e-12, tilted[(axis + 2) % 4] = -1e-12;
    const double at = 6.25;
    const Slice a = cut(stored.volume, exact[0], exact[1], exact[2], exact[3], -at);
    const Slice b = cut(stored.volume, tilted[0], tilted[1], tilted[2], tilted[3], -at);
    Bound(std::string("tilt of 1e-12 against axis ") + "xyzt"[axis], 0)
        .add(largest_difference(grid_of(a), grid_of(b)));
  }
}

TEST(StabilityHyperplane, PlanesThroughSitesAndBetweenThemAgreeWithTheField) {
  const Device device = make_device();
  const Stored stored = store(device, slow);
  const double half = 1 / std::numbers::sqrt2; // planes of sites stand this far apart
  Bound bound("planes through sites and between them, values 5 to 15", 0.06);
  for (const double at : {0.0, 5 * half, 6.0, 7 * half, 7.123}) {
    const Slice slice = cut(stored.volume, 1, 0, 0, 0, -at);
    auto info = sized<bccsplat_slice_info>();
    ASSERT_OK(bccsplat_slice_get_info(slice.get(), &info));
    for (double v = 1; v < 12; v += 1.7) {
      const double uvw[] = {info.extent[0][0] + v, info.extent[1][0] + 0.5 * v, info.extent[2][0] + 0.9 * v};
      double p[4];
      for (int i = 0; i < 4; ++i)
        p[i] = info.origin[i] + uvw[0] * info.basis[0][i] + uvw[1] * info.basis[1][i] +
               uvw[2] * info.basis[2][i];
      float got = 0;
      ASSERT_OK(bccsplat_slice_evaluate(slice.get(), 1, uvw, &got, nullptr));
      bound.add(got - slow.field(p[0], p[1], p[2], p[3]));
    }
  }
}

TEST(StabilityHyperplane, OutsideIsEmptyAndAZeroNormalAnError) {
  const Device device = make_device();
  const Stored stored = store(device, slow);
  const Slice outside = cut(stored.volume, 1, 0, 0, 0, 5); // x = -5
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(outside.get(), &info));
  EXPECT_EQ(info.points, 0u);
  for (const float v : picture(device, outside, {.ramp = {0, 1, 1, 1}})) ASSERT_EQ(v, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN(), huge = std::numeric_limits<double>::infinity();
  for (const auto& n :
       {std::array{0.0, 0.0, 0.0, 0.0}, std::array{nan, 0.0, 0.0, 1.0}, std::array{1.0, huge, 0.0, 0.0}}) {
    auto h = sized<bccsplat_hyperplane>();
    h.a = n[0], h.b = n[1], h.c = n[2], h.d = n[3], h.e = -3;
    bccsplat_slice* slice = nullptr;
    EXPECT_EQ(bccsplat_slice_create(stored.volume.get(), &h, nullptr, &slice),
              BCCSPLAT_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(slice, nullptr);
  }
}

TEST(StabilityHyperplane, TheLengthOfTheNormalDoesNotMatter) {
  const Device device = make_device();
  const Stored stored = store(device, slow);
  const std::vector<float> unit = grid_of(cut(stored.volume, 0.6, 0.2, -0.3, 0.7, -8));
  for (const double factor : {1e-200, 1e-9, 1e9, 1e200}) {
    const Slice slice =
        cut(stored.volume, 0.6 * factor, 0.2 * factor, -0.3 * factor, 0.7 * factor, -8 * factor);
    const std::vector<float> got = grid_of(slice);
    ASSERT_EQ(got.size(), unit.size()) << factor;
    Bound bound("normal times " + shown(factor), 1e-4);
    for (size_t i = 0; i < got.size(); ++i)
      if (std::isfinite(unit[i])) bound.add(static_cast<double>(got[i]) - unit[i]);
  }
}

// A wave that goes on beyond all faces and ends: slices resampled in any direction are about as near to it
// there as inside.
TEST(StabilityHyperplane, FacesAndEndsAreAsExactAsTheInside) {
  const Device device = make_device();
  const auto wave = [](double x, double y, double z, double t) {
    return 0.5 + 0.5 * std::sin(0.6 * x + 0.4 * y + 0.5 * z + 0.5 * t);
  };
  const Series s{.nx = 30, .ny = 28, .nz = 26, .nt = 16, .field = wave};
  auto options = options_of(s);
  options.faces = BCCSPLAT_FACES_PREDICT, options.ends = BCCSPLAT_ENDS_PREDICT;
  const Stored stored = store(device, s, options);
  for (const std::array<double, 5>& p : {std::array{0.0, 0.0, 0.0, 1.0, -7.3},
                                         {1.0, 0.0, 0.0, 0.0, -12.4},
                                         {0.0, 0.2, 1.0, 0.0, -13.0},
                                         {1.0, 1.0, 0.0, 0.0, -30.0},
                                         {1.0, 1.0, 1.0, 1.0, -45.0}}) {
    auto h = sized<bccsplat_hyperplane>();
    h.a = p[0], h.b = p[1], h.c = p[2], h.d = p[3], h.e = p[4];
    auto o = sized<bccsplat_slice_options>();
    o.method = BCCSPLAT_METHOD_RESAMPLED;
    bccsplat_slice* created = nullptr;
    ASSERT_OK(bccsplat_slice_create(stored.volume.get(), &h, &o, &created));
    const Slice slice(created);
    auto info = sized<bccsplat_slice_info>();
    ASSERT_OK(bccsplat_slice_get_info(slice.get(), &info));
    const std::vector<float> values = grid_of(slice);
    const std::array<double, 4> last{s.nx - 1.0, s.ny - 1.0, s.nz - 1.0, s.nt - 1.0};
    double inside = 0, near = 0;
    size_t seen = 0;
    for (size_t n = 0; n < values.size(); ++n) {
      const std::array<uint64_t, 3> at{n % info.dims[0], n / info.dims[0] % info.dims[1],
                                       n / info.dims[0] / info.dims[1]};
      std::array<double, 4> q;
      double beyond = std::numeric_limits<double>::infinity(); // to the nearest face or end
      for (size_t c = 0; c < 4; ++c) {
        q[c] = info.origin[c];
        for (size_t k = 0; k < 3; ++k)
          q[c] += (info.extent[k][0] + static_cast<double>(at[k])) * info.basis[k][c];
        beyond = std::min({beyond, q[c], last[c] - q[c]});
      }
      if (beyond < 0 && std::isnan(values[n])) continue; // outside of the domain
      double& worst = beyond < 3 ? near : inside;
      worst = larger(worst, std::fabs(values[n] - wave(q[0], q[1], q[2], q[3])));
      ++seen;
    }
    EXPECT_GT(seen, 1000u);
    EXPECT_GT(inside, 0);
    EXPECT_LT(near, 0.016) << p[0] << ' ' << p[1] << ' ' << p[2] << ' ' << p[3];
    EXPECT_LT(near, 4 * inside + 0.002) << p[0] << ' ' << p[1] << ' ' << p[2] << ' ' << p[3];
  }
}

// A bound that the lattice keeps by itself holds for slices across x, y and z as well, which are other
// fields.
TEST(StabilityHyperplane, ABoundThatNeedsNoCorrectionsHoldsAcrossEveryAxis) {
  const Device device = make_device();
  const Series s{.nx = 20, .ny = 18, .nz = 16, .nt = 14, .field = [](double x, double y, double z, double t) {
                   return 10 + 3 * std::cos(1.1 * x + 0.4 * t) + 2 * std::cos(0.8 * y - 0.5 * z);
                 }};
  auto options = options_of(s);
  options.abs_error = 5; // more than the lattice errs by
  const auto numbers = [](const Stored& stored) {
    auto info = sized<bccsplat_channel_info>();
    EXPECT_OK(bccsplat_volume_get_channel_info(stored.volume.get(), 0, &info));
    return info;
  };
  options.abs_error = 1.01 * numbers(store(device, s, options)).max_abs;
  const Stored stored = store(device, s, options);
  ASSERT_GT(options.abs_error, 0);
  ASSERT_EQ(numbers(stored).corrections, 0u);
  Bound bound("slices of a bounded file, of 33/32 of the bound", 1);
  for (const bccsplat_method method : {BCCSPLAT_METHOD_MERGED, BCCSPLAT_METHOD_RESAMPLED})
    for (int n = 0; n < 6; ++n) {
      const int axis = n % 3;
      auto h = sized<bccsplat_hyperplane>();
      (axis == 0 ? h.a : axis == 1 ? h.b : h.c) = 1;
      h.e = n < 3 ? 0 : -7;
      auto o = sized<bccsplat_slice_options>();
      o.method = method;
      bccsplat_slice* made = nullptr;
      ASSERT_OK(bccsplat_slice_create(stored.volume.get(), &h, &o, &made));
      const Slice slice(made);
      auto info = sized<bccsplat_slice_info>();
      ASSERT_OK(bccsplat_slice_get_info(made, &info));
      const std::vector<float> got = grid_of(slice);
      for (size_t i = 0; i < got.size(); ++i) {
        const size_t at[] = {i % info.dims[0], i / info.dims[0] % info.dims[1],
                             i / info.dims[0] / info.dims[1]};
        double p[4];
        for (int a = 0; a < 4; ++a) {
          p[a] = info.origin[a];
          for (int k = 0; k < 3; ++k)
            p[a] += (info.extent[k][0] + static_cast<double>(at[k])) * info.basis[k][a];
        }
        bound.add((got[i] - s.field(p[0], p[1], p[2], p[3])) / options.abs_error / (33.0 / 32 + 1e-4));
      }
    }
}

} // namespace
} // namespace host

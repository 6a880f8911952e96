// SPDX-License-Identifier: Apache-2.0
// Laws of the streaming fit: what a series of frames becomes on the lattice.
#include <gtest/gtest.h>

#include "fit/axis/near_source.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

constexpr LatticeKind kinds[] = {LatticeKind::d4star, LatticeKind::cc};

TEST(FitSeries, EqualsTheWholeArrayReference) {
  const std::array<uint32_t, 4> shapes[] = {{11, 7, 9, 12}, {24, 5, 3, 6}, {2, 3, 40, 5},
                                            {37, 1, 1, 4},  {5, 6, 7, 1},  {1, 1, 1, 9}};
  for (const auto& dims : shapes)
    for (const LatticeKind kind : kinds) {
      const Series s = noise(dims, 7);
      const Fitted f = run_fit(options_for(s, kind), s);
      EXPECT_LT(worst_difference(f, reference_layers(f.report.lattice, s)), 2e-6)
          << dims[0] << "x" << dims[1] << "x" << dims[2] << "x" << dims[3] << " kind " << int(kind);
    }
}

TEST(FitSeries, EqualsTheReferenceOnCoarserAndFinerLattices) {
  const Series s = noise({19, 14, 10, 11}, 8);
  for (const auto& [scale, time_scale] : {std::pair{1.3, 1.0}, {2.0, 1.7}, {3.1, 2.5}, {0.6, 0.8}})
    for (const LatticeKind kind : kinds) {
      FitOptions o = options_for(s, kind);
      o.scales = {scale, scale, scale, time_scale};
      const Fitted f = run_fit(o, s);
      EXPECT_LT(worst_difference(f, reference_layers(f.report.lattice, s)), 2e-6)
          << scale << " " << time_scale;
    }
}

TEST(FitSeries, ConstantStaysConstantToTheLastBit) {
  for (const float value : {1.0f, -0.1f, 1e-30f, 1e30f, 273.15f})
    for (const uint32_t frames : {1u, 2u, 7u}) {
      const Series s({20, 9, 33, frames}, [&](double, double, double, double) { return value; });
      const Fitted f = run_fit(options_for(s), s);
      for (const BrickLayer& layer : f.layers)
        for (const float v : layer_to_dense(layer)) ASSERT_EQ(v, value);
    }
}

TEST(FitSeries, AirIsWhatValuesAreRelativeTo) {
  const Series s = noise({12, 13, 8, 6}, 9);
  Series shifted = s;
  for (float& v : shifted.values) v += 4; // exact to 2^-22
  FitOptions o = options_for(s);
  const Fitted plain = run_fit(o, s);
  o.channels[0].quantiser = quantiser_of_source(SourceType::f32, 4);
  const Fitted f = run_fit(o, shifted);
  EXPECT_LT(worst_difference(f, reference_layers(f.report.lattice, shifted, 4)), 2e-6);
  EXPECT_FLOAT_EQ(static_cast<float>(f.report.channels[0].source_range.low),
                  static_cast<float>(plain.report.channels[0].source_range.low + 4));
}

TEST(FitSeries, IsLinear) {
  const Series a = noise({17, 18, 9, 8}, 1), b = noise({17, 18, 9, 8}, 2);
  Series sum = a;
  for (size_t i = 0; i < sum.values.size(); ++i) sum.values[i] = 2 * a.values[i] - 0.5f * b.values[i];
  const Fitted fa = run_fit(options_for(a), a), fb = run_fit(options_for(b), b),
               fs = run_fit(options_for(sum), sum);
  for (int32_t m = 0; m < fs.report.lattice.layers(); ++m) {
    const auto va = fa.dense(m), vb = fb.dense(m), vs = fs.dense(m);
    for (size_t i = 0; i < vs.size(); ++i) ASSERT_NEAR(vs[i], 2 * va[i] - 0.5f * vb[i], 1e-5);
  }
}

TEST(FitSeries, OffsetCostsNoPrecision) {
  // A signal of amplitude 0.5 on 1e6 is known to 1/32; the fit adds little to that.
  const auto wave = [](double x, double y, double z, double t) {
    return 0.5 * std::sin(0.4 * x + 0.3 * y - 0.2 * z + 0.3 * t);
  };
  const Series s({32, 24, 24, 12},
                 [&](double x, double y, double z, double t) { return 1e6 + wave(x, y, z, t); });
  const Fitted f = run_fit(options_for(s), s);
  const auto reference = reference_layers(f.report.lattice, s);
  // Rounding (1/32) of each frame on the sites, as weighted in time (1.6 in absolute sum), and of the result.
  EXPECT_LT(worst_difference(f, reference), (1.6 + 1) / 32);
}

TEST(FitSeries, SitesOnSamplesTakeThem) {
  // Layer 0, coset 0: the corner sites lie on the corner samples, along edges as well.
  const Series s = noise({10, 15, 12, 9}, 3);
  const Fitted f = run_fit(options_for(s), s);
  const Lattice4& l = f.report.lattice;
  for (const int x : {0, 1})
    for (const int y : {0, 1})
      for (const int z : {0, 1}) {
        const int end[3] = {x * l.space.last[0], y * l.space.last[1], z * l.space.last[2]};
        if (end[0] % 2 || end[1] % 2 || end[2] % 2) continue;
        EXPECT_EQ(f.layers[0].value(end[0] / 2, end[1] / 2, end[2] / 2), s.at(x * 9, y * 14, z * 11, 0));
      }
}

TEST(FitSeries, CartesianLatticeKeepsIntegersExactly) {
  std::mt19937 random(5);
  std::vector<uint16_t> values(9 * 20 * 5 * 7);
  for (uint16_t& v : values) v = static_cast<uint16_t>(random());
  FitOptions o;
  o.lattice = LatticeKind::cc;
  o.dims = {9, 20, 5, 7};
  o.channels[0].quantiser = quantiser_of_source(SourceType::u16, 0);
  const Fitted f = run_fit(
      o,
      [&](uint32_t t) {
        FrameBox b;
        b.type = SourceType::u16;
        b.data = values.data() + t * 900;
        b.dims = {9, 20, 5};
        return std::vector{b};
      },
      7);
  ASSERT_EQ(f.layers.size(), 7u);
  uint64_t nonzero = 0;
  for (int32_t t = 0; t < 7; ++t) {
    const auto dense = f.dense(t);
    for (size_t i = 0; i < 900; ++i) {
      ASSERT_EQ(dense[i], static_cast<float>(values[static_cast<size_t>(t) * 900 + i]));
      nonzero += dense[i] != 0;
    }
  }
  EXPECT_EQ(f.report.channels[0].sites_kept, nonzero);
  EXPECT_EQ(f.report.channels[0].cc_relevant, nonzero);
  EXPECT_EQ(f.report.channels[0].clamped, 0u);
}

TEST(FitSeries, UnknownNumberOfFramesChangesNothing) {
  for (const LatticeKind kind : kinds)
    for (uint32_t frames = 1; frames <= 20; ++frames) {
      const Series s = noise({6, 7, 5, frames}, frames);
      FitOptions o = options_for(s, kind);
      const Fitted known = run_fit(o, s);
      o.dims[3] = 0;
      const Fitted unknown = run_fit(o, s);
      EXPECT_TRUE(identical(known, unknown)) << frames;
      EXPECT_EQ(known.layers.size(), static_cast<size_t>(known.report.lattice.layers()));
      EXPECT_EQ(unknown.report.lattice.is_static(), frames == 1);
    }
}

TEST(FitSeries, ThreadsChangeNothing) {
  const Series s = noise({50, 41, 38, 10}, 4);
  FitOptions o = options_for(s);
  o.channels[0].threshold = 0.2f;
  const Fitted one = run_fit(o, s, 1);
  for (const int threads : {2, 3, 8}) {
    const Fitted many = run_fit(o, s, threads);
    EXPECT_TRUE(identical(one, many));
    EXPECT_EQ(one.report.channels[0].sites_kept, many.report.channels[0].sites_kept);
    EXPECT_EQ(one.report.channels[0].samples.bins(256), many.report.channels[0].samples.bins(256));
  }
}

// A frame in blocks of `edge`; those that are all air left out.
std::vector<FrameBox> in_boxes(const Series& s, uint32_t t, int64_t edge) {
  std::vector<FrameBox> boxes;
  const FrameBox whole = s.box(t);
  for (int64_t z = 0; z < s.dims[2]; z += edge)
    for (int64_t y = 0; y < s.dims[1]; y += edge)
      for (int64_t x = 0; x < s.dims[0]; x += edge) {
        FrameBox b;
        b.begin = {x, y, z};
        bool any = false;
        for (size_t a = 0; a < 3; ++a) b.dims[a] = std::min(edge, s.dims[a] - b.begin[a]);
        for (int64_t k = z; k < z + b.dims[2]; ++k)
          for (int64_t j = y; j < y + b.dims[1]; ++j)
            for (int64_t i = x; i < x + b.dims[0]; ++i) any = any || s.at(i, j, k, t) != 0;
        if (!any) continue;
        b.stride = {4, 4 * int64_t{s.dims[0]}, 4 * int64_t{s.dims[0]} * s.dims[1]};
        b.data = static_cast<const float*>(whole.data) + ((z * s.dims[1] + y) * s.dims[0] + x);
        boxes.push_back(b);
      }
  return boxes;
}

TEST(FitSeries, BoxesEqualTheDenseFrame) {
  // A ball of values around 2 that moves through air, so that boxes are left out and differences are taken
  // (pivots).
  const Series s({45, 40, 52, 7}, [](double x, double y, double z, double t) {
    const double r = std::hypot(x - 20 - t, y - 18, z - 25);
    return r < 14 ? 2 + 0.3 * std::sin(x + 0.7 * y - 0.4 * z + t) : 0;
  });
  const FitOptions o = options_for(s);
  const Fitted dense = run_fit(o, s);
  for (const int64_t edge : {3, 8, 21, 64}) {
    const Fitted boxes = run_fit(
        o, [&](uint32_t t) { return in_boxes(s, t, edge); }, s.dims[3]);
    EXPECT_TRUE(identical(dense, boxes)) << edge;
    EXPECT_EQ(dense.report.channels[0].cc_relevant, boxes.report.channels[0].cc_relevant);
    EXPECT_EQ(dense.report.channels[0].source_range, boxes.report.channels[0].source_range);
    EXPECT_EQ(dense.report.channels[0].frames, boxes.report.channels[0].frames);
  }
}

// Whether a source sample around a place is not air in a frame that the filter in time takes.
bool is_near_source(const Series& s, const Lattice4& l, const Vec3& p, double frame) {
  std::array<std::array<int64_t, 2>, 3> span;
  for (size_t a = 0; a < 3; ++a) {
    const double reach = near_source * std::max(1.0, l.space_step[a] / l.space.plane_distance());
    const double last = s.dims[a] - 1;
    span[a] = {static_cast<int64_t>(std::clamp(std::ceil(p[a] - reach), 0.0, last)),
               static_cast<int64_t>(std::clamp(std::floor(p[a] + reach), 0.0, last))};
  }
  const double widening = l.time_step / l.layer_distance();
  const bool is_frame =
      widening <= 1 && std::fabs(frame - std::nearbyint(frame)) < 1e-9; // which is taken alone
  const double in_time = is_frame ? 0.25 : 4 * std::max(1.0, widening);
  for (auto f = static_cast<int64_t>(std::ceil(frame - in_time)); static_cast<double>(f) <= frame + in_time;
       ++f)
    for (int64_t z = span[2][0]; z <= span[2][1]; ++z)
      for (int64_t y = span[1][0]; y <= span[1][1]; ++y)
        for (int64_t x = span[0][0]; x <= span[0][1]; ++x)
          if (s.at(x, y, z, mirror_index(f, s.dims[3])) != 0) return true;
  return false;
}

TEST(FitSeries, RingingNextToAirIsDroppedAndNothingElse) {
  std::mt19937 random(12);
  const Series s({30, 27, 22, 9}, [&](double x, double y, double z, double t) {
    const bool inside = std::hypot(x - 14, y - 13, z - 11) < 5 + t / 3 || random() % 3000 == 0;
    return inside ? 1 + std::sin(x * y + z) : 0;
  });
  FitOptions o = options_for(s);
  const Fitted some = run_fit(o, s);
  o.channels[0].ringing = 0;
  const Fitted all = run_fit(o, s);
  const Lattice4& l = all.report.lattice;
  uint64_t dropped = 0, loud = 0, alone = 0;
  for (int32_t m = 0; m < l.layers(); ++m) {
    const auto full = all.dense(m), kept = some.dense(m);
    const Int3 n = l.space.dims(l.coset(m));
    size_t site = 0;
    for (int32_t k = 0; k < n[2]; ++k)
      for (int32_t j = 0; j < n[1]; ++j)
        for (int32_t i = 0; i < n[0]; ++i, ++site) {
          const Vec3 p = l.site_position(l.coset(m), {i, j, k});
          const bool is_near = is_near_source(s, l, p, l.layer_frame(m));
          if (!is_near && full[site] != 0) ++alone;
          ASSERT_TRUE(is_near || kept[site] == 0.0f);
          if (kept[site] == full[site]) continue;
          ++dropped;
          ASSERT_EQ(kept[site], 0.0f);
          const bool is_loud = std::fabs(full[site]) > 2.0f / 512;
          ASSERT_FALSE(is_near && is_loud);
          loud += is_loud;
          const auto near = [](double v, double end) {
            return static_cast<int64_t>(std::min(std::floor(v + 0.5), end));
          };
          ASSERT_EQ(s.at(near(p[0], 29), near(p[1], 26), near(p[2], 21), near(l.layer_frame(m), 8)), 0.0f);
        }
  }
  EXPECT_EQ(dropped, all.report.channels[0].sites_kept - some.report.channels[0].sites_kept);
  EXPECT_GT(dropped, all.report.channels[0].sites_kept / 3);
  EXPECT_GT(loud, 100u);
  EXPECT_GT(alone, loud);
}

TEST(FitSeries, AllAirGivesNothing) {
  FitOptions o;
  o.dims = {30, 30, 30, 0};
  const Fitted f = run_fit(
      o, [](uint32_t) { return std::vector<FrameBox>{}; }, 9);
  EXPECT_EQ(f.report.channels[0].sites_kept, 0u);
  EXPECT_EQ(f.report.channels[0].cc_relevant, 0u);
  EXPECT_EQ(f.report.channels[0].sites_total, static_cast<uint64_t>(f.report.lattice.sites()));
  for (const BrickLayer& layer : f.layers) EXPECT_EQ(layer.kept_sites(), 0);
}

} // namespace
} // namespace bccsplat::test

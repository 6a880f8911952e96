// SPDX-License-Identifier: Apache-2.0
// Planes outside the source samples: whichever way one looks, a field that its lattice holds beyond the faces
// is as true at a face as anywhere.
#include <gtest/gtest.h>

#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "kernel/cc_kernel.h"
#include "slice/coarsen.h"
#include "slice/extraction.h"
#include "slice/hyperslice.h"
#include "slice/occupancy.h"
#include "slice/time_slice.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::large_cache;
using test::PlaneWaves;
using test::sample_field;
using test::TestContext;

constexpr int32_t margin = 8; // more than kernel and prefilter reach

// Returns points of the domain, each within a sample of some face.
std::vector<Vec4> points_at_faces(const Lattice4& lattice, size_t count) {
  auto points = test::random_points(lattice, count, 11);
  std::mt19937 random(12);
  for (Vec4& p : points) {
    const size_t a = random() % 3;
    const double near = std::uniform_real_distribution<double>(0, 1)(random);
    p[a] = random() & 1 ? lattice.dims[a] - 1.0 - near : near;
  }
  return points;
}

class Margins : public testing::TestWithParam<LatticeKind> {
 protected:
  TestContext context;
  Lattice4 lattice =
      Lattice4::fit(GetParam(), {24, 66, 80, GetParam() == LatticeKind::bcc ? 1u : 24u}, {0.36, 1, 1.2, 1},
                    GetParam() == LatticeKind::bcc ? 0 : 8, {margin, margin, margin});
  PlaneWaves waves{12, 0.35, 3};
  test::Field4 field = test::in_lattice_units(lattice, waves);
  MemorySamples samples = sample_field(lattice, field);
  Kernel kernel = lattice.space.bcc ? make_kernel("default") : make_cc_kernel("default").kernel;
  Coefficients coefficients{samples, 0, kernel, 0, large_cache};

  double snr(std::span<const Vec4> points, std::span<const float> values) const {
    double signal = 0, error = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const double truth = field(points[i]);
      signal += truth * truth, error += std::pow(values[i] - truth, 2);
    }
    return 10 * std::log10(signal / error);
  }
  // Returns the SNR of a slice at points of its hyperplane that lie within a sample of a face.
  double slice_snr(const Slice& slice) {
    std::vector<Vec3> at;
    std::vector<Vec4> points;
    std::mt19937 random(5);
    while (at.size() < 500) {
      Vec3 p;
      for (size_t a = 0; a < 3; ++a)
        p[a] = std::uniform_real_distribution<double>(slice.domain_begin[a], slice.domain_end[a])(random);
      const Vec3 uvw = slice.lattice_to_slice.point(p);
      Vec4 q = slice.origin;
      for (size_t k = 0; k < 3; ++k)
        for (size_t i = 0; i < 4; ++i) q[i] += uvw[k] * slice.basis[k][i];
      bool inside = true, near = false;
      for (size_t i = 0; i < 4; ++i) {
        const double end = lattice.dims[i] - 1.0;
        inside = inside && q[i] >= 0 && q[i] <= end;
        near = near || (i < 3 && std::min(q[i], end - q[i]) < 1);
      }
      if (inside && near) at.push_back(uvw), points.push_back(q);
    }
    std::vector<float> values(at.size());
    EXPECT_EQ(sample_points(slice, at, values, {}, context.get()).outside, 0u);
    return snr(points, values);
  }
};

TEST_P(Margins, AreSeenByEvaluation) {
  const auto points = points_at_faces(lattice, 2000);
  std::vector<float> values(points.size());
  std::vector<std::array<float, 4>> gradients(points.size());
  EXPECT_EQ(evaluate4(coefficients, points, values, gradients, context.get()).outside, 0u);
  EXPECT_GT(snr(points, values), 45);
  const Vec4 outside{-0.01, 5, 5, 0};
  float none = 0;
  EXPECT_EQ(evaluate4(coefficients, {&outside, 1}, {&none, 1}, {}, context.get()).outside, 1u);
  EXPECT_TRUE(std::isnan(none));
}

TEST_P(Margins, AreSeenByTimeSlices) {
  const Slice slice = time_slice(coefficients, lattice.is_static() ? 0 : 11.3, {0, 0}, {}, context.get());
  EXPECT_GT(slice_snr(slice), 45);
  // The domain goes from source sample to source sample.
  const Vec3 begin = slice.lattice_to_slice.point(slice.domain_begin),
             end = slice.lattice_to_slice.point(slice.domain_end);
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(begin[a], 0, 1e-9);
    EXPECT_NEAR(end[a], lattice.dims[a] - 1.0, 1e-9);
  }
  const Slice coarse = coarsen(slice, context.get());
  const Vec3 coarse_begin = coarse.lattice_to_slice.point(coarse.domain_begin);
  for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(coarse_begin[a], 0, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Lattices, Margins,
                         testing::Values(LatticeKind::d4star, LatticeKind::bcc, LatticeKind::cc));

class SeriesMargins : public Margins {};

TEST_P(SeriesMargins, AreSeenByAxisSlices) {
  for (size_t axis = 0; axis < 3; ++axis)
    for (const double at : {0.0, 3.4, lattice.dims[axis] - 1.0}) {
      const Hyperplane h(1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2), 0, -at);
      EXPECT_GT(slice_snr(hyperslice(coefficients, h, {}, {}, context.get())), 40) << axis << ' ' << at;
    }
}

TEST_P(SeriesMargins, AreSeenByObliqueSlices) {
  const Hyperplane h(0.5, -0.3, 0.2, 0.4, -6);
  EXPECT_GT(slice_snr(hyperslice(coefficients, h, {}, {}, context.get())), 36);
}

TEST_P(SeriesMargins, AreInMaximaOfSlabs) {
  // Of a field that does not change in time the maximum is the field.
  const auto still = [moving = field](const Vec4& p) { return moving({p[0], p[1], p[2], 3}) + 9; };
  const MemorySamples frozen = sample_field(lattice, still);
  const Coefficients c(frozen, 0, kernel, 0, large_cache);
  const Slice slab = thick_time_slice(c, 11, {-2, 2}, ThicknessKind::maximum, {}, context.get());
  field = still;
  EXPECT_GT(slice_snr(slab), 45);
}

INSTANTIATE_TEST_SUITE_P(Lattices, SeriesMargins, testing::Values(LatticeKind::d4star, LatticeKind::cc));

TEST(MarginLattice, EndsOnTheSamples) {
  const Lattice4 l = Lattice4::fit(LatticeKind::d4star, {40, 12, 1, 30}, {1, 1, 1, 1}, 0, {2, 0, 0});
  EXPECT_EQ(l.before, (Int3{2, 0, 0}));
  EXPECT_EQ(l.behind, (Int3{2, 0, 0}));
  EXPECT_DOUBLE_EQ(l.plane_position(0, 2), 0);
  EXPECT_DOUBLE_EQ(l.plane_position(0, l.space.last[0] - 2), 39);
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What a picture needs of a volume: the level by the size of its pixels, and the box that its camera sees.
#include "scene/picture_needs.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr std::array<uint32_t, 3> dims{40, 50, 30};

class PictureNeeds : public testing::Test {
 protected:
  static Slice sheared() {
    Slice slice = make_slice(dims, [](double, double, double) { return 1.0; });
    slice.slice_to_world.linear = {Vec3{2, 0.3, 0}, Vec3{0, 1, 0.2}, Vec3{0.1, 0, 1.5}};
    slice.slice_to_world.offset = {5, -7, 11};
    return slice;
  }
  [[nodiscard]] Camera camera(bool perspective, double zoom) const {
    Camera c = fit_camera(slice_, perspective, 25, 40, width, height);
    c.ortho_height /= zoom;
    if (perspective)
      c.fovy_degrees = 2 * std::atan(std::tan(c.fovy_degrees * M_PI / 360) / zoom) * 360 / (2 * M_PI);
    return c;
  }
  // Whether a point of index space lies in the picture, by the matrices that hosts are given.
  static bool in_picture(const Slice& slice, const Camera& c, const Vec3& p) {
    const PictureMatrices m = picture_matrices(resolve_camera(c), width, height);
    const Vec3 world = slice.slice_to_world.point(p);
    std::array<double, 4> out{};
    for (size_t k = 0; k < 4; ++k) {
      out[k] = m.world_to_ndc[12 + k];
      for (size_t r = 0; r < 3; ++r) out[k] += world[r] * m.world_to_ndc[4 * r + k];
    }
    const double u = out[0] / out[3], v = out[1] / out[3];
    return out[3] > 0 && u >= 0 && u <= 1 && v >= 0 && v <= 1;
  }

  static constexpr int width = 96, height = 64;
  const Slice slice_ = sheared();
};

TEST_F(PictureNeeds, TheBoxHoldsWhatIsSeenAndLittleMore) {
  for (const bool perspective : {false, true})
    for (const double zoom : {1.0, 3.0, 12.0}) {
      SCOPED_TRACE(testing::Message() << (perspective ? "perspective " : "orthographic ") << zoom);
      const Camera c = camera(perspective, zoom);
      const auto box = seen_box(slice_, make_sight(c, width, height), width, height);
      ASSERT_TRUE(box);
      Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
      std::mt19937 random(7);
      for (int i = 0; i < 200000; ++i) {
        Vec3 p;
        for (size_t a = 0; a < 3; ++a)
          p[a] = std::uniform_real_distribution<double>(0, dims[a] - 1.0)(random);
        if (!in_picture(slice_, c, p)) continue;
        for (size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
      }
      for (size_t a = 0; a < 3; ++a) {
        EXPECT_LE(box->begin[a], low[a]) << a;
        EXPECT_GE(box->end[a], high[a]) << a;
        EXPECT_GE(box->begin[a], low[a] - 7) << a;
        EXPECT_LE(box->end[a], high[a] + 7) << a;
      }
    }
}

TEST_F(PictureNeeds, NothingIsSeenBesideTheVolume) {
  Camera c = camera(false, 20);
  const WorldCamera w = resolve_camera(c);
  c.position = c.position + 1000 * w.right, c.target = c.target + 1000 * w.right;
  EXPECT_FALSE(seen_box(slice_, make_sight(c, width, height), width, height));
  c = camera(true, 1);
  c.target = 2 * c.position - c.target; // away from it
  EXPECT_FALSE(seen_box(slice_, make_sight(c, width, height), width, height));
}

TEST_F(PictureNeeds, PixelsAreCountedInTheDistancesOfTheLevel) {
  Slice slice = make_slice(dims, [](double, double, double) { return 1.0; });
  const Camera c = fit_camera(slice, false, 0, 0, 64, 64);
  for (const double scale : {1.0, 2.0, 4.0}) {
    const Lattice4 level =
        Lattice4::fit(LatticeKind::bcc, {dims[0], dims[1], dims[2], 1}, {scale, scale, scale, 1});
    const Vec3 unit = level.lattice_unit();
    // The view is along z: columns are x, rows y.
    EXPECT_NEAR(distances_per_pixel(slice, level, make_sight(c, 64, 64), 64, 64),
                c.ortho_height / 64 / std::max(unit[0], unit[1]), 1e-9);
  }
}

TEST_F(PictureNeeds, TheLevelIsTheCoarsestThatIsGoodEnough) {
  RenderOptions normal, draft, fine, maximum, whole;
  draft.quality = Quality::draft, fine.quality = Quality::fine, maximum.mode = RenderMode::maximum;
  whole.disable_skips = skip_fine_detail;
  const std::vector<LevelOption> even{
      {2.2, {}}, {1.1, {{0.0019}}}, {0.34, {{0.0019}}}, {0.21, {{0.0019}}}, {0.2, {{0.0021}}}};
  EXPECT_EQ(enough_level(even, normal), 2);
  EXPECT_EQ(enough_level(even, draft), 3);
  EXPECT_EQ(enough_level(even, fine), 0);
  EXPECT_EQ(enough_level(even, maximum), 0);
  EXPECT_EQ(enough_level(even, whole), 0);
  // A level that errs by more than the quality does, or does so somewhere, or nobody knows by how much.
  const std::vector<LevelOption> sharp{{2.2, {}}, {1.1, {{0.05}}}, {0.55, {{0.05}}}},
      vessel{{2.2, {}}, {1.1, {{0.0002, 0.5}}}, {0.55, {{0.0002, 0.051}}}},
      untold{{2.2, {}}, {1.1, {}}, {0.55, {}}};
  for (const std::vector<LevelOption>& unfit : {sharp, vessel, untold})
    for (const RenderOptions& o : {draft, normal}) EXPECT_EQ(enough_level(unfit, o), 1);
  const std::vector<LevelOption> exact{{2, {}}, {1, {}}}, near{{0.9, {}}, {0.45, {}}};
  EXPECT_EQ(enough_level(exact, normal), 1);
  EXPECT_EQ(enough_level(near, normal), 0);
  EXPECT_EQ(enough_level({even.data(), 1}, normal), 0);
}

} // namespace
} // namespace bccsplat

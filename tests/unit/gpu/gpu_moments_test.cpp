// SPDX-License-Identifier: Apache-2.0
// Moments of a series, merged on the GPU of layers that are sent once: their pictures are those of moments
// that the CPU merges, and what is sent is counted.
#include "field/moment.h"

#include "tests/unit/gpu/both_pictures.h"

namespace bccsplat {
namespace {

using namespace test;

// A cloud that moves through a box.
double moving(const Vec4& p) {
  const double r = std::hypot(p[0] - 10 - p[3], p[1] - 14, p[2] - 12 + 0.3 * p[3]) / 9;
  return std::max(0.0, 1 - r * r) * (1 + 0.3 * std::sin(0.8 * p[0] + 0.2 * p[3]));
}

// A series in memory, cut at any moment.
struct Series {
  Lattice4 lattice;
  MemorySamples samples;
  Coefficients coefficients;
  TestContext context;

  explicit Series(LatticeKind kind, const char* kernel = "default", bool periodic = false)
      : lattice(Lattice4::fit(kind, {30, 28, 26, 12}, {1, 1, 1, 1}, 0, {}, periodic)),
        samples(sample_field(lattice, moving, 0)),
        coefficients(samples, 0, make_kernel(kernel), 0, uint64_t{1} << 30), context(2) {}
  [[nodiscard]] Slice cut(double frame, bool later, double around = 0) {
    return thick_time_slice(coefficients, frame, {-around, around}, ThicknessKind::mean, {}, context.get(),
                            later);
  }
};

class GpuMoments : public BothPictures {
 protected:
  Scene scene_of(const Slice& s) {
    Scene scene = make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, true, 25, 40, pixels, pixels));
    scene.drawers = &drawers_;
    return scene;
  }
  RenderStats draw_on_gpu(const Slice& s, ImageStorage& image) {
    RenderOptions o;
    o.backend = Backend::gpu, o.gpu = gpu_, o.shading = false;
    return draw(scene_of(s), o, image);
  }
  void TearDown() override { drawers_.forget(); }
  Drawers drawers_;
};

TEST_P(GpuMoments, AreThoseOfTheCpu) {
  for (const auto& [kind, kernel, periodic] :
       {std::tuple{LatticeKind::d4star, "default", false}, std::tuple{LatticeKind::d4star, "paper", false},
        std::tuple{LatticeKind::d4star, "fine", true}, std::tuple{LatticeKind::d4star, "fast", false},
        std::tuple{LatticeKind::cc, "exact", false}}) {
    Series series(kind, kernel, periodic);
    for (const double frame : {0.0, 3.25, 11.0}) {
      const Slice now = series.cut(frame, false), later = series.cut(frame, true);
      ASSERT_TRUE(later.coset.moment()) << kernel;
      EXPECT_FALSE(now.coset.moment());
      ImageStorage merged(pixels, pixels), together(pixels, pixels);
      (void)draw_on_gpu(now, merged);
      (void)draw_on_gpu(later, together);
      EXPECT_GT(compare(merged, together).db(), 90) << kernel << frame;
      RenderOptions o;
      o.shading = false;
      EXPECT_GT(differ(scene_of(later), o).db(), least_db) << kernel << frame;
      o.mode = RenderMode::maximum;
      EXPECT_GT(differ(scene_of(later), o).db(), least_db) << kernel << frame;
    }
  }
}

// Of the mean over an interval as many layers take part as it is long.
TEST_P(GpuMoments, MeansOverTime) {
  Series series(LatticeKind::d4star);
  const Slice now = series.cut(5.5, false, 4.5), later = series.cut(5.5, true, 4.5);
  ASSERT_GT(later.coset.moment()->parts().size(), 9u); // more than a shader adds at a time
  ImageStorage merged(pixels, pixels), together(pixels, pixels);
  (void)draw_on_gpu(now, merged);
  (void)draw_on_gpu(later, together);
  EXPECT_GT(compare(merged, together).db(), 90);
}

TEST_P(GpuMoments, LayersAreSentOnce) {
  Series series(LatticeKind::d4star);
  ImageStorage image(pixels, pixels);
  const Slice first = series.cut(4, true);
  const RenderStats begin = draw_on_gpu(first, image);
  EXPECT_EQ(begin.drawn.layers_sent, first.coset.moment()->parts().size());
  EXPECT_GT(begin.drawn.bytes_sent, 0u);
  const uint64_t layer = begin.drawn.bytes_sent / begin.drawn.layers_sent;
  uint64_t layers = 0, bytes = 0;
  for (int n = 1; n <= 20; ++n) { // two frames on, a tenth of a frame at a time
    const Slice s = series.cut(4 + 0.1 * n, true);
    const RenderStats stats = draw_on_gpu(s, image);
    layers += stats.drawn.layers_sent, bytes += stats.drawn.bytes_sent;
    EXPECT_FALSE(s.coset.moment()->is_merged()) << n; // no bricks were made for it
  }
  EXPECT_LE(static_cast<double>(layers), std::ceil(2 / series.lattice.time_step) + 1);
  EXPECT_GT(layers, 0u);
  EXPECT_LT(bytes, 2 * layer * layers);
  const Slice back = series.cut(4.55, true); // what was seen is there
  EXPECT_EQ(draw_on_gpu(back, image).drawn.bytes_sent, 0u);
  EXPECT_EQ(draw_on_gpu(back, image).drawn.bytes_sent, 0u);
  drawers_.forget();
  EXPECT_EQ(gpu_->bytes(), 0u);
  EXPECT_EQ(draw_on_gpu(back, image).drawn.layers_sent, back.coset.moment()->parts().size());
}

// Where the layers find no room the moment alone may.
TEST_P(GpuMoments, WithoutRoomForLayers) {
  Series series(LatticeKind::d4star);
  const Slice later = series.cut(3.25, true), now = series.cut(3.25, false);
  ImageStorage image(pixels, pixels), merged(pixels, pixels);
  (void)draw_on_gpu(now, merged);
  const uint64_t enough = gpu_->bytes();
  drawers_.forget();
  gpu_ = test_gpu(GetParam(), enough + enough / 8);
  for (int n = 0; n < 2; ++n) {
    (void)draw_on_gpu(later, image);
    EXPECT_GT(compare(image, merged).db(), 100);
    EXPECT_LE(gpu_->bytes(), enough + enough / 8);
  }
}

INSTANTIATE_TEST_SUITE_P(Entries, GpuMoments, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         entry_name);

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Moments of a series, merged on the GPU of layers that are sent once: their pictures are those of moments
// that the CPU merges, and what is sent is counted.
#include "field/moment.h"

#include "tests/unit/gpu/both_pictures.h"

namespace bccsplat {
namespace {

using namespace test;

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
    MovingCloud series(kind, kernel, periodic);
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
  MovingCloud series(LatticeKind::d4star);
  const Slice now = series.cut(5.5, false, 4.5), later = series.cut(5.5, true, 4.5);
  ASSERT_GT(later.coset.moment()->parts().size(), 9u); // more than a shader adds at a time
  ImageStorage merged(pixels, pixels), together(pixels, pixels);
  (void)draw_on_gpu(now, merged);
  (void)draw_on_gpu(later, together);
  EXPECT_GT(compare(merged, together).db(), 90);
}

TEST_P(GpuMoments, LayersAreSentOnce) {
  MovingCloud series(LatticeKind::d4star);
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

// Corrections are a moment's own; its layers are merged where they are all the same.
TEST_P(GpuMoments, WithCorrections) {
  MovingCloud series(LatticeKind::d4star);
  ImageStorage merged(pixels, pixels), together(pixels, pixels), without(pixels, pixels);
  (void)draw_on_gpu(series.cut(4.1, true), without);
  for (const float size : {0.25f, -0.2f}) { // the same moment, corrected in another way
    Slice now = series.cut(4, false), later = series.cut(4, true);
    (void)draw_on_gpu(later, without);
    for (Slice* s : {&now, &later}) {
      s->corrections = make_corrections(CorrectionShape::tent, size, {30, 28, 26});
      s->bounds[0] -= 0.25, s->bounds[1] += 0.25;
    }
    (void)draw_on_gpu(now, merged);
    const RenderStats stats = draw_on_gpu(later, together);
    EXPECT_FALSE(later.coset.moment()->is_merged());
    EXPECT_EQ(stats.drawn.layers_sent, 0u);
    EXPECT_GT(stats.drawn.bytes_sent, 0u);
    EXPECT_GT(compare(merged, together).db(), 90);
    EXPECT_LT(compare(without, together).db(), 60);
    EXPECT_EQ(draw_on_gpu(later, together).drawn.bytes_sent, 0u); // nothing twice
  }
}

// Where the layers find no room the moment alone may.
TEST_P(GpuMoments, WithoutRoomForLayers) {
  MovingCloud series(LatticeKind::d4star);
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

// A cloud that grows dense: its values change ever faster.
double growing(const Vec4& p) { return (0.004 + 0.006 * p[3] * p[3]) * moving(p); }

// Whatever was drawn before, from the same layers or others, a picture is the one that is drawn first.
TEST_P(GpuMoments, KnowNothingOfPicturesBefore) {
  constexpr int few = pixels / 4;
  MovingCloud series(LatticeKind::d4star, "default", false, growing);
  std::vector<Slice> slices;
  for (const double frame : {1.3, 9.6}) slices.push_back(series.cut(frame, true));
  for (const ThicknessKind kind : {ThicknessKind::mean, ThicknessKind::sum})
    slices.push_back(series.cut(5.5, true, 1.5, kind));
  slices.push_back(slices[1]);
  slices.back().corrections = make_corrections(CorrectionShape::tent, 0.25f, {30, 28, 26});
  slices.back().bounds[0] -= 0.25, slices.back().bounds[1] += 0.25;
  slices.push_back(series.cut(9.6, false)); // merged by the CPU
  // Of sums it shows something where means have nothing, and is narrow where values change fast.
  TransferFunction peak = ramp_function(0.1, 1, 0);
  peak.opacities = {{0.4, 0}, {0.48, 0.8}, {0.56, 0}};
  struct State {
    Scene scene;
    RenderOptions options;
  };
  std::vector<State> states;
  for (const Slice& s : slices) {
    State one{make_scene(s, peak, fit_camera(s, false, 25, 40, few, few)), {}};
    one.options.backend = Backend::gpu, one.options.gpu = gpu_, one.options.sheet_step = 2.7;
    states.push_back(one);
  }
  states.push_back(states[1]); // rays in perspective pass more cells with a step
  states.back().scene.camera = fit_camera(slices[1], true, 25, 40, few, few);
  states.push_back(states[2]);
  states.back().options.mode = RenderMode::xray;
  const auto picture = [&](const State& of, Drawers& by) {
    ImageStorage image(few, few);
    Scene scene = of.scene;
    scene.drawers = &by;
    EXPECT_STREQ(draw(scene, of.options, image).drawer, "gpu");
    return image.rgba;
  };
  std::vector<std::vector<float>> fresh;
  for (const State& s : states) {
    Drawers own;
    fresh.push_back(picture(s, own));
  }
  const auto expect_fresh = [&](size_t n) { EXPECT_TRUE(picture(states[n], drawers_) == fresh[n]) << n; };
  for (size_t a = 0; a < states.size(); ++a) { // each after itself, and after each other
    expect_fresh(a), expect_fresh(a);
    for (size_t b = a + 1; b < states.size(); ++b) {
      SCOPED_TRACE(std::to_string(a) + " and " + std::to_string(b));
      expect_fresh(b), expect_fresh(a);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Entries, GpuMoments, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         entry_name);

} // namespace
} // namespace bccsplat

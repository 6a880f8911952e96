// SPDX-License-Identifier: Apache-2.0
// Many thin sheets, none, and one that hides all.
#include "tests/stability/stability.h"

namespace host {
namespace {

struct Block {
  Device device = make_device();
  Stored stored;
  Slice slice;
  bccsplat_camera camera = sized<bccsplat_camera>();
  double depth; // of the block along the view

  explicit Block(uint32_t n = 40) : depth(n - 1) {
    stored =
        store(device, Series{.nx = 9, .ny = 9, .nz = n, .nt = 1, .field = [](double, double, double, double) {
                               return 1;
                             }});
    slice = cut_time(stored.volume, 0);
    camera.position[0] = camera.target[0] = camera.position[1] = camera.target[1] = 4;
    camera.position[2] = -10;
    camera.up[1] = 1;
    camera.ortho_height = 4; // well inside the block
  }
  // The four channels of the middle pixel under constant opacity per unit length.
  [[nodiscard]] std::array<float, 4> centre(double opacity, double step, double stop = 1) const {
    Shot shot{.width = 5, .height = 5, .ramp = {}, .camera = &camera};
    shot.ramp = {-1e-9, 0, opacity, 1}; // full from 0 on
    shot.options.sheet_step = step;
    shot.options.shading = BCCSPLAT_SHADING_OFF;
    shot.options.opacity_stop = stop;
    const std::vector<float> got = picture(device, slice, shot);
    return {got[48], got[49], got[50], got[51]};
  }
};

TEST(StabilityCompositing, TenThousandThinSheetsAddUpToTheClosedForm) {
  const Block block(200); // sheets may stand no closer than 1/64
  const double step = block.depth / 1e4;
  for (const double per_sheet : {1e-5, 1e-4, 1e-3}) {
    const double per_unit = 1 - std::pow(1 - per_sheet, 1 / step);
    const double closed = 1 - std::pow(1 - per_sheet, 1e4);
    Bound("10^4 sheets of " + shown(per_sheet) + ", relative", 1e-4)
        .add(block.centre(per_unit, step)[3] / closed - 1);
  }
}

TEST(StabilityCompositing, TheStepDoesNotChangeAConstantFog) {
  const Block block;
  const double closed = 1 - std::pow(1 - 0.03, block.depth);
  for (const double step : {2.0, 1.0, 0.5, 0.125, 0.03})
    Bound("fog in sheets of " + shown(step), 1e-5).add(block.centre(0.03, step)[3] - closed);
}

TEST(StabilityCompositing, OpacityZeroIsNothingAndOneIsAll) {
  const Block block;
  Bound nothing("opacity 0", 0), all("opacity 1", 1e-6);
  for (const float v : block.centre(0, 0.5)) nothing.add(v);
  for (const double step : {1.0, 0.25})
    for (const float v : block.centre(1, step)) all.add(static_cast<double>(v) - 1);
}

TEST(StabilityCompositing, HalvingTheStepConvergesWithOrderTwo) {
  const Device device = make_device();
  const Stored stored = store(device, Series{.nt = 1});
  const Slice slice = cut_time(stored.volume, 0);
  const auto at = [&](double step, bool reference) {
    Shot shot{.ramp = {10, 100, 0.15, 1}};
    shot.options.sheet_step = step;
    shot.options.shading = BCCSPLAT_SHADING_OFF;
    shot.options.opacity_stop = 1;
    shot.options.reference = reference;
    return picture(device, slice, shot);
  };
  const std::vector<float> truth = at(0, true);
  const auto rmse = [&](const std::vector<float>& got) {
    double sum = 0;
    for (size_t i = 0; i < got.size(); ++i) sum += std::pow(static_cast<double>(got[i]) - truth[i], 2);
    return std::sqrt(sum / static_cast<double>(got.size()));
  };
  const double coarse = rmse(at(2, false)), middle = rmse(at(1, false)), fine = rmse(at(0.5, false));
  Bound("2 less the order, steps 2 to 1", 0.4).add(larger(0, 2 - std::log2(coarse / middle)));
  Bound("2 less the order, steps 1 to .5", 0.4).add(larger(0, 2 - std::log2(middle / fine)));
  Bound("RMSE at step 1 against double integration", 0.002).add(middle);
}

TEST(StabilityCompositing, ATrailOfNoTimeIsNoTrail) {
  const Device device = make_device();
  const Stored stored = store(device, Series{.nx = 64, .ny = 64, .nz = 64, .nt = 4});
  const Slice slice = cut_time(stored.volume, 1.5);
  const auto none = sized<bccsplat_trail>();
  std::array<bccsplat_iso_surface, 2> surfaces{};
  surfaces[0].value = 40, surfaces[0].opacity = 0.4;
  surfaces[1].value = 70, surfaces[1].opacity = 0.6;
  for (const bool translucent : {false, true}) {
    // Smaller than the data: fine detail may be left out, which a trail does not do.
    Shot shot{.width = 20, .height = 20, .ramp = {10, 100, 0.15, 1}};
    shot.options.quality = BCCSPLAT_QUALITY_DRAFT;
    if (translucent)
      shot.options.mode = BCCSPLAT_MODE_ISOSURFACE, shot.options.surfaces = surfaces.data(),
      shot.options.surface_count = 2;
    const std::vector<float> still = picture(device, slice, shot);
    shot.trail = &none;
    EXPECT_TRUE(still == picture(device, slice, shot)) << translucent;
  }
}

TEST(StabilityCompositing, SeveralSurfacesHaveTheColoursOfTheirValues) {
  const Device device = make_device();
  const Stored stored = store(device, Series{.nt = 1});
  const Slice slice = cut_time(stored.volume, 0);
  auto look = sized<bccsplat_look>();
  ASSERT_OK(bccsplat_volume_get_look(stored.volume.get(), 0, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_COMPOSITE,
                                     &look));
  auto function = sized<bccsplat_transfer_function>();
  function.colors = look.colors[0], function.color_count = look.color_count;
  function.opacities = look.opacities[0], function.opacity_count = look.opacity_count;
  std::array<bccsplat_iso_surface, 2> surfaces{};
  surfaces[0].value = 40, surfaces[0].opacity = 0.5;
  surfaces[1].value = 70, surfaces[1].opacity = 1;
  Shot shot;
  shot.own_look = true;
  shot.options.mode = BCCSPLAT_MODE_ISOSURFACE, shot.options.surfaces = surfaces.data();
  shot.options.surface_count = 2;
  const std::vector<float> own = picture(device, slice, shot);
  shot.own_look = false, shot.function = &function;
  EXPECT_TRUE(own == picture(device, slice, shot));
  EXPECT_GT(*std::max_element(own.begin(), own.end()), 0.1f);
}

} // namespace
} // namespace host

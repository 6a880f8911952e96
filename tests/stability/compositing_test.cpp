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
    EXPECT_NEAR(block.centre(per_unit, step)[3], closed, 1e-4 * closed) << per_sheet;
  }
}

TEST(StabilityCompositing, TheStepDoesNotChangeAConstantFog) {
  const Block block;
  const double closed = 1 - std::pow(1 - 0.03, block.depth);
  for (const double step : {2.0, 1.0, 0.5, 0.125, 0.03})
    EXPECT_NEAR(block.centre(0.03, step)[3], closed, 1e-5) << step;
}

TEST(StabilityCompositing, OpacityZeroIsNothingAndOneIsAll) {
  const Block block;
  for (const float v : block.centre(0, 0.5)) EXPECT_EQ(v, 0);
  for (const double step : {1.0, 0.25})
    for (const float v : block.centre(1, step)) EXPECT_NEAR(v, 1, 1e-6);
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
    for (size_t i = 0; i < got.size(); ++i)
      sum += std::pow(static_cast<double>(got[i]) - static_cast<double>(truth[i]), 2);
    return std::sqrt(sum / static_cast<double>(got.size()));
  };
  const double coarse = rmse(at(2, false)), middle = rmse(at(1, false)), fine = rmse(at(0.5, false));
  EXPECT_GE(std::log2(coarse / middle), 1.6);
  EXPECT_GE(std::log2(middle / fine), 1.6);
  EXPECT_LE(middle, 0.002);
}

} // namespace
} // namespace host

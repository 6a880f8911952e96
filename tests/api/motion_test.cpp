// SPDX-License-Identifier: Apache-2.0
// Slices that follow what moves: nearer to it between frames, the frame at frames, refused where there is no
// such slice.
#include <cmath>

#include "support.h"

namespace host {
namespace {

constexpr uint32_t edge = 40;

// Moves by 4 samples from frame to frame.
double mover(double x, double y, double z, double t) {
  const double dx = x - 6 - 4 * t, dy = y - 32 + 2.4 * t, dz = z - 20;
  const double v = std::exp(-(dx * dx + dy * dy + dz * dz) / 18);
  return v < 1e-6 ? 0 : v;
}

class Motion : public testing::Test {
 protected:
  Folder folder;
  Device device = make_device();
  Volume volume;

  void SetUp() override {
    write_series(device, folder.file("s.bcc4"),
                 {.nx = edge, .ny = edge, .nz = edge, .nt = 8, .field = mover});
    volume = open(device, folder.file("s.bcc4"));
  }
  bccsplat_status create(double frame, const bccsplat_slice_options& o, Slice& out) {
    auto plane = sized<bccsplat_hyperplane>();
    plane.d = 1, plane.e = -frame;
    bccsplat_slice* made = nullptr;
    const bccsplat_status status = bccsplat_slice_create(volume.get(), &plane, &o, &made);
    out.reset(made);
    return status;
  }
  std::vector<float> values(double frame, bccsplat_motion motion) {
    auto o = sized<bccsplat_slice_options>();
    o.motion = motion;
    Slice slice;
    EXPECT_OK(create(frame, o, slice));
    std::vector<float> v(size_t{edge} * edge * edge);
    EXPECT_OK(bccsplat_slice_sample_grid(slice.get(), nullptr, v.data()));
    return v;
  }
  double error(double frame, bccsplat_motion motion) {
    const std::vector<float> v = values(frame, motion);
    double squares = 0;
    for (size_t i = 0; i < v.size(); ++i)
      squares += std::pow(
          v[i] - mover(double(i % edge), double(i / edge % edge), double(i / edge / edge), frame), 2);
    return std::sqrt(squares / static_cast<double>(v.size()));
  }
};

TEST_F(Motion, MomentIsNearerToWhatMoves) {
  EXPECT_LT(error(3.5, BCCSPLAT_MOTION_ON), .7 * error(3.5, BCCSPLAT_MOTION_OFF));
  EXPECT_EQ(values(3.5, BCCSPLAT_MOTION_DEFAULT), values(3.5, BCCSPLAT_MOTION_OFF));
}

TEST_F(Motion, FrameIsTheFrame) { EXPECT_EQ(values(3, BCCSPLAT_MOTION_ON), values(3, BCCSPLAT_MOTION_OFF)); }

TEST_F(Motion, IsOfWholeMomentsAlone) {
  Slice slice;
  auto o = sized<bccsplat_slice_options>();
  o.motion = 3;
  EXPECT_EQ(create(3.5, o, slice), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o.motion = BCCSPLAT_MOTION_ON, o.thickness = 1;
  EXPECT_EQ(create(3.5, o, slice), BCCSPLAT_ERROR_UNSUPPORTED);
  const std::array<double, 6> box{2, 3, 4, 12, 11, 10};
  o.thickness = 0, o.box = box.data();
  EXPECT_EQ(create(3.5, o, slice), BCCSPLAT_ERROR_UNSUPPORTED);
  o.box = nullptr, o.method = BCCSPLAT_METHOD_RESAMPLED;
  EXPECT_EQ(create(3.5, o, slice), BCCSPLAT_ERROR_UNSUPPORTED);
  auto across = sized<bccsplat_hyperplane>();
  across.a = 1, across.e = -20;
  bccsplat_slice* made = nullptr;
  o.method = BCCSPLAT_METHOD_DEFAULT;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &across, &o, &made), BCCSPLAT_ERROR_UNSUPPORTED);
}

TEST_F(Motion, PrefetchFindsTheWay) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -3.5;
  auto o = sized<bccsplat_slice_options>();
  o.motion = BCCSPLAT_MOTION_ON;
  EXPECT_OK(bccsplat_volume_prefetch(volume.get(), &plane, &o));
  EXPECT_LT(error(3.5, BCCSPLAT_MOTION_ON), .7 * error(3.5, BCCSPLAT_MOTION_OFF));
}

} // namespace
} // namespace host

// SPDX-License-Identifier: Apache-2.0
// Looks of slices: planes off the time axis have colours of their own values, moments those of the series.
#include <cmath>

#include "support.h"

namespace host {
namespace {

// A bright blob at z = 12 and a faint one at z = 4.
class SliceLook : public testing::Test {
 protected:
  SliceLook() {
    Series s;
    s.field = [](double x, double y, double z, double) {
      const auto blob = [&](double most, double at) {
        return most * std::exp(-(std::pow(x - 8, 2) + std::pow(y - 8, 2) + std::pow(z - at, 2)) / 8);
      };
      return blob(1000, 12) + blob(80, 4);
    };
    write_series(device, folder.file("v.bcc4"), s);
    volume = open(device, folder.file("v.bcc4"));
  }
  [[nodiscard]] bccsplat_look look_of(const Slice& slice, int32_t mode = BCCSPLAT_MODE_DEFAULT) const {
    auto look = sized<bccsplat_look>();
    EXPECT_OK(bccsplat_slice_get_look(slice.get(), BCCSPLAT_LOOK_DEFAULT, mode, &look));
    return look;
  }
  Folder folder;
  Device device = make_device();
  Volume volume;
};

TEST_F(SliceLook, PlanesHaveColoursOfTheirOwnValues) {
  auto series = sized<bccsplat_look>();
  ASSERT_OK(bccsplat_volume_get_look(volume.get(), 0, 0, 0, &series));
  const bccsplat_look faint = look_of(cut(volume, 0, 0, 1, 0, -4)),
                      bright = look_of(cut(volume, 0, 0, 1, 0, -12));
  EXPECT_GT(series.range[1], 500);
  EXPECT_GT(bright.range[1], 500);
  EXPECT_LT(faint.range[1], 150);
  EXPECT_LT(faint.colors[faint.color_count - 1][0], 150);
  for (const bccsplat_look& plane : {faint, bright}) {
    EXPECT_EQ(plane.kind, series.kind);
    EXPECT_EQ(plane.empty[1], series.empty[1]);
    EXPECT_EQ(plane.iso_value, series.iso_value);
  }
}

TEST_F(SliceLook, ExtractedPointsHaveThemToo) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.c = 1, plane.e = -4;
  auto options = sized<bccsplat_slice_options>();
  options.method = BCCSPLAT_METHOD_EXTRACTED;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, &options, &made));
  EXPECT_LT(look_of(Slice(made)).range[1], 150);
}

TEST_F(SliceLook, MomentsHaveThatOfTheirVolume) {
  const Slice moment = cut(volume, 0, 0, 0, 1, -3);
  for (const int32_t mode : {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_MAXIMUM, BCCSPLAT_MODE_ISOSURFACE}) {
    auto series = sized<bccsplat_look>();
    ASSERT_OK(bccsplat_volume_get_look(volume.get(), 0, 0, mode, &series));
    const bccsplat_look look = look_of(moment, mode);
    EXPECT_EQ(look.range[1], series.range[1]);
    EXPECT_EQ(look.color_count, series.color_count);
    EXPECT_EQ(look.opacities[look.opacity_count - 1][1], series.opacities[series.opacity_count - 1][1]);
  }
}

TEST_F(SliceLook, NothingIsToldOfASliceThatMissesTheVolume) {
  auto look = sized<bccsplat_look>();
  EXPECT_EQ(bccsplat_slice_get_look(cut(volume, 0, 0, 1, 0, 99).get(), 0, 0, &look),
            BCCSPLAT_ERROR_WRONG_STATE);
}

} // namespace
} // namespace host

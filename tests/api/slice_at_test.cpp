// SPDX-License-Identifier: Apache-2.0
// A slice at a time in the file's own unit is the hyperplane of its frame number.
#include "support.h"

namespace host {
namespace {

std::vector<float> all_values_of(bccsplat_slice* slice) {
  auto info = sized<bccsplat_slice_info>();
  EXPECT_OK(bccsplat_slice_get_info(slice, &info));
  std::vector<float> values(info.dims[0] * info.dims[1] * info.dims[2]);
  EXPECT_OK(bccsplat_slice_sample_grid(slice, nullptr, values.data()));
  return values;
}

TEST(SliceAt, IsTheHyperplaneOfTheTime) {
  const Folder folder;
  const Device device = make_device();
  for (const bool uneven : {false, true}) {
    Series s{.first = 100, .step = 0.25};
    if (uneven) s.times = {100, 100.5, 103, 103.25, 104, 107, 107.5, 108};
    write_series(device, folder.file("s.bcc4"), s);
    const Volume volume = open(device, folder.file("s.bcc4"));
    auto options = sized<bccsplat_slice_options>();
    const std::array<double, 6> box{2, 3, 4, 12, 11, 10};
    for (const bool part : {false, true})
      for (const double time : {100.0, 100.7, 101.6}) {
        options.box = part ? box.data() : nullptr;
        double index = 0;
        ASSERT_OK(bccsplat_volume_time_to_index(volume.get(), time, &index));
        auto plane = sized<bccsplat_hyperplane>();
        plane.d = 1, plane.e = -index;
        bccsplat_slice *at = nullptr, *by_frame = nullptr;
        ASSERT_OK(bccsplat_volume_slice_at(volume.get(), time, part ? &options : nullptr, &at));
        ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, &options, &by_frame));
        const Slice a(at), b(by_frame);
        EXPECT_EQ(all_values_of(at), all_values_of(by_frame)) << time;
      }
    std::filesystem::remove(folder.file("s.bcc4"));
  }
}

TEST(SliceAt, AVolumeWithoutTimeHasOneMoment) {
  const Folder folder;
  const Device device = make_device();
  write_series(device, folder.file("s.bcc4"), {.nt = 1, .first = 7});
  const Volume volume = open(device, folder.file("s.bcc4"));
  bccsplat_slice *now = nullptr, *later = nullptr;
  ASSERT_OK(bccsplat_volume_slice_at(volume.get(), 7, nullptr, &now));
  ASSERT_OK(bccsplat_volume_slice_at(volume.get(), 99, nullptr, &later));
  const Slice a(now), b(later);
  EXPECT_EQ(all_values_of(now), all_values_of(later));
}

} // namespace
} // namespace host

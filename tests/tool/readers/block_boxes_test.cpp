// SPDX-License-Identifier: Apache-2.0
#include "readers/vdb/block_boxes.h"

#include <random>

#include "scratch.h"
#include "series/scan.h"

namespace bcc4::test {
namespace {

TEST(BlockBoxes, CoverEveryBlockOnceAndNothingElse) {
  std::mt19937 random(7);
  for (const double fill : {0.0, 0.02, 0.3, 0.8, 1.0}) {
    const std::array<int32_t, 3> extent{13, 9, 11};
    std::vector<std::array<int32_t, 3>> blocks;
    std::vector<int> wanted(13 * 9 * 11), got(13 * 9 * 11);
    const auto index = [&](int32_t x, int32_t y, int32_t z) {
      return static_cast<size_t>((z * 9 + y) * 13 + x);
    };
    for (int32_t z = 0; z < 11; ++z)
      for (int32_t y = 0; y < 9; ++y)
        for (int32_t x = 0; x < 13; ++x)
          if (std::uniform_real_distribution(0.0, 1.0)(random) < fill) {
            blocks.push_back({x, y, z});
            wanted[index(x, y, z)] = 1;
          }
    std::shuffle(blocks.begin(), blocks.end(), random);
    const auto boxes = merge_blocks(blocks, extent, 4);
    for (const BlockBox& b : boxes)
      for (int32_t z = 0; z < b.dims[2]; ++z)
        for (int32_t y = 0; y < b.dims[1]; ++y)
          for (int32_t x = 0; x < b.dims[0]; ++x)
            ++got[index(b.begin[0] + x, b.begin[1] + y, b.begin[2] + z)];
    EXPECT_EQ(got, wanted);
    if (fill == 1.0) {
      EXPECT_EQ(boxes.size(), 4u * 3 * 3);
    }
  }
}

TEST(Scan, CountsAirRangeAndNonFinite) {
  const std::array<uint64_t, 4> dims{4, 1, 2, 1};
  auto bytes = std::make_shared<Bytes>(2 * sizeof(float));
  const float values[] = {5, std::numeric_limits<float>::quiet_NaN()};
  std::memcpy(bytes->data(), values, sizeof values);
  Frame frame;
  frame.boxes.push_back({{{1, 0, 1}, {2, 1, 1}}, Type::f32, bytes->data(), {4, 8, 8}});
  frame.storage.push_back(bytes);
  ChannelScan scan;
  scan_frame(frame, 3, dims, -1, 0, scan);
  EXPECT_EQ(scan.samples, 8u);
  EXPECT_EQ(scan.relevant, 2u);
  EXPECT_EQ(scan.min, -1); // uncovered voxels are air
  EXPECT_EQ(scan.max, 5);
  EXPECT_EQ(scan.nonfinite, 1u);
  EXPECT_EQ(scan.first_frame, 3u);
  EXPECT_EQ(scan.first_voxel, (std::array<uint64_t, 3>{2, 0, 1}));
  std::vector<double> plane(4);
  gather_plane(frame, dims, 1, -1, plane.data());
  EXPECT_EQ(plane[0], -1);
  EXPECT_EQ(plane[1], 5);
  gather_plane(frame, dims, 0, -1, plane.data());
  EXPECT_EQ(plane, (std::vector<double>{-1, -1, -1, -1}));
}

TEST(Text, FindsTheNearestName) {
  const std::vector<std::string> names{"density", "temperature", "--dims"};
  EXPECT_EQ(nearest_name("denisty", names), "density");
  EXPECT_EQ(nearest_name("--dim", names), "--dims");
  EXPECT_EQ(nearest_name("velocity_z", names), "");
}

TEST(Text, ParsesNumbersWhole) {
  EXPECT_EQ(parse_number<double>("+1.5e3"), 1500.0);
  EXPECT_FALSE(parse_number<double>("1,5"));
  EXPECT_FALSE(parse_number<double>("1.5 "));
  EXPECT_FALSE(parse_number<int64_t>("1.5"));
  EXPECT_FALSE(parse_number<uint64_t>("-1"));
  EXPECT_FALSE(parse_number<double>(""));
}

} // namespace
} // namespace bcc4::test

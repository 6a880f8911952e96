// SPDX-License-Identifier: Apache-2.0
#include "volume/data_kind.h"

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

using series::DataKind;

// A file of one channel in which nothing is told.
struct File : VolumeInfo {
  ChannelInfo channel;
  ValueCounts counts;
  File() {
    channel.name = "value";
    counts.bins.assign(256, 10);
    counts.stored = counts.source = {0, 1000};
  }
  File& say(const std::string& key, const std::string& value) {
    attributes.emplace_back(key, value);
    return *this;
  }
  File& large(double size) {
    for (size_t a = 0; a < 3; ++a) affine.linear[a] = size * affine.linear[a];
    return *this;
  }
  [[nodiscard]] DataKind kind() const { return kind_of_data(*this, channel, counts); }
};

TEST(DataKindOfFile, SidesAndSizesMakeAScan) {
  EXPECT_EQ(File().kind(), DataKind::unknown);
  EXPECT_EQ(File().say("space", "right-anterior-superior").kind(), DataKind::unknown);
  EXPECT_EQ(File().say("space", "right-anterior-superior").large(1.4).kind(), DataKind::mr);
  EXPECT_EQ(File().say("space", "LPS").large(1.4).kind(), DataKind::mr);
  EXPECT_EQ(File().say("space", "3D-right-handed").large(1.4).kind(), DataKind::unknown);
  File f;
  f.spatial_unit = "mm";
  EXPECT_EQ(f.say("space", "left-posterior-superior").kind(), DataKind::mr);
  f.counts.source.low = -1024;
  EXPECT_EQ(f.kind(), DataKind::ct);
}

TEST(DataKindOfFile, DegreesMakeAMap) {
  File world, uneven, even;
  world.spatial_unit = "degrees";
  EXPECT_EQ(world.kind(), DataKind::map);
  uneven.axes[0].unit = "degrees", uneven.axes[2].unit = "m";
  EXPECT_EQ(uneven.kind(), DataKind::unknown) << "y is not";
  uneven.axes[1].unit = "degrees";
  EXPECT_EQ(uneven.kind(), DataKind::map);
  even.say("axis.x", R"({"name":"lon","units":"degrees_east"})")
      .say("axis.y", R"({"units":"degrees_north"})");
  EXPECT_EQ(even.kind(), DataKind::map);
}

TEST(DataKindOfFile, HeadersAndUnitsAreTakenAtTheirWord) {
  EXPECT_EQ(File().say("openvdb.class.value", "fog volume").kind(), DataKind::smoke);
  EXPECT_EQ(File().say("openvdb.class.other", "fog volume").kind(), DataKind::unknown);
  EXPECT_EQ(File().say("openvdb.class.value", "fog volume").say("openvdb.name.value", "Flames").kind(),
            DataKind::fire);
  EXPECT_EQ(File().say("kind.value", "statistic").kind(), DataKind::statistic);
  File speed;
  speed.channel.unit = "m/s";
  EXPECT_EQ(speed.kind(), DataKind::field);
  File atlas;
  atlas.counts.integers = true, atlas.counts.labels = true;
  EXPECT_EQ(atlas.kind(), DataKind::labels);
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Which base the field of a channel has, and that samples are read relative to it.
#include "formats/bcc4/field_base.h"

#include <gtest/gtest.h>

#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

VolumeInfo volume_of_sites() {
  VolumeInfo info;
  info.lattice = Lattice4::fit(LatticeKind::d4star, {20, 20, 20, 8});
  return info;
}

ChannelInfo dense(float air, Range kept) {
  ChannelInfo c;
  c.air = air, c.offset = static_cast<double>(air);
  c.sites_kept = static_cast<uint64_t>(volume_of_sites().lattice.sites());
  c.kept_range = kept;
  return c;
}

TEST(FieldBase, IsAmongValuesFarFromAir) {
  const VolumeInfo info = volume_of_sites();
  EXPECT_EQ(field_base(info, dense(0, {101275, 101375})), 101325);
  EXPECT_EQ(field_base(info, dense(0, {-40, -30})), -35);
  EXPECT_EQ(field_base(info, dense(7, {5, 5})), 5);
  // Nearer than the values are to each other, and among them.
  EXPECT_EQ(field_base(info, dense(0, {50, 100})), 0);
  EXPECT_EQ(field_base(info, dense(0, {49, 99})), 0);
  EXPECT_EQ(field_base(info, dense(0, {51, 100})), 75.5f);
  EXPECT_EQ(field_base(info, dense(60, {50, 100})), 60);
  EXPECT_EQ(field_base(info, dense(0, {-3e38, -2.9e38})), -2.95e38f);
}

TEST(FieldBase, IsAirWhereSitesAreOrCorrections) {
  const VolumeInfo info = volume_of_sites();
  ChannelInfo c = dense(0, {101275, 101375});
  --c.sites_kept;
  EXPECT_EQ(field_base(info, c), 0);
  c = dense(0, {101275, 101375});
  c.residuals.bound = 0.5;
  EXPECT_EQ(field_base(info, c), 0);
}

// What is left out beside masks is missing data, where no source sample is near air.
TEST(FieldBase, IsAmongValuesWhereOthersAreMissing) {
  VolumeInfo info = volume_of_sites();
  ChannelInfo c = dense(0, {101275, 101375});
  c.sites_kept /= 2;
  c.source_range = {101276, 101374};
  EXPECT_EQ(field_base(info, c), 0);
  c.masks.resize(8);
  EXPECT_EQ(field_base(info, c), 101325);
  c.threshold = 2e5; // all would be left out
  EXPECT_EQ(field_base(info, c), 0);
  c.threshold = 0, c.source_range.low = 0;
  EXPECT_EQ(field_base(info, c), 0);
  c.source_range.low = 101276, info.part.emplace();
  EXPECT_EQ(field_base(info, c), 0);
}

// All sites far from air: values and codes relative to either come to the same.
TEST(FieldBase, SamplesAreRelativeToIt) {
  const auto far = [](int, double x, double y, double z, double t) {
    return test::Sample{
        static_cast<float>(100 + std::round(8 * std::sin(0.3 * x + 0.2 * y - 0.4 * z + t)) / 2), true, false};
  };
  for (const ValueType type : {ValueType::u8, ValueType::u16, ValueType::f16, ValueType::f32}) {
    const VolumeInfo info =
        test::volume(LatticeKind::d4star, {20, 19, 18, 6}, {test::channel("far", type, -2)});
    const std::vector<std::byte> file = test::write_file(info, test::make_volume(info, far));
    const auto reader = Bcc4Reader::open(open_memory_source(file));
    test::Bench bench;
    const Bcc4Samples above_air(reader, bench.memory),
        above_base(reader, bench.memory, 1 << 20, RelativeTo::base);
    ASSERT_EQ(above_base.air(0), -2);
    ASSERT_EQ(above_air.base(0), -2);
    const float base = above_base.base(0);
    EXPECT_NEAR(base, 98, 0.01);
    for (int32_t m = 0; m < info.lattice.layers(); ++m) {
      const BrickLayer air = above_air.read_layer(0, m, {}, bench.context),
                       read = above_base.read_layer(0, m, {}, bench.context);
      above_base.read_samples(0, std::span(&m, 1), {}, bench.context, [&](int32_t, SampleLayer&& codes) {
        std::array<float, brick_sites> room;
        for (size_t s = 0; s < air.brick_slots(); ++s) {
          if (!air.brick(s)) continue;
          ASSERT_EQ(air.brick(s)->kept, read.brick(s)->kept);
          const float* all = codes.brick(s).all(room);
          for (size_t i = 0; i < brick_sites; ++i) {
            const bool kept = air.brick(s)->kept[i / brick_edge] >> (i % brick_edge) & 1;
            ASSERT_EQ(read.brick(s)->value[i], kept ? air.brick(s)->value[i] - 2 - base : 0.0f);
            ASSERT_EQ(all[i], read.brick(s)->value[i]);
          }
        }
      });
    }
  }
}

} // namespace
} // namespace bccsplat

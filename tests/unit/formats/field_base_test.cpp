// SPDX-License-Identifier: Apache-2.0
// Which base the field of a channel has, and that samples are read relative to it.
#include "formats/bcc4/field_base.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

VolumeInfo volume_of_sites() {
  VolumeInfo info;
  info.lattice = Lattice4::fit(LatticeKind::d4star, {20, 20, 20, 8});
  return info;
}

ChannelInfo dense_channel(float air, Range kept) {
  ChannelInfo c;
  c.air = air, c.offset = air;
  c.sites_kept = volume_of_sites().lattice.sites();
  c.kept_range = kept;
  return c;
}

float base_of(const VolumeInfo& info, const ChannelInfo& channel) { return field_base(info, channel).value; }

TEST(FieldBase, IsAmongValuesFarFromAir) {
  const VolumeInfo info = volume_of_sites();
  EXPECT_EQ(base_of(info, dense_channel(0, {101275, 101375})), 101325);
  EXPECT_EQ(base_of(info, dense_channel(0, {-40, -30})), -35);
  EXPECT_EQ(base_of(info, dense_channel(7, {5, 5})), 5);
  // Nearer than the values are to each other, and among them.
  EXPECT_EQ(base_of(info, dense_channel(0, {50, 100})), 0);
  EXPECT_EQ(base_of(info, dense_channel(0, {49, 99})), 0);
  EXPECT_EQ(base_of(info, dense_channel(0, {51, 100})), 75.5f);
  EXPECT_EQ(base_of(info, dense_channel(60, {50, 100})), 60);
  EXPECT_EQ(base_of(info, dense_channel(0, {-3e38, -2.9e38})), -2.95e38f);
}

// A few samples elsewhere, and a few sites that are air, do not move it.
TEST(FieldBase, IsAmongMostValues) {
  const VolumeInfo info = volume_of_sites();
  ChannelInfo c = dense_channel(0, {-3000, 120000});
  EXPECT_EQ(base_of(info, c), 0);
  c.percentiles = {{1, -100}, {5, 101275}, {50, 101300}, {95, 101375}, {99, 110000}};
  EXPECT_EQ(base_of(info, c), 101300);
  EXPECT_TRUE(field_base(info, c).absent_is_air);
  const uint64_t all = c.sites_kept;
  c.sites_kept = all - all / 16;
  EXPECT_EQ(base_of(info, c), 101300);
  --c.sites_kept;
  EXPECT_EQ(base_of(info, c), 0);
  c.sites_kept = 0;
  EXPECT_EQ(base_of(info, c), 0);
  c.sites_kept = all, c.percentiles[3].value = 113700; // nine tenths are not so near to each other
  EXPECT_EQ(base_of(info, c), 101300);
  c.percentiles[3].value = 114000;
  EXPECT_EQ(base_of(info, c), 0);
  c.percentiles[3].value = 101375, c.percentiles[1].value = 10; // a twentieth is near air
  EXPECT_EQ(base_of(info, c), 0);
}

// Corrections are differences from one field.
TEST(FieldBase, IsWhatCorrectionsTell) {
  const VolumeInfo info = volume_of_sites();
  ChannelInfo c = dense_channel(0, {101275, 101375});
  c.residuals.bound = 0.5;
  EXPECT_EQ(base_of(info, c), 0);
  c.residuals.base = 101300;
  c.sites_kept /= 2;
  EXPECT_EQ(base_of(info, c), 101300);
  EXPECT_TRUE(field_base(info, c).absent_is_air);
}

// What is left out beside masks is missing data, where no source sample is near air.
TEST(FieldBase, IsAmongValuesWhereOthersAreMissing) {
  VolumeInfo info = volume_of_sites();
  ChannelInfo c = dense_channel(0, {101275, 101375});
  c.sites_kept /= 2;
  c.source_range = {101276, 101374};
  EXPECT_EQ(base_of(info, c), 0);
  c.masks.resize(8);
  EXPECT_EQ(base_of(info, c), 101325);
  EXPECT_FALSE(field_base(info, c).absent_is_air);
  c.threshold = 2e5; // all would be left out
  EXPECT_EQ(base_of(info, c), 0);
  c.threshold = 0, c.source_range.low = 0;
  EXPECT_EQ(base_of(info, c), 0);
  c.source_range.low = 101276, info.part.emplace();
  EXPECT_EQ(base_of(info, c), 0);
}

// Sites that are not stored are air beside a base among the others.
TEST(FieldBase, AbsentSitesAreReadAsAir) {
  const auto nearly_dense = [](int, double x, double y, double z, double t) {
    const bool air = x < 1 && y < 6;
    return test::Sample{static_cast<float>(air ? 0 : 200 + std::sin(0.3 * x + 0.2 * y - 0.4 * z + t)), !air,
                        false};
  };
  for (const ValueType type : {ValueType::u16, ValueType::f32}) {
    const VolumeInfo info =
        test::volume(LatticeKind::d4star, {40, 19, 18, 6}, {test::channel("far", type, 0)});
    const std::vector<std::byte> file = test::write_file(info, test::make_volume(info, nearly_dense));
    const auto reader = Bcc4Reader::open(open_memory_source(file));
    ASSERT_LT(reader->info().channels[0].sites_kept, static_cast<uint64_t>(info.lattice.sites()));
    test::Bench bench;
    const Bcc4Samples samples(reader, bench.memory, 1 << 20, RelativeTo::base);
    const float base = samples.base(0);
    EXPECT_NEAR(base, 200, 1);
    for (int32_t m = 0; m < info.lattice.layers(); ++m) {
      const BrickLayer layer = samples.read_layer(0, m, {}, bench.context);
      const Int3& n = layer.dims();
      EXPECT_EQ(layer.kept_sites(), int64_t{n[0]} * n[1] * n[2]);
      EXPECT_EQ(layer.value(0, 0, 0), -base);
      EXPECT_LT(std::fabs(layer.value(n[0] - 1, n[1] - 1, n[2] - 1)), 3.0f);
      samples.read_samples(0, std::span(&m, 1), {}, bench.context, [&](int32_t, SampleLayer&& read) {
        std::array<float, brick_sites> room;
        EXPECT_EQ(read.brick(0).all(room)[0], -base);
      });
    }
  }
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

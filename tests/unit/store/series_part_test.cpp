// SPDX-License-Identifier: Apache-2.0
// The parts of a series: who makes which layers, and what parts tell each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "formats/bcc4/part.h"
#include "store/part_report.h"
#include "store/series_part.h"

namespace bccsplat {
namespace {

PartInfo example() {
  PartInfo part;
  part.block = SeriesBlock::of_frames(3, 7), part.series = 0x1234;
  part.writes = {{5, 0, 1, PartWrite::chunks}, {6, 1, 1, PartWrite::chunks}, {9, 1, 2, 6}};
  part.statistics = {std::byte{1}, std::byte{2}};
  return part;
}

TEST(Bcc4Part, ComesBack) {
  ByteWriter out;
  write_part(out, example());
  ByteReader in(out.bytes(), "part");
  EXPECT_EQ(read_part(in, 9, 2, 1), example());
  in.expect_end();
}

TEST(Bcc4Part, CutShortOrWrongIsRefused) {
  ByteWriter out;
  write_part(out, example());
  for (size_t n = 0; n < out.size(); ++n) {
    ByteReader in(out.bytes().first(n), "part");
    EXPECT_THROW(static_cast<void>(read_part(in, 9, 2, 1)), Error) << n << " bytes";
  }
  const auto refused = [](const PartInfo& part, uint32_t frames, size_t channels) {
    ByteWriter bytes;
    write_part(bytes, part);
    ByteReader in(bytes.bytes(), "part");
    EXPECT_THROW(static_cast<void>(read_part(in, frames, channels, 1)), Error);
  };
  refused(example(), 6, 2); // end beyond the series
  refused(example(), 8, 2); // a trigger beyond its end
  refused(example(), 9, 1); // no such channel
  PartInfo part = example();
  part.block.end[3] = part.block.begin[3];
  refused(part, 9, 2);
  part = example();
  part.writes[0].slab = -1;
  refused(part, 9, 2);
  part = example();
  part.writes[2].frame = 9;
  refused(part, 9, 2);
}

TEST(Bcc4Part, BlocksComeBackOrAreRefused) {
  constexpr std::array<uint32_t, 4> dims{20, 30, 40, 9};
  PartInfo block = example();
  block.block = {{3, 0, 7, 3}, {20, 30, 8, 7}};
  ByteWriter out;
  write_block(out, block);
  ByteReader in(out.bytes(), "block");
  EXPECT_EQ(read_block(in, dims, 2, 1), block);
  in.expect_end();
  for (const SeriesBlock& wrong :
       {SeriesBlock{{3, 0, 7, 3}, {21, 30, 8, 7}}, SeriesBlock{{3, 0, 8, 3}, {20, 30, 8, 7}}}) {
    block.block = wrong;
    ByteWriter bytes;
    write_block(bytes, block);
    ByteReader again(bytes.bytes(), "block");
    EXPECT_THROW(static_cast<void>(read_block(again, dims, 2, 1)), Error);
  }
}

// Borders at every frame: slabs and layers of the parts tile those of the series, frames within reach are
// asked for.
TEST(SeriesPart, PartsTileTheSeries) {
  FitOptions options;
  options.dims = {20, 20, 20, 33};
  for (const double time_scale : {0.3, 1.0, 2.5})
    for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
      for (uint32_t border = 1; border < 33; ++border) {
        const Lattice4 lattice = Lattice4::fit(kind, options.dims, {1, 1, 1, time_scale});
        options.lattice = kind, options.scales[3] = time_scale;
        const SeriesPart a = part_of_series(lattice, options, {}, SeriesBlock::of_frames(0, border));
        const SeriesPart b = part_of_series(lattice, options, {}, SeriesBlock::of_frames(border, 33));
        EXPECT_EQ(a.first_slab, 0);
        EXPECT_EQ(a.end_slab, b.first_slab);
        EXPECT_EQ(b.end_slab, (lattice.layers() + 7) / 8);
        EXPECT_EQ(a.fit.end_own, b.fit.first_own) << border;
        EXPECT_EQ(b.fit.end_own, lattice.layers());
        EXPECT_EQ(a.fit.first_given, 0u);
        EXPECT_EQ(b.fit.end_given, 33u);
        if (a.first_slab < a.end_slab) {
          EXPECT_GE(a.fit.end_given, std::min(33.0, lattice.layer_frame(a.fit.end_own - 1) + 4));
          EXPECT_GE(lattice.layer_frame((a.end_slab - 1) * 8), 0);
          EXPECT_LT(lattice.layer_frame((a.end_slab - 1) * 8), border);
        }
      }
  const Lattice4 still = Lattice4::fit(LatticeKind::d4star, {9, 9, 9, 1});
  options.dims = {9, 9, 9, 1};
  const SeriesPart all = part_of_series(still, options, {}, SeriesBlock::of_frames(0, 1)); // of one frame
  EXPECT_EQ(all.fit.end_layer, still.layers());
  EXPECT_THROW(static_cast<void>(part_of_series(still, options, {}, SeriesBlock::of_frames(0, 2))), Error);
}

TEST(SeriesPart, ReportsComeBackAndAddUp) {
  const auto report = [](uint32_t first, double low) {
    PartReport r;
    r.psnr = 50;
    PartChannelReport& c = r.channels.emplace_back();
    c.fit.samples = SampleHistogram(quantiser_of_range(ValueType::u8, {0, 255}, 0));
    c.fit.source_range = {low, low + 2}, c.fit.any_finite = true;
    c.fit.frames = {{low, low + 1}, {low, low + 2}};
    c.fit.lasting.samples = c.fit.samples, c.fit.lasting.holes = first + 1;
    c.fit.sites_total = 10, c.fit.coding_rmse = low, c.fit.cc_relevant = 7;
    c.bound = .5;
    c.measured = {first, first + 1};
    c.errors.resize(2);
    c.errors[1].all.add(low);
    return r;
  };
  const std::vector<std::byte> bytes = write_part_report(report(0, 1));
  PartReport sum = read_part_report(bytes, 1);
  EXPECT_EQ(write_part_report(sum), bytes);
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_THROW(static_cast<void>(read_part_report(std::span(bytes).first(n), 1)), Error) << n << " bytes";
  add_part_report(sum, report(2, -3), {2, 0});
  const PartChannelReport& c = sum.channels[0];
  EXPECT_EQ(c.fit.source_range, (Range{-3, 3}));
  EXPECT_EQ(c.fit.frames.size(), 4u);
  EXPECT_EQ(c.fit.cc_relevant, 14u);
  EXPECT_EQ(c.fit.lasting.holes, 4u);
  EXPECT_NEAR(c.fit.coding_rmse, std::sqrt((1 + 9) / 2.0), 1e-12);
  EXPECT_EQ(c.measured, (std::vector<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(c.errors[3].all.largest, 3);
}

TEST(SeriesPart, ReportsOfBlocksOfTheSameFramesAddUp) {
  const auto report = [](const Range& frame, uint64_t clamped, uint32_t first_frame) {
    PartReport r;
    PartChannelReport& c = r.channels.emplace_back();
    c.fit.samples = SampleHistogram(quantiser_of_range(ValueType::u8, {0, 255}, 0));
    c.fit.lasting.samples = c.fit.samples;
    c.fit.frames = {frame, {0, 1}};
    c.fit.clamped_slabs = {clamped, 1};
    c.measured = {first_frame, first_frame + 1};
    c.errors.resize(2);
    c.errors[0].all.add(static_cast<double>(clamped)), c.errors[0].frame = first_frame;
    c.errors[0].voxel = {clamped, 0, 0};
    return r;
  };
  PartReport sum;
  add_part_report(sum, report(no_range, 2, 0), {0, 0});
  add_part_report(sum, report({-3, 5}, 4, 0), {0, 0});
  add_part_report(sum, report({7, 8}, 9, 2), {2, 2});
  const FitChannelReport& f = sum.channels[0].fit;
  EXPECT_EQ(f.frames, (std::vector<Range>{{-3, 5}, {0, 1}, {7, 8}, {0, 1}}));
  EXPECT_EQ(f.clamped_slabs, (std::vector<uint64_t>{6, 2, 9, 1}));
  const PartChannelReport& c = sum.channels[0];
  EXPECT_EQ(c.measured, (std::vector<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(c.errors[0].all.count, 2u);
  EXPECT_EQ(c.errors[0].all.squares.value(), 4 + 16);
  EXPECT_EQ(c.errors[0].voxel[0], 4u);
  EXPECT_EQ(c.errors[1].all.count, 0u);
  EXPECT_EQ(c.errors[2].all.largest, 9);
}

// In whatever order blocks are added: the first of equal differences is told.
TEST(SampleErrors, OfEqualDifferencesTheFirstIsTold) {
  const auto at = [](uint64_t frame, const std::array<uint64_t, 3>& voxel) {
    SampleErrors e;
    e.all.add(2), e.frame = frame, e.voxel = voxel;
    return e;
  };
  std::vector<SampleErrors> errors{at(1, {5, 5, 5}), at(0, {9, 0, 3}), at(0, {0, 1, 3}), at(0, {2, 0, 3})};
  for (size_t turn = 0; turn < errors.size(); ++turn) {
    std::rotate(errors.begin(), errors.begin() + 1, errors.end());
    SampleErrors sum;
    for (const SampleErrors& e : errors) sum.add(e);
    EXPECT_EQ(sum.frame, 0u);
    EXPECT_EQ(sum.voxel, (std::array<uint64_t, 3>{2, 0, 3}));
    EXPECT_EQ(sum.all.count, 4u);
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Errors of blocks of space: bounds are kept and differences measured of each block's own samples, and the
// joined file is that of one writer, its corrections and error records included.
#include <cmath>

#include "../support/emulated.h"
#include "block_series.h"

namespace host::block_series {
namespace {

// Blocks that cut the boxes of 64 samples that corrections are stored in.
std::array<std::vector<uint64_t>, 4> uneven_borders(const Asked& asked) {
  const auto& n = asked.dims;
  return {{{0, n[0] * 2 / 5, n[0]}, {0, 21, n[1]}, {0, n[2]}, {0, n[3]}}};
}

TEST(BlocksWithBound, GiveTheBytesOfOneWriter) {
  const Device device = make_device();
  const std::vector<Case> cases{
      {"bytes", [](Asked&) {}},
      {"u16 on a coarse lattice",
       [](Asked& a) { a.type = BCCSPLAT_TYPE_U16, a.options.scale = 1.4, a.options.time_scale = 1.7; }},
      {"floats", [](Asked& a) { a.type = BCCSPLAT_TYPE_F32, a.options.abs_error = .4; }},
      {"floats as bytes",
       [](Asked& a) {
         a.type = BCCSPLAT_TYPE_F32, a.channel.value_type = BCCSPLAT_TYPE_U8;
         a.channel.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE, a.channel.range[1] = 170;
       }},
      {"mirrors",
       [](Asked& a) {
         a.options.fixed_predictions = 0;
         a.options.ends = BCCSPLAT_ENDS_MIRROR, a.options.faces = BCCSPLAT_FACES_MIRROR;
       }},
      {"predicted",
       [](Asked& a) { a.options.ends = BCCSPLAT_ENDS_PREDICT, a.options.faces = BCCSPLAT_FACES_PREDICT_X; }},
      {"coarse Cartesian", [](Asked& a) { a.options.lattice = BCCSPLAT_LATTICE_CC, a.options.scale = 1.3; }},
      {"Cartesian, each row filtered",
       [](Asked& a) {
         a.options.lattice = BCCSPLAT_LATTICE_CC, a.options.recommended_kernel = "exact";
         a.options.scale = 1.2;
       }},
      {"a blob over a threshold", [](Asked& a) { a.waves = false, a.channel.air_threshold = 9; }},
      {"one frame", [](Asked& a) { a.dims[3] = 1; }},
      {"levels", [](Asked& a) { a.options.levels = 2; }},
      {"far from air", [](Asked& a) { a.channel.air = -5000, a.type = BCCSPLAT_TYPE_F32; }},
      {"another kernel", [](Asked& a) { a.options.recommended_kernel = "fine"; }},
      {"a bound and all else",
       [](Asked& a) { a.options.psnr = 20, a.options.measure = BCCSPLAT_MEASURE_ALL; }}};
  for (const Case& c : bccsplat::test::some(cases, 3)) {
    SCOPED_TRACE(c.name);
    const Folder folder;
    Asked asked;
    asked.dims = {70, 36, 40, 3}, asked.waves = true, asked.options.abs_error = 3;
    c.change(asked);
    const Written whole = expect_same(device, folder, asked, uneven_borders(asked));
    EXPECT_GT(whole.report.corrected, 1000u) << "else the bound tests nothing";
  }
}

// The field near a coast hangs on what continues the data over land.
TEST(BlocksWithBound, AndWithMissingData) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  asked.dims = {70, 36, 40, 3}, asked.waves = true, asked.options.abs_error = 0.4;
  asked.type = BCCSPLAT_TYPE_F32, asked.options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  asked.missing = [](double x, double y, double z, uint32_t t) {
    return std::sin(0.2 * x + 0.3 * t) + std::cos(0.17 * y) + std::sin(0.13 * z) > 0.7;
  };
  const Written whole = expect_same(device, folder, asked, uneven_borders(asked));
  EXPECT_GT(whole.report.corrected, 1000u);
}

TEST(BlocksThatMeasure, GiveTheBytesOfOneWriter) {
  const Device device = make_device();
  const std::vector<Case> cases{
      {"all", [](Asked& a) { a.options.measure = BCCSPLAT_MEASURE_ALL; }},
      {"all, with levels", [](Asked& a) { a.options.measure = BCCSPLAT_MEASURE_ALL, a.options.levels = 2; }},
      {"decibels", [](Asked& a) { a.options.psnr = 25; }},
      {"decibels, with levels", [](Asked& a) { a.options.psnr = 25, a.options.levels = 1; }},
      {"far from air", [](Asked& a) {
         a.options.measure = BCCSPLAT_MEASURE_ALL, a.type = BCCSPLAT_TYPE_F32, a.channel.air = -5000;
       }}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Folder folder;
    Asked asked;
    asked.dims = {70, 36, 40, 3}, asked.waves = true;
    c.change(asked);
    EXPECT_EQ(expect_same(device, folder, asked, uneven_borders(asked)).report.frames_measured, 3u);
  }
}

TEST(BlocksWithBound, OfFramesAndOfAnyShape) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  asked.dims = {70, 66, 40, 6}, asked.waves = true, asked.options.abs_error = 3;
  const Written whole = write(device, folder.file("whole.bcc4"), asked);
  Blocks blocks(device, folder, asked);
  // One of them, of two samples along x, has no brick of its own, and yet corrections.
  std::vector<Written> written;
  written.push_back(blocks.write_block({{{0, 0, 0}, {70, 66, 23}}}, 0, 4));
  written.push_back(blocks.write_block({{{0, 0, 23}, {70, 66, 40}}}, 0, 4));
  written.push_back(blocks.write_block({{{0, 0, 0}, {41, 66, 40}}}, 4, 6));
  written.push_back(blocks.write_block({{{41, 0, 0}, {43, 66, 40}}}, 4, 6));
  written.push_back(blocks.write_block({{{43, 0, 0}, {70, 50, 40}}}, 4, 6));
  written.push_back(blocks.write_block({{{43, 50, 0}, {70, 66, 40}}}, 4, 6));
  ASSERT_OK(blocks.join(folder.file("joined.bcc4")));
  EXPECT_TRUE(bytes_of(folder.file("joined.bcc4")) == bytes_of(folder.file("whole.bcc4")));
  uint64_t corrected = 0;
  for (const Written& w : written) {
    EXPECT_GT(w.report.corrected, 1000u);
    corrected += w.report.corrected;
  }
  EXPECT_EQ(corrected, whole.report.corrected);
  EXPECT_EQ(written.back().report.frames_measured, 2u);
}

// The field at the last sample of a block is a sum of sites that stand behind it.
TEST(BlocksWithBound, TakeTheSamplesThatTheirFieldIsMadeOf) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  asked.dims = {64, 40, 160, 3};
  const Box block{{{0, 0, 0}, {64, 40, 44}}};
  const auto end = [&](const Asked& a) {
    Blocks blocks(device, folder, a);
    return blocks.write_block(block, 0, 3).box[1][2];
  };
  const uint64_t without = end(asked);
  asked.options.abs_error = 2;
  const uint64_t with_bound = end(asked);
  EXPECT_GE(with_bound, without + 16) << "bricks of 16 sites beside those of the block";
  EXPECT_LE(with_bound, 44u + 3 * 23 + 16);
}

TEST(BlocksThatMeasure, TellTheErrorsOfTheirSamples) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  asked.dims = {64, 40, 36, 3}, asked.options.measure = BCCSPLAT_MEASURE_ALL;
  const std::vector<double> times{0, .5, 1};
  const auto error_of = [&](const Box& box, bool part) {
    auto p = sized<bccsplat_series_part>();
    p.end = 3, p.times = times.data();
    std::copy(box[0].begin(), box[0].end(), p.box_begin);
    std::copy(box[1].begin(), box[1].end(), p.box_end);
    bccsplat_writer_options o = asked.writer_options();
    if (part) o.part = &p;
    const Writer w = make_writer(device, folder.file("errors.bcc4"), o);
    Box given{};
    EXPECT_OK(bccsplat_writer_get_part_box(w.get(), given[0].data(), given[1].data()));
    for (uint32_t t = 0; t < 3; ++t) EXPECT_OK(add_box(w.get(), asked, given, t));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    auto error = sized<bccsplat_error_report>();
    EXPECT_OK(bccsplat_writer_get_error(w.get(), 0, -1, &error));
    return error;
  };
  const Box left{{{0, 0, 0}, {30, 40, 36}}}, right{{{30, 0, 0}, {64, 40, 36}}};
  const auto all = error_of({}, false), a = error_of(left, true), b = error_of(right, true);
  EXPECT_EQ(a.samples, 30u * 40 * 36 * 3);
  EXPECT_EQ(a.samples + b.samples, all.samples);
  EXPECT_LT(a.voxel[0], 30u);
  EXPECT_GE(b.voxel[0], 30u);
  const auto& worse = a.max_abs > b.max_abs ? a : b;
  EXPECT_EQ(worse.max_abs, all.max_abs);
  EXPECT_EQ(worse.voxel[0], all.voxel[0]);
  EXPECT_EQ(worse.voxel[2], all.voxel[2]);
  EXPECT_EQ(worse.frame, all.frame);
  const auto squares = [](const auto& e) { return e.rmse * e.rmse * static_cast<double>(e.samples); };
  EXPECT_NEAR(squares(a) + squares(b), squares(all), 1e-9 * squares(all));
}

// A block knows too little: the join tells what one writer would have told.
TEST(BlocksThatMeasure, DecibelsThatAreMissedAreToldByTheJoin) {
  const Device device = make_device();
  const Folder folder;
  Asked asked;
  asked.options.psnr = 60;
  bccsplat_writer_options o = asked.writer_options();
  const Writer w = make_writer(device, folder.file("whole.bcc4"), o);
  const Box all{{{0, 0, 0}, {64, 40, 36}}};
  for (uint32_t t = 0; t < 9; ++t) EXPECT_OK(add_box(w.get(), asked, all, t));
  EXPECT_EQ(bccsplat_writer_finish(w.get(), nullptr), BCCSPLAT_ERROR_BOUND_NOT_MET);
  const std::string told = bccsplat_last_error();
  EXPECT_NE(told.find("60 asked for"), std::string::npos) << told;
  Blocks blocks(device, folder, asked);
  blocks.write_all({{{0, 30, 64}, {0, 40}, {0, 20, 36}, {0, 9}}});
  EXPECT_EQ(blocks.join(folder.file("joined.bcc4")), BCCSPLAT_ERROR_BOUND_NOT_MET);
  EXPECT_EQ(bccsplat_last_error(), told);
  EXPECT_FALSE(std::filesystem::exists(folder.file("joined.bcc4")));
}

} // namespace
} // namespace host::block_series

// SPDX-License-Identifier: Apache-2.0
// Series that end sooner than the writer was told: the file is that of a writer which knew it, byte for byte
// where nothing that was settled before depends on the number.
#include <array>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

constexpr uint32_t told = 60;

double short_field(double x, double y, double z, double t) {
  return 20 + 9 * std::sin(0.4 * x + 0.3 * t) * std::cos(0.35 * y - 0.2 * z + 0.05 * t);
}

Source series(uint32_t frames, int32_t type = BCCSPLAT_TYPE_F32) {
  return source_of({18, 13, 11, frames}, type, short_field);
}

// Writes frames of a series with a writer that was told of `declared`.
Written write_short(const TestDevice& device, const Source& s, uint32_t declared,
                    const bccsplat_writer_options& options) {
  Written w;
  auto channel = sized<bccsplat_channel_options>();
  auto o = options;
  std::copy(s.dims.begin(), s.dims.end(), o.dims);
  o.dims[3] = declared, o.channels = &channel, o.channel_count = 1;
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = write_bytes, stream.user = &w.bytes;
  bccsplat_writer* writer = nullptr;
  w.status = bccsplat_writer_create_stream(device.device, &stream, &o, &writer);
  if (w.status == BCCSPLAT_OK) w.status = feed_frames(s, writer);
  if (w.status == BCCSPLAT_OK) w.status = bccsplat_writer_finish_short(writer, &w.report);
  if (w.status != BCCSPLAT_OK) w.text = bccsplat_last_error();
  if (w.report.frames_measured > 0) {
    EXPECT_EQ(bccsplat_writer_get_error(writer, 0, -1, &w.error), BCCSPLAT_OK);
  }
  bccsplat_writer_release(writer);
  return w;
}

// Nothing was written yet when the first frames are the last ones, too.
TEST(FinishShort, OfLevelsAfterAnyFrame) {
  const TestDevice device;
  auto options = sized<bccsplat_writer_options>();
  options.levels = 2;
  for (const uint32_t declared : {20u, told})
    for (uint32_t frames = 1; frames <= 9; ++frames) {
      const Written w = write_short(device, series(frames), declared, options);
      ASSERT_EQ(w.status, BCCSPLAT_OK) << frames << " of " << declared << ": " << w.text;
      const OpenVolume v(device, w.bytes);
      auto info = sized<bccsplat_volume_info>();
      ASSERT_EQ(bccsplat_volume_get_info(v.volume, &info), BCCSPLAT_OK) << bccsplat_last_error();
      EXPECT_EQ(info.dims[3], frames);
      ASSERT_EQ(info.level_count, 2u);
      for (uint32_t level = 0; level <= 2; ++level) {
        auto o = sized<bccsplat_slice_options>();
        o.level = level;
        const std::vector<float> values = Cut(v, {0, 0, 0, 1, -(frames - 1.0)}, o).samples();
        ASSERT_FALSE(values.empty());
        for (const float value : values) ASSERT_NEAR(value, 20, 15) << frames << ", level " << level;
      }
    }
}

// The same chunks, be it in another order, and the same at every moment.
void expect_same_content(const TestDevice& device, const Written& knew, const Written& ended,
                         uint32_t levels) {
  EXPECT_EQ(ended.report.bytes_values, knew.report.bytes_values);
  EXPECT_EQ(ended.report.bytes_runs, knew.report.bytes_runs);
  EXPECT_EQ(ended.report.sites_kept, knew.report.sites_kept);
  const OpenVolume a(device, knew.bytes), b(device, ended.bytes);
  ASSERT_EQ(b.status, BCCSPLAT_OK) << bccsplat_last_error();
  auto info = sized<bccsplat_volume_info>();
  ASSERT_EQ(bccsplat_volume_get_info(b.volume, &info), BCCSPLAT_OK);
  const double last = static_cast<double>(info.dims[3]) - 1;
  for (uint32_t c = 0; c < info.channel_count; ++c)
    for (uint32_t level = 0; level <= levels; ++level)
      for (const double t : {0.0, 7.3, last - 3.5, last - 0.7, last}) {
        auto o = sized<bccsplat_slice_options>();
        o.level = level, o.channel = c;
        EXPECT_EQ(Cut(a, {0, 0, 0, 1, -t}, o).samples(), Cut(b, {0, 0, 0, 1, -t}, o).samples()) << t;
      }
}

struct ShortVariant {
  const char* name;
  int32_t type;
  bool bytes; // the same, else what is seen is the same
  bccsplat_writer_options options;
};

std::vector<ShortVariant> short_variants() {
  std::vector<ShortVariant> list;
  const auto add = [&](const char* name, int32_t type, bool bytes, const auto& change) {
    auto o = sized<bccsplat_writer_options>();
    change(o);
    list.push_back({name, type, bytes, o});
  };
  add("plain", BCCSPLAT_TYPE_F32, true, [](bccsplat_writer_options&) {});
  add("bytes", BCCSPLAT_TYPE_U8, true, [](bccsplat_writer_options&) {});
  add("mirror", BCCSPLAT_TYPE_F32, true, [](bccsplat_writer_options& o) { o.ends = BCCSPLAT_ENDS_MIRROR; });
  add("levels", BCCSPLAT_TYPE_F32, false, [](bccsplat_writer_options& o) { o.levels = 2; });
  add("bound", BCCSPLAT_TYPE_F32, true, [](bccsplat_writer_options& o) { o.abs_error = 0.05; });
  add("psnr", BCCSPLAT_TYPE_U8, true, [](bccsplat_writer_options& o) { o.psnr = 20; });
  add("low-pass", BCCSPLAT_TYPE_F32, true, [](bccsplat_writer_options& o) { o.lowpass = 1; });
  add("Cartesian", BCCSPLAT_TYPE_F32, true,
      [](bccsplat_writer_options& o) { o.lattice = BCCSPLAT_LATTICE_CC; });
  add("wide in time", BCCSPLAT_TYPE_F32, true,
      [](bccsplat_writer_options& o) { o.time_scale = 1.3, o.ends = BCCSPLAT_ENDS_PREDICT; });
  return list;
}

TEST(FinishShort, IsTheFileOfAWriterThatKnew) {
  const TestDevice device;
  for (const ShortVariant& v : short_variants())
    for (const uint32_t frames : {23u, 31u, 59u, told}) {
      SCOPED_TRACE(testing::Message() << v.name << ", " << frames << " frames");
      const Source s = series(frames, v.type);
      const Written knew = write_frames(device, s, v.options);
      const Written ended = write_short(device, s, told, v.options);
      ASSERT_EQ(knew.status, BCCSPLAT_OK) << knew.text;
      ASSERT_EQ(ended.status, BCCSPLAT_OK) << ended.text;
      EXPECT_EQ(ended.report.frames, frames);
      EXPECT_EQ(ended.report.frames_measured, knew.report.frames_measured);
      EXPECT_EQ(ended.error.max_abs, knew.error.max_abs);
      EXPECT_EQ(ended.error.rmse, knew.error.rmse);
      if (v.bytes || frames == told) {
        EXPECT_EQ(ended.bytes, knew.bytes);
        continue;
      }
      expect_same_content(device, knew, ended, v.options.levels);
    }
}

// Frames that waited for layers which do not come are compared, and corrected, too.
TEST(FinishShort, BoundsHoldWhereASlabEndsWithTheSeries) {
  const TestDevice device;
  const struct {
    int32_t store, type;
    double bound;
  } ways[] = {{BCCSPLAT_STORE_SAMPLES, BCCSPLAT_TYPE_F32, 0.05},
              {BCCSPLAT_STORE_WAVELETS, BCCSPLAT_TYPE_U8, 1}};
  for (const auto& way : ways)
    for (const uint32_t frames : {8u, 16u, 32u}) {
      SCOPED_TRACE(testing::Message() << way.store << ", " << frames << " frames");
      auto o = sized<bccsplat_writer_options>();
      o.lattice = BCCSPLAT_LATTICE_CC, o.scale = 1.3, o.time_scale = 1, o.store = way.store;
      o.abs_error = way.bound, o.measure = BCCSPLAT_MEASURE_ALL;
      const Source s = series(frames, way.type);
      const Written knew = write_frames(device, s, o), ended = write_short(device, s, told, o);
      ASSERT_EQ(knew.status, BCCSPLAT_OK) << knew.text;
      ASSERT_EQ(ended.status, BCCSPLAT_OK) << ended.text;
      EXPECT_EQ(ended.report.frames_measured, frames);
      EXPECT_GT(ended.report.corrected, 0u) << "else the bound tests nothing";
      EXPECT_EQ(ended.report.corrected, knew.report.corrected);
      EXPECT_EQ(ended.error.max_abs, knew.error.max_abs);
      EXPECT_EQ(ended.error.rmse, knew.error.rmse);
      const OpenVolume v(device, ended.bytes);
      EXPECT_LE(largest_error(v, s).slices, way.bound * 1.001);
    }
}

// The layers before the first frame are those of the number that was told; what is seen is no worse for it.
TEST(FinishShort, OfFewFramesIsAsAccurate) {
  const TestDevice device;
  const auto o = sized<bccsplat_writer_options>();
  for (const uint32_t frames : {1u, 2u, 3u, 5u, 9u, 13u}) {
    SCOPED_TRACE(frames);
    const Source s = series(frames);
    const Written knew = write_frames(device, s, o), ended = write_short(device, s, told, o);
    ASSERT_EQ(ended.status, BCCSPLAT_OK) << ended.text;
    const OpenVolume a(device, knew.bytes), b(device, ended.bytes);
    const double before = largest_error(a, s).slices, after = largest_error(b, s).slices;
    EXPECT_LE(after, 1.1 * before + 1e-6);
    EXPECT_EQ(largest_error(b, s).slices, largest_error(b, s).slices); // a number
    auto info = sized<bccsplat_volume_info>();
    ASSERT_EQ(bccsplat_volume_get_info(b.volume, &info), BCCSPLAT_OK);
    EXPECT_EQ(info.dims[3], frames);
    EXPECT_EQ(info.time_last, frames - 1.0);
    EXPECT_EQ(frames == 1, info.lattice == BCCSPLAT_LATTICE_BCC);
  }
}

TEST(FinishShort, OneFrameIsAFileOfOne) {
  const TestDevice device;
  for (const double bound : {0.0, 0.01}) {
    auto o = sized<bccsplat_writer_options>();
    o.abs_error = bound;
    const Source s = series(1);
    const Written knew = write_frames(device, s, o), ended = write_short(device, s, told, o);
    ASSERT_EQ(knew.status, BCCSPLAT_OK) << knew.text;
    ASSERT_EQ(ended.status, BCCSPLAT_OK) << ended.text;
    EXPECT_EQ(ended.bytes, knew.bytes);
  }
}

// A writer of layers; gives so many of them.
Written write_layers(const TestDevice& device, uint32_t declared, int64_t count, bool ends_short) {
  Written w;
  auto o = sized<bccsplat_writer_options>();
  o.dims[0] = 14, o.dims[1] = 13, o.dims[2] = 12, o.dims[3] = declared;
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = write_bytes, stream.user = &w.bytes;
  bccsplat_writer* writer = nullptr;
  EXPECT_EQ(bccsplat_writer_create_stream(device.device, &stream, &o, &writer), BCCSPLAT_OK);
  auto g = sized<bccsplat_layer_geometry>();
  EXPECT_EQ(bccsplat_writer_get_layer_geometry(writer, 0, &g), BCCSPLAT_OK);
  if (count < 0) count = g.layer_count;
  for (int64_t m = 0; m < count; ++m) {
    EXPECT_EQ(bccsplat_writer_get_layer_geometry(writer, m, &g), BCCSPLAT_OK);
    std::vector<float> values;
    for (int64_t z = 0; z < g.dims[2]; ++z)
      for (int64_t y = 0; y < g.dims[1]; ++y)
        for (int64_t x = 0; x < g.dims[0]; ++x)
          values.push_back(
              static_cast<float>(short_field(g.origin[0] + g.step[0] * static_cast<double>(x),
                                             g.origin[1] + g.step[1] * static_cast<double>(y),
                                             g.origin[2] + g.step[2] * static_cast<double>(z), g.frame)));
    EXPECT_EQ(bccsplat_writer_add_layer(writer, 0, m, values.data(), values.size()), BCCSPLAT_OK);
  }
  w.status = ends_short ? bccsplat_writer_finish_short(writer, &w.report)
                        : bccsplat_writer_finish(writer, &w.report);
  if (w.status != BCCSPLAT_OK) w.text = bccsplat_last_error();
  bccsplat_writer_release(writer);
  return w;
}

TEST(FinishShort, OfLayersEndsWithTheFramesTheyReach) {
  const TestDevice device;
  // Layers stand sqrt(1/2) frames apart: those of 11 frames are 0 .. 15, and frame 10 needs the last of them.
  const Written knew = write_layers(device, 11, -1, false), ended = write_layers(device, 40, 16, true);
  ASSERT_EQ(ended.status, BCCSPLAT_OK) << ended.text;
  EXPECT_EQ(ended.bytes, knew.bytes);
  const Written fewer = write_layers(device, 40, 15, true);
  ASSERT_EQ(fewer.status, BCCSPLAT_OK) << fewer.text;
  EXPECT_EQ(fewer.report.frames, 10u);
  const Written one = write_layers(device, 40, 2, true);
  EXPECT_EQ(one.status, BCCSPLAT_ERROR_WRONG_STATE);
  EXPECT_NE(one.text.find("one frame alone"), std::string::npos) << one.text;
  EXPECT_EQ(write_layers(device, 11, -1, true).bytes, knew.bytes);
}

// What cannot end yet goes on.
TEST(FinishShort, ChannelsHaveTheSameFrames) {
  const TestDevice device;
  std::array<bccsplat_channel_options, 2> channels{sized<bccsplat_channel_options>(),
                                                   sized<bccsplat_channel_options>()};
  channels[0].name = "a", channels[1].name = "b";
  const Source s = series(30);
  const auto write = [&](uint32_t declared, bool ends_short) {
    Written w;
    auto o = sized<bccsplat_writer_options>();
    std::copy(s.dims.begin(), s.dims.end(), o.dims);
    o.dims[3] = declared, o.channels = channels.data(), o.channel_count = 2;
    auto stream = sized<bccsplat_write_stream>();
    stream.write_at = write_bytes, stream.user = &w.bytes;
    bccsplat_writer* writer = nullptr;
    EXPECT_EQ(bccsplat_writer_create_stream(device.device, &stream, &o, &writer), BCCSPLAT_OK);
    for (uint32_t t = 0; t < 30; ++t)
      for (const uint32_t c : {0u, 1u}) {
        const Bytes data = frame_bytes(s, t);
        auto box = sized<bccsplat_box>();
        box.type = s.type, box.data = data.data();
        for (size_t a = 0; a < 3; ++a) box.dims[a] = s.dims[a];
        EXPECT_EQ(bccsplat_writer_add_frame(writer, c, t, &box, 1), BCCSPLAT_OK);
        if (!ends_short || c == 1) continue;
        EXPECT_EQ(bccsplat_writer_finish_short(writer, nullptr), BCCSPLAT_ERROR_WRONG_STATE);
        EXPECT_NE(std::string(bccsplat_last_error()).find("channel 1 was given"), std::string::npos);
      }
    EXPECT_EQ(ends_short ? bccsplat_writer_finish_short(writer, &w.report)
                         : bccsplat_writer_finish(writer, &w.report),
              BCCSPLAT_OK)
        << bccsplat_last_error();
    bccsplat_writer_release(writer);
    return w;
  };
  expect_same_content(device, write(30, false), write(50, true), 0);
}

TEST(FinishShort, IsNotForParts) {
  const TestDevice device;
  const Source s = series(40);
  std::vector<double> times;
  for (int t = 0; t < 40; ++t) times.push_back(t);
  auto part = sized<bccsplat_series_part>();
  part.first = 0, part.end = 20, part.times = times.data();
  auto o = sized<bccsplat_writer_options>();
  std::copy(s.dims.begin(), s.dims.end(), o.dims);
  o.part = &part;
  Bytes bytes;
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = write_bytes, stream.user = &bytes;
  bccsplat_writer* writer = nullptr;
  ASSERT_EQ(bccsplat_writer_create_stream(device.device, &stream, &o, &writer), BCCSPLAT_OK);
  ASSERT_EQ(bccsplat_writer_add_frame(writer, 0, 0, nullptr, 0), BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_writer_finish_short(writer, nullptr), BCCSPLAT_ERROR_UNSUPPORTED);
  // With all of its frames it is finish, though the series goes on behind them.
  uint64_t begin = 0, end = 0;
  ASSERT_EQ(bccsplat_writer_get_part_frames(writer, &begin, &end), BCCSPLAT_OK);
  ASSERT_LT(end, 40u);
  for (uint64_t t = begin + 1; t < end; ++t)
    ASSERT_EQ(bccsplat_writer_add_frame(writer, 0, static_cast<double>(t), nullptr, 0), BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_writer_finish_short(writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
  bccsplat_writer_release(writer);
}

} // namespace
} // namespace bccsplat::test

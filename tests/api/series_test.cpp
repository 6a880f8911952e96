// SPDX-License-Identifier: Apache-2.0
// A series through the whole ABI: frames -> file -> volume -> slices and values.
#include <cstring>
#include <fstream>
#include <limits>

#include "support.h"

using namespace host;

namespace {

std::vector<char> read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Series, ComesBackFromTheFile) {
  const Folder folder;
  const Device device = make_device();
  const Series series;
  const auto report = write_series(device, folder.file("s.bcc4"), series);
  EXPECT_EQ(report.frames, series.nt);
  EXPECT_EQ(report.cc_samples, 20u * 19 * 18 * 8);
  EXPECT_LE(report.sites_kept, report.sites_total);
  EXPECT_EQ(report.bytes_file, std::filesystem::file_size(folder.file("s.bcc4")));

  const Volume volume = open(device, folder.file("s.bcc4"));
  auto info = sized<bccsplat_volume_info>();
  ASSERT_OK(bccsplat_volume_get_info(volume.get(), &info));
  EXPECT_EQ(info.dims[0], 20u);
  EXPECT_EQ(info.dims[3], 8u);
  EXPECT_EQ(info.lattice, BCCSPLAT_LATTICE_D4STAR);
  EXPECT_EQ(info.sites_total, report.sites_total);
  EXPECT_STREQ(info.kernel, "radial20+b3");
  EXPECT_EQ(info.time_uniform, 1);

  for (const double frame : {0.0, 2.0, 3.4, 7.0}) {
    const Slice slice = cut_time(volume, frame);
    auto about = sized<bccsplat_slice_info>();
    ASSERT_OK(bccsplat_slice_get_info(slice.get(), &about));
    ASSERT_EQ(about.dims[0] * about.dims[1] * about.dims[2], 20u * 19 * 18);
    std::vector<float> dense(20 * 19 * 18);
    ASSERT_OK(bccsplat_slice_sample_grid(slice.get(), nullptr, dense.data()));
    double error = 0;
    size_t i = 0;
    std::vector<double> points;
    for (int z = 0; z < 18; ++z)
      for (int y = 0; y < 19; ++y)
        for (int x = 0; x < 20; ++x, ++i) {
          error += std::pow(dense[i] - blob(x, y, z, frame), 2);
          for (const double c : {double(x), double(y), double(z), frame}) points.push_back(c);
          EXPECT_GE(dense[i], about.bounds[0]);
          EXPECT_LE(dense[i], about.bounds[1]);
        }
    // 60 dB of the range inside the series; at its ends the field's mirror image has a crease.
    EXPECT_LT(std::sqrt(error / static_cast<double>(i)), frame > 1 && frame < 6 ? 0.1 : 0.3)
        << "frame " << frame;
    std::vector<float> values(i);
    ASSERT_OK(bccsplat_volume_evaluate(volume.get(), i, points.data(), values.data(), nullptr));
    for (size_t k = 0; k < i; ++k) ASSERT_NEAR(values[k], dense[k], 1e-3);
  }
}

TEST(Series, SameFileFromAnyThreadCountAndAnyBoxes) {
  const Folder folder;
  const Series series;
  for (const int threads : {1, 4})
    (void)write_series(make_device(threads), folder.file("t" + std::to_string(threads) + ".bcc4"), series);
  const auto one = read_file(folder.file("t1.bcc4"));
  EXPECT_GT(one.size(), 1000u);
  EXPECT_EQ(one, read_file(folder.file("t4.bcc4")));

  // Four strided sub-boxes of a padded array are the same frame.
  const Device device = make_device();
  const Writer w = make_writer(device, folder.file("boxes.bcc4"), options_of(series));
  const size_t px = 24, py = 21;
  std::vector<float> padded(px * py * 18, -1e30f);
  for (uint32_t t = 0; t < series.nt; ++t) {
    for (uint32_t z = 0; z < 18; ++z)
      for (uint32_t y = 0; y < 19; ++y)
        for (uint32_t x = 0; x < 20; ++x)
          padded[(z * py + y) * px + x] = static_cast<float>(blob(x, y, z, t));
    std::vector<bccsplat_box> boxes;
    for (const int64_t bx : {0, 7})
      for (const int64_t by : {0, 11}) {
        auto b = sized<bccsplat_box>();
        b.type = BCCSPLAT_TYPE_F32;
        b.begin[0] = bx, b.begin[1] = by;
        b.dims[0] = bx ? 13 : 7, b.dims[1] = by ? 8 : 11, b.dims[2] = 18;
        b.data = padded.data() + by * px + bx;
        b.stride_bytes[0] = 4, b.stride_bytes[1] = 4 * px, b.stride_bytes[2] = 4 * px * py;
        boxes.push_back(b);
      }
    ASSERT_OK(bccsplat_writer_add_frame(w.get(), 0, t, boxes.data(), boxes.size()));
  }
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  EXPECT_EQ(one, read_file(folder.file("boxes.bcc4")));
}

TEST(Series, UnknownFrameCountGivesTheSameFile) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("known.bcc4"));
  auto o = options_of({});
  o.dims[3] = 0;
  const Writer w = make_writer(device, folder.file("unknown.bcc4"), o);
  ASSERT_OK(add_frames(w.get(), {}));
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  EXPECT_EQ(read_file(folder.file("known.bcc4")), read_file(folder.file("unknown.bcc4")));
}

TEST(Series, OpensFromMemoryAndFromAStream) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  const auto bytes = read_file(folder.file("s.bcc4"));
  bccsplat_volume* v = nullptr;
  ASSERT_OK(bccsplat_volume_open_memory(device.get(), bytes.data(), bytes.size(), nullptr, &v));
  const Volume memory(v);
  auto stream = sized<bccsplat_read_stream>();
  stream.size = bytes.size();
  stream.user = const_cast<char*>(bytes.data());
  stream.read_at = [](void* user, uint64_t offset, void* buffer, uint64_t size) {
    std::memcpy(buffer, static_cast<const char*>(user) + offset, size);
    return static_cast<int64_t>(size);
  };
  ASSERT_OK(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v));
  const Volume streamed(v);
  const double point[4] = {8.5, 10, 9, 1.5};
  float a = 0, b = 1;
  ASSERT_OK(bccsplat_volume_evaluate(memory.get(), 1, point, &a, nullptr));
  ASSERT_OK(bccsplat_volume_evaluate(streamed.get(), 1, point, &b, nullptr));
  EXPECT_EQ(a, b);
  stream.read_at = [](void*, uint64_t, void*, uint64_t) { return int64_t{-1}; };
  EXPECT_EQ(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v), BCCSPLAT_ERROR_IO);
  EXPECT_EQ(v, nullptr);
}

TEST(Series, WritesIntoAStream) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  std::vector<char> bytes;
  auto stream = sized<bccsplat_write_stream>();
  stream.user = &bytes;
  stream.write_at = [](void* user, uint64_t offset, const void* buffer, uint64_t size) {
    auto& out = *static_cast<std::vector<char>*>(user);
    out.resize(std::max<size_t>(out.size(), offset + size));
    std::memcpy(out.data() + offset, buffer, size);
    return static_cast<int64_t>(size);
  };
  const auto o = options_of({});
  bccsplat_writer* w = nullptr;
  ASSERT_OK(bccsplat_writer_create_stream(device.get(), &stream, &o, &w));
  const Writer writer(w);
  ASSERT_OK(add_frames(w, {}));
  ASSERT_OK(bccsplat_writer_finish(w, nullptr));
  EXPECT_EQ(bytes, read_file(folder.file("s.bcc4")));
}

TEST(Series, LayersWrittenInSituMatchTheField) {
  const Folder folder;
  const Device device = make_device();
  Series s;
  s.nt = 16;
  const Writer w = make_writer(device, folder.file("s.bcc4"), options_of(s));
  ASSERT_OK(bccsplat_writer_set_times(w.get(), 10, 0.5));
  auto g = sized<bccsplat_layer_geometry>();
  ASSERT_OK(bccsplat_writer_get_layer_geometry(w.get(), 0, &g));
  for (int64_t layer = 0; layer < g.layer_count; ++layer) {
    ASSERT_OK(bccsplat_writer_get_layer_geometry(w.get(), layer, &g));
    std::vector<float> samples;
    for (int64_t k = 0; k < g.dims[2]; ++k)
      for (int64_t j = 0; j < g.dims[1]; ++j)
        for (int64_t i = 0; i < g.dims[0]; ++i)
          samples.push_back(
              static_cast<float>(blob(g.origin[0] + g.step[0] * static_cast<double>(i),
                                      g.origin[1] + g.step[1] * static_cast<double>(j),
                                      g.origin[2] + g.step[2] * static_cast<double>(k), g.frame)));
    ASSERT_OK(bccsplat_writer_add_layer(w.get(), 0, layer, samples.data(), samples.size()));
  }
  EXPECT_EQ(bccsplat_writer_add_layer(w.get(), 0, g.layer_count, nullptr, 0),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  const Volume volume = open(device, folder.file("s.bcc4"), "fine");
  double index = 0;
  ASSERT_OK(bccsplat_volume_time_to_index(volume.get(), 13.75, &index));
  EXPECT_DOUBLE_EQ(index, 7.5);
  const double point[4] = {11.3, 10.2, 8.1, index};
  float value = 0, gradient[4];
  ASSERT_OK(bccsplat_volume_evaluate(volume.get(), 1, point, &value, gradient));
  EXPECT_NEAR(value, blob(11.3, 10.2, 8.1, 7.5), 0.1);
  for (int a = 0; a < 4; ++a) {
    double low[4], high[4];
    std::copy(point, point + 4, low), std::copy(point, point + 4, high);
    low[a] -= 1e-4, high[a] += 1e-4;
    const double slope =
        (blob(high[0], high[1], high[2], high[3]) - blob(low[0], low[1], low[2], low[3])) / 2e-4;
    EXPECT_NEAR(gradient[a], slope, 0.25); // of 20 at most
  }
}

TEST(Series, UnevenTimesAndAttributes) {
  const Folder folder;
  const Device device = make_device();
  auto o = options_of({});
  o.dims[3] = 0;
  o.time_unit = "h";
  const Writer w = make_writer(device, folder.file("s.bcc4"), o);
  const std::vector<float> frame(20 * 19 * 18, 3.0f);
  auto box = sized<bccsplat_box>();
  box.type = BCCSPLAT_TYPE_F32, box.data = frame.data();
  box.dims[0] = 20, box.dims[1] = 19, box.dims[2] = 18;
  const std::vector<double> times{0, 6, 12, 24, 30, 36, 48};
  for (const double t : times) ASSERT_OK(bccsplat_writer_add_frame(w.get(), 0, t, &box, 1));
  ASSERT_OK(bccsplat_writer_set_attribute(w.get(), "model", "first"));
  ASSERT_OK(bccsplat_writer_set_attribute(w.get(), "model", "second"));
  ASSERT_OK(bccsplat_writer_add_source(w.get(), "forecast.nc", 123, 0));
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  const Volume volume = open(device, folder.file("s.bcc4"));
  std::vector<double> back(7);
  uint64_t count = 0;
  ASSERT_OK(bccsplat_volume_get_times(volume.get(), back.data(), 7, &count));
  EXPECT_EQ(count, 7u);
  EXPECT_EQ(back, times);
  for (size_t i = 0; i < 7; ++i) {
    double index = -1;
    ASSERT_OK(bccsplat_volume_time_to_index(volume.get(), times[i], &index));
    EXPECT_NEAR(index, static_cast<double>(i), 1e-9);
  }
  double last = -1;
  for (double t = 0; t <= 48; t += 0.25) { // monotone, and its own inverse
    double index = 0, again = 0;
    ASSERT_OK(bccsplat_volume_time_to_index(volume.get(), t, &index));
    ASSERT_OK(bccsplat_volume_index_to_time(volume.get(), index, &again));
    EXPECT_GT(index, last);
    EXPECT_NEAR(again, t, 1e-9);
    last = index;
  }
  const char* value = nullptr;
  ASSERT_OK(bccsplat_volume_find_attribute(volume.get(), "model", &value));
  EXPECT_STREQ(value, "second");
  EXPECT_EQ(bccsplat_volume_find_attribute(volume.get(), "none", &value), BCCSPLAT_ERROR_NOT_FOUND);
  double index = 7;
  EXPECT_EQ(bccsplat_volume_time_to_index(volume.get(), 48.1, &index), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_EQ(index, 7);
}

TEST(Series, TwoChannels) {
  const Folder folder;
  const Device device = make_device();
  bccsplat_channel_options channels[2] = {sized<bccsplat_channel_options>(),
                                          sized<bccsplat_channel_options>()};
  channels[0].name = "density", channels[1].name = "temperature";
  channels[1].air = 20, channels[1].set_mask = BCCSPLAT_CHANNEL_SET_AIR, channels[1].unit = "C";
  auto o = options_of({});
  o.channel_count = 2, o.channels = channels;
  const Writer w = make_writer(device, folder.file("s.bcc4"), o);
  Series warm;
  warm.field = [](double x, double y, double z, double t) { return 20 + blob(x, y, z, t) / 2; };
  // Channel by channel would need all frames of the first to wait: the order is frame by frame.
  std::vector<float> frame(20 * 19 * 18);
  for (uint32_t t = 0; t < 8; ++t)
    for (uint32_t c = 0; c < 2; ++c) {
      size_t i = 0;
      for (int z = 0; z < 18; ++z)
        for (int y = 0; y < 19; ++y)
          for (int x = 0; x < 20; ++x)
            frame[i++] = static_cast<float>(c ? warm.field(x, y, z, t) : blob(x, y, z, t));
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32, box.data = frame.data();
      box.dims[0] = 20, box.dims[1] = 19, box.dims[2] = 18;
      ASSERT_OK(bccsplat_writer_add_frame(w.get(), c, t, &box, 1));
    }
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  const Volume volume = open(device, folder.file("s.bcc4"));
  uint32_t channel = 9;
  ASSERT_OK(bccsplat_volume_find_channel(volume.get(), "temperature", &channel));
  EXPECT_EQ(channel, 1u);
  auto info = sized<bccsplat_channel_info>();
  ASSERT_OK(bccsplat_volume_get_channel_info(volume.get(), 1, &info));
  EXPECT_EQ(info.air, 20);
  EXPECT_STREQ(info.unit, "C");
  const double point[4] = {9, 10, 9, 2};
  float value = 0;
  ASSERT_OK(bccsplat_volume_evaluate_channel(volume.get(), 1, 1, point, &value, nullptr));
  EXPECT_NEAR(value, 20 + blob(9, 10, 9, 2) / 2, 0.1);
  EXPECT_EQ(bccsplat_volume_evaluate_channel(volume.get(), 2, 1, point, &value, nullptr),
            BCCSPLAT_ERROR_NOT_FOUND);
}

TEST(Series, NonFiniteValues) {
  const Folder folder;
  const Device device = make_device();
  Series s;
  s.field = [](double x, double y, double z, double t) {
    const bool missing =
        std::fabs(x - 5) < 2 && std::fabs(y - 6) < 2 && std::fabs(z - 7) < 2 && std::fabs(t - 3) < 2;
    return missing ? std::numeric_limits<double>::quiet_NaN() : blob(x, y, z, t);
  };
  {
    const Writer w = make_writer(device, folder.file("error.bcc4"), options_of(s));
    EXPECT_EQ(add_frames(w.get(), s), BCCSPLAT_ERROR_NONFINITE_VALUE);
    const std::string text = bccsplat_last_error();
    EXPECT_NE(text.find("frame 2"), std::string::npos) << text;
    EXPECT_NE(text.find("4, 5, 6"), std::string::npos) << text; // the first voxel
    EXPECT_EQ(bccsplat_writer_finish(w.get(), nullptr), BCCSPLAT_ERROR_WRONG_STATE);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));

  auto o = options_of(s);
  o.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  const Writer w = make_writer(device, folder.file("hole.bcc4"), o);
  ASSERT_OK(add_frames(w.get(), s));
  auto report = sized<bccsplat_writer_report>();
  ASSERT_OK(bccsplat_writer_finish(w.get(), &report));
  EXPECT_EQ(report.nonfinite, 81u);
  EXPECT_EQ(report.holes, 0u); // a mask of the source's samples tells
  const Volume volume = open(device, folder.file("hole.bcc4"));
  const double points[8] = {5, 6, 7, 3, 11, 6, 7, 3};
  float values[2] = {0, 0};
  EXPECT_EQ(bccsplat_volume_evaluate(volume.get(), 2, points, values, nullptr), BCCSPLAT_ERROR_HOLE);
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_NEAR(values[1], blob(11, 6, 7, 3), 0.5);
}

TEST(Series, OneFrameIsAStaticVolume) {
  const Folder folder;
  const Device device = make_device();
  Series s;
  s.nt = 1;
  const auto report = write_series(device, folder.file("s.bcc4"), s);
  const Volume volume = open(device, folder.file("s.bcc4"));
  auto info = sized<bccsplat_volume_info>();
  ASSERT_OK(bccsplat_volume_get_info(volume.get(), &info));
  EXPECT_EQ(info.lattice, BCCSPLAT_LATTICE_BCC);
  EXPECT_NEAR(static_cast<double>(report.sites_total) / static_cast<double>(report.cc_samples), 0.707, 0.1);
  const double point[4] = {8.2, 9.7, 9.1, 0};
  float value = 0;
  ASSERT_OK(bccsplat_volume_evaluate(volume.get(), 1, point, &value, nullptr));
  EXPECT_NEAR(value, blob(8.2, 9.7, 9.1, 0), 0.1);
}

TEST(Series, AxisSliceShowsChangeOverTime) {
  const Folder folder;
  const Device device = make_device();
  (void)write_series(device, folder.file("s.bcc4"));
  const Volume volume = open(device, folder.file("s.bcc4"));
  const Slice slice = cut(volume, 1, 0, 0, 0, -9.5); // x = 9.5: (u, v, w) = (y, z, t)
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(slice.get(), &info));
  EXPECT_EQ(info.dims[0], 19u);
  EXPECT_EQ(info.dims[1], 18u);
  EXPECT_EQ(info.dims[2], 8u);
  const double at[3] = {10.5, 8.5, 3.5};
  float value = 0;
  ASSERT_OK(bccsplat_slice_evaluate(slice.get(), 1, at, &value, nullptr));
  EXPECT_NEAR(value, blob(9.5, 10.5, 8.5, 3.5), 0.3);
}

TEST(Series, VerifyFindsEveryDamagedByte) {
  const Folder folder;
  const Device device = make_device();
  Series s;
  s.nx = s.ny = s.nz = 9, s.nt = 3;
  (void)write_series(device, folder.file("s.bcc4"), s);
  const auto bytes = read_file(folder.file("s.bcc4"));
  for (size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 200) {
    auto damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    bccsplat_volume* v = nullptr;
    if (bccsplat_volume_open_memory(device.get(), damaged.data(), damaged.size(), nullptr, &v) != BCCSPLAT_OK)
      continue;
    const Volume volume(v);
    auto report = sized<bccsplat_verify_report>();
    ASSERT_OK(bccsplat_volume_verify(v, nullptr, nullptr, &report));
    EXPECT_GT(report.damages, 0u) << "byte " << at;
  }
}

} // namespace

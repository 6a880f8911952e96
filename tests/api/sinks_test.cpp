// SPDX-License-Identifier: Apache-2.0
// Files written through streams of a host: the bytes are those of files, and streams that fail end the call
// that they failed in.
#include <array>
#include <fstream>

#include "host_streams.h"

namespace host {
namespace {

struct Kind {
  const char* name;
  bccsplat_writer_options options;
  NoiseSeries series;
};

[[nodiscard]] std::vector<Kind> kinds() {
  std::vector<Kind> list;
  const auto add = [&](const char* name, const auto& change) {
    Kind k{name, {}, {}};
    k.series.nx = 36, k.series.ny = 20, k.series.nz = 18;
    k.options = k.series.options();
    change(k);
    list.push_back(k);
  };
  add("samples", [](Kind&) {});
  add("levels", [](Kind& k) { k.options.levels = 2; });
  add("corrections", [](Kind& k) { k.options.abs_error = 3; });
  add("masks", [](Kind& k) {
    k.series.holes = true;
    k.options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  });
  add("length unknown", [](Kind& k) { k.options.dims[3] = 0; });
  add("live", [](Kind& k) { k.options.live = 1; });
  add("periodic", [](Kind& k) { k.options.ends = BCCSPLAT_ENDS_PERIODIC; });
  add("static", [](Kind& k) { k.series.nt = 1, k.options.dims[3] = 1; });
  return list;
}

bccsplat_status add_all(const NoiseSeries& series, bccsplat_writer* w) {
  for (uint32_t t = 0; t < series.nt; ++t) {
    const std::vector<float> values = series.frame(t);
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
    box.dims[0] = series.nx, box.dims[1] = series.ny, box.dims[2] = series.nz;
    if (const auto status = bccsplat_writer_add_frame(w, 0, t, &box, 1); status != BCCSPLAT_OK) return status;
  }
  return BCCSPLAT_OK;
}

// The status of the call that ended a writer into a stream, or of its finish.
bccsplat_status write(const Device& device, const Kind& kind, Sink& sink,
                      bccsplat_writer_report* report = nullptr) {
  const auto channel = NoiseSeries::bytes_channel();
  bccsplat_writer_options o = kind.options;
  o.channels = &channel, o.channel_count = 1;
  const bccsplat_write_stream stream = sink.stream();
  bccsplat_writer* w = nullptr;
  EXPECT_OK(bccsplat_writer_create_stream(device.get(), &stream, &o, &w));
  const Writer writer(w);
  if (const auto status = add_all(kind.series, w); status != BCCSPLAT_OK) {
    const std::string said = bccsplat_last_error();
    EXPECT_NE(said.find("stream"), std::string::npos) << said;
    EXPECT_EQ(bccsplat_writer_finish(w, nullptr), BCCSPLAT_ERROR_WRONG_STATE) << "it has ended";
    return status;
  }
  return bccsplat_writer_finish(w, report);
}

TEST(WriteStreams, GetTheBytesOfFiles) {
  const Folder folder;
  const Device device = make_device();
  for (const Kind& kind : kinds()) {
    SCOPED_TRACE(kind.name);
    const auto channel = NoiseSeries::bytes_channel();
    bccsplat_writer_options o = kind.options;
    o.channels = &channel, o.channel_count = 1, o.overwrite = 1;
    const Writer w = make_writer(device, folder.file("named"), o);
    ASSERT_OK(add_all(kind.series, w.get()));
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
    Sink sink;
    auto report = sized<bccsplat_writer_report>();
    ASSERT_EQ(write(device, kind, sink, &report), BCCSPLAT_OK) << bccsplat_last_error();
    EXPECT_EQ(sink.bytes, file_bytes(folder.file("named")));
    EXPECT_EQ(report.bytes_file, sink.bytes.size());
    EXPECT_GE(sink.flushes, 2u) << "before and behind what makes it a file";
  }
}

TEST(WriteStreams, ThatFailEndTheWriter) {
  const Device device = make_device(1);
  for (Kind kind : kinds()) {
    SCOPED_TRACE(kind.name);
    kind.series.nx = 10, kind.series.ny = 9, kind.series.nz = 8;
    for (size_t a = 0; a < 3; ++a)
      kind.options.dims[a] = std::array{kind.series.nx, kind.series.ny, kind.series.nz}[a];
    kind.options.levels = std::min(kind.options.levels, 1u);
    Sink whole;
    ASSERT_EQ(write(device, kind, whole), BCCSPLAT_OK) << bccsplat_last_error();
    for (const bool part : {false, true})
      for (uint64_t n = 0; n < whole.calls; ++n) {
        Sink sink{.fail_at = n, .part_of_it = part};
        EXPECT_EQ(write(device, kind, sink), BCCSPLAT_ERROR_IO) << "write " << n << " of " << whole.calls;
      }
    for (uint64_t n = 0; n < whole.flushes; ++n) {
      Sink sink{.fail_flush_at = n};
      EXPECT_EQ(write(device, kind, sink), BCCSPLAT_ERROR_IO) << "flush " << n << " of " << whole.flushes;
    }
  }
}

// After every second flush there is a file to look at, which has more and more frames.
TEST(WriteStreams, ShowAFileUnderWay) {
  const Device device = make_device(), other = make_device();
  Kind kind = kinds()[5];
  kind.series.nt = 30, kind.options.dims[3] = 30;
  Sink sink;
  uint64_t frames = 0, states = 0;
  sink.on_flush = [&] {
    bccsplat_volume* v = nullptr;
    if (bccsplat_volume_open_memory(other.get(), sink.bytes.data(), sink.bytes.size(), nullptr, &v) !=
        BCCSPLAT_OK) {
      EXPECT_EQ(states, 0u) << bccsplat_last_error();
      return;
    }
    const Volume volume(v);
    auto info = sized<bccsplat_volume_info>();
    ASSERT_OK(bccsplat_volume_get_info(v, &info));
    EXPECT_GE(info.dims[3], frames);
    frames = info.dims[3], ++states;
    const Slice slice = cut_time(volume, static_cast<double>(frames) - 1);
    EXPECT_TRUE(slice);
  };
  ASSERT_EQ(write(device, kind, sink), BCCSPLAT_OK) << bccsplat_last_error();
  EXPECT_EQ(frames, 30u);
  EXPECT_GE(states, 3u);
}

struct Parts {
  std::vector<std::vector<char>> bytes;
  std::vector<std::string> paths;
};

Parts parts_of(const Device& device, const Folder& folder, const NoiseSeries& series) {
  Parts parts;
  std::vector<double> times(series.nt);
  for (uint32_t t = 0; t < series.nt; ++t) times[t] = t;
  for (const auto& [first, end] : {std::pair<uint64_t, uint64_t>{0, 5}, {5, 9}, {9, 14}}) {
    auto part = sized<bccsplat_series_part>();
    part.first = first, part.end = end, part.times = times.data();
    auto o = series.options();
    o.part = &part;
    parts.bytes.push_back(written(device, series, o));
    parts.paths.push_back(folder.file("part" + std::to_string(first)));
    std::ofstream(parts.paths.back(), std::ios::binary)
        .write(parts.bytes.back().data(), parts.bytes.back().size());
  }
  return parts;
}

TEST(JoinStreams, GiveTheBytesOfJoinedFiles) {
  const Folder folder;
  const Device device = make_device();
  NoiseSeries series;
  series.nx = 36, series.ny = 20, series.nz = 18;
  const Parts parts = parts_of(device, folder, series);
  std::vector<const char*> names;
  for (const std::string& path : parts.paths) names.push_back(path.c_str());
  ASSERT_OK(
      bccsplat_join_parts(device.get(), 3, names.data(), folder.file("joined").c_str(), nullptr, nullptr));
  std::vector<std::unique_ptr<FarFile>> files;
  std::vector<bccsplat_read_stream> streams;
  for (const auto& bytes : parts.bytes) {
    files.push_back(std::make_unique<FarFile>(bytes));
    streams.push_back(files.back()->stream());
  }
  std::swap(streams[0], streams[2]); // any order will do
  const auto join = [&](Sink& sink, size_t count = 3) {
    const bccsplat_write_stream to = sink.stream();
    auto report = sized<bccsplat_writer_report>();
    const auto status = bccsplat_join_streams(device.get(), count, streams.data(), &to, nullptr, &report);
    if (status == BCCSPLAT_OK) {
      EXPECT_EQ(report.bytes_file, sink.bytes.size());
    }
    return status;
  };
  Sink sink;
  ASSERT_EQ(join(sink), BCCSPLAT_OK) << bccsplat_last_error();
  EXPECT_EQ(sink.bytes, file_bytes(folder.file("joined")));
  for (uint64_t n = 0; n < sink.calls; ++n) {
    Sink failing{.fail_at = n, .part_of_it = n % 2 == 1};
    EXPECT_EQ(join(failing), BCCSPLAT_ERROR_IO) << n;
  }
  Sink two;
  EXPECT_EQ(join(two, 2), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("part 1"), std::string::npos) << bccsplat_last_error();
  EXPECT_TRUE(two.bytes.empty());
  // Parts whose bytes are late: the output starts over.
  for (auto& file : files) file->blocks = true;
  Sink late;
  int waits = 0;
  bccsplat_status status;
  while ((status = join(late)) == BCCSPLAT_ERROR_WOULD_BLOCK && waits < 10000) late.bytes.clear(), ++waits;
  EXPECT_EQ(status, BCCSPLAT_OK) << bccsplat_last_error();
  EXPECT_GT(waits, 2);
  EXPECT_EQ(late.bytes, sink.bytes);
}

} // namespace
} // namespace host

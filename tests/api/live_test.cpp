// SPDX-License-Identifier: Apache-2.0
// Files that are looked at while they are written: each state is a sound file of its own, and shows at every
// moment of its frames what the finished one shows there.
#include <array>
#include <csignal>
#include <cstring>
#include <map>
#include <memory>

#ifndef _WIN32
#include <sys/wait.h>
#endif

#include "../support/emulated.h"
#include "fit_writer.h"
#include "support.h"

namespace bccsplat::test {
namespace {

constexpr uint32_t frames = 48;

double field_of(double x, double y, double z, double t) {
  const double v = 9 * std::sin(0.4 * x + 0.3 * t) * std::cos(0.35 * y - 0.2 * z + 0.05 * t);
  return v > 0 ? v : 0;
}

struct Variant {
  const char* name;
  int32_t type = BCCSPLAT_TYPE_F32;
  bccsplat_writer_options options = sized<bccsplat_writer_options>();
  uint32_t channels = 1;
  bool uneven = false, coast = false;
};

std::vector<Variant> variants() {
  std::vector<Variant> list;
  const auto add = [&](const char* name, const auto& change) {
    Variant v{.name = name};
    v.options.dims[0] = 34, v.options.dims[1] = 21, v.options.dims[2] = 18, v.options.dims[3] = frames;
    v.options.live = 1;
    change(v);
    list.push_back(v);
  };
  add("plain", [](Variant&) {});
  add("length unknown", [](Variant& v) { v.options.dims[3] = 0; });
  add("two channels of bytes", [](Variant& v) { v.channels = 2, v.type = BCCSPLAT_TYPE_U8; });
  add("levels", [](Variant& v) { v.options.levels = 2; });
  add("bytes, every other slab", [](Variant& v) { v.type = BCCSPLAT_TYPE_U8, v.options.live = 2; });
  add("bound", [](Variant& v) { v.options.abs_error = 0.02; });
  add("coast", [](Variant& v) { v.options.nonfinite = BCCSPLAT_NONFINITE_HOLE, v.coast = true; });
  add("uneven times", [](Variant& v) { v.uneven = true; });
  add("Cartesian", [](Variant& v) { v.options.lattice = BCCSPLAT_LATTICE_CC; });
  add("wide in time", [](Variant& v) { v.options.time_scale = 1.4; });
  return list;
}

double time_of(const Variant& v, uint32_t t) { return v.uneven ? t + 0.3 * std::sin(t) : 0.5 * t; }

bccsplat_status add_frame(const Variant& v, bccsplat_writer* writer, uint32_t t) {
  const uint32_t* const n = v.options.dims;
  Source s = source_of({n[0], n[1], n[2], 1}, v.type, [&](double x, double y, double z, double) {
    return v.coast && x + y < 9 + t % 3 ? std::nan("") : field_of(x, y, z, t);
  });
  for (uint32_t c = 0; c < v.channels; ++c) {
    const Bytes data = frame_bytes(s, 0);
    auto box = sized<bccsplat_box>();
    box.type = s.type, box.data = data.data();
    for (size_t a = 0; a < 3; ++a) box.dims[a] = n[a];
    if (const bccsplat_status status = bccsplat_writer_add_frame(writer, c, time_of(v, t), &box, 1))
      return status;
  }
  return BCCSPLAT_OK;
}

struct Opened {
  // kernel: null for the file's.
  Opened(const TestDevice& device, const std::string& path, const char* kernel = nullptr) {
    auto o = sized<bccsplat_volume_options>();
    o.kernel = kernel;
    status = bccsplat_volume_open_file(device.device, path.c_str(), &o, &volume);
    if (status != BCCSPLAT_OK) return;
    EXPECT_EQ(bccsplat_volume_get_info(volume, &info), BCCSPLAT_OK);
  }
  // Opens the file of another one again.
  explicit Opened(const Opened& older) {
    status = bccsplat_volume_reopen(older.volume, nullptr, &volume);
    EXPECT_EQ(status, BCCSPLAT_OK) << bccsplat_last_error();
    EXPECT_EQ(bccsplat_volume_get_info(volume, &info), BCCSPLAT_OK);
  }
  [[nodiscard]] uint64_t bytes_read() const {
    auto now = sized<bccsplat_volume_info>();
    EXPECT_EQ(bccsplat_volume_get_info(volume, &now), BCCSPLAT_OK);
    return now.bytes_read;
  }
  ~Opened() { bccsplat_volume_release(volume); }
  Opened& operator=(const Opened&) = delete;
  [[nodiscard]] uint64_t damages() const {
    auto report = sized<bccsplat_verify_report>();
    EXPECT_EQ(bccsplat_volume_verify(volume, nullptr, nullptr, &report), BCCSPLAT_OK);
    return report.damages;
  }
  // Of the last channel, level 1 where there is one.
  [[nodiscard]] std::vector<float> slice(std::array<double, 5> h, uint32_t level = 0) const {
    auto plane = sized<bccsplat_hyperplane>();
    plane.a = h[0], plane.b = h[1], plane.c = h[2], plane.d = h[3], plane.e = h[4];
    auto o = sized<bccsplat_slice_options>();
    o.channel = info.channel_count - 1, o.level = level;
    bccsplat_slice* slice = nullptr;
    EXPECT_EQ(bccsplat_slice_create(volume, &plane, &o, &slice), BCCSPLAT_OK) << bccsplat_last_error();
    auto shape = sized<bccsplat_slice_info>();
    EXPECT_EQ(bccsplat_slice_get_info(slice, &shape), BCCSPLAT_OK);
    std::vector<float> values(shape.dims[0] * shape.dims[1] * shape.dims[2]);
    EXPECT_EQ(bccsplat_slice_sample_grid(slice, nullptr, values.data()), BCCSPLAT_OK);
    bccsplat_slice_release(slice);
    for (float& value : values)
      if (std::isnan(value)) value = -12345; // equal to itself
    return values;
  }
  // Of the last channel: at points close together, and in a box, which have caches of their own.
  [[nodiscard]] std::vector<float> around(double t) const {
    const double at[12] = {20, 5, 5, t, 20.5, 5.25, 6, t, 21, 6, 5.5, t};
    const double box[6] = {4, 3, 2, 12, 9, 8};
    std::vector<float> values(3);
    const bccsplat_status found =
        bccsplat_volume_evaluate_channel(volume, info.channel_count - 1, 3, at, values.data(), nullptr);
    EXPECT_EQ(found, BCCSPLAT_OK) << bccsplat_last_error();
    auto o = sized<bccsplat_slice_options>();
    o.channel = info.channel_count - 1, o.box = box;
    double time = 0;
    bccsplat_slice* slice = nullptr;
    EXPECT_EQ(bccsplat_volume_index_to_time(volume, t, &time), BCCSPLAT_OK);
    EXPECT_EQ(bccsplat_volume_slice_at(volume, time, &o, &slice), BCCSPLAT_OK) << bccsplat_last_error();
    std::vector<float> part(size_t{9} * 7 * 7);
    EXPECT_EQ(bccsplat_slice_sample_grid(slice, nullptr, part.data()), BCCSPLAT_OK);
    bccsplat_slice_release(slice);
    for (const float v : part) values.push_back(std::isnan(v) ? -12345 : v);
    return values;
  }
  bccsplat_volume* volume = nullptr;
  bccsplat_status status = BCCSPLAT_OK;
  bccsplat_volume_info info = sized<bccsplat_volume_info>();
};

// What is seen of an unfinished file: time slices by frame number.
struct Seen {
  uint64_t frames = 0;
  std::map<double, std::vector<float>> moments, of_level;
};

Seen look(const Opened& file) {
  Seen seen{file.info.dims[3], {}, {}};
  const double last = static_cast<double>(file.info.dims[3]) - 1;
  for (const double t : {0.0, last / 3, last - 0.6, last}) {
    seen.moments[t] = file.slice({0, 0, 0, 1, -t});
    if (file.info.level_count > 0) seen.of_level[t] = file.slice({0, 0, 0, 1, -t}, 1);
  }
  return seen;
}

TEST(Live, EveryStateIsASoundFileAndShowsWhatTheFinishedOneDoes) {
  const host::Folder folder;
  const TestDevice device;
  for (const Variant& v : variants()) {
    SCOPED_TRACE(v.name);
    const std::string path = folder.file(std::string(v.name) + ".bcc4");
    std::array<bccsplat_channel_options, 2> channels{sized<bccsplat_channel_options>(),
                                                     sized<bccsplat_channel_options>()};
    channels[0].name = "a", channels[1].name = "b";
    auto o = v.options;
    o.channels = channels.data(), o.channel_count = v.channels;
    bccsplat_writer* writer = nullptr;
    ASSERT_EQ(bccsplat_writer_create(device.device, path.c_str(), &o, &writer), BCCSPLAT_OK)
        << bccsplat_last_error();
    std::vector<Seen> states;
    for (uint32_t t = 0; t < frames; ++t) {
      ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK) << bccsplat_last_error();
      const Opened file(device, path + ".partial");
      if (file.status != BCCSPLAT_OK) {
        EXPECT_TRUE(states.empty()) << bccsplat_last_error();
        continue;
      }
      if (!states.empty() && states.back().frames == file.info.dims[3]) continue;
      EXPECT_TRUE(states.empty() || states.back().frames < file.info.dims[3]);
      EXPECT_EQ(file.damages(), 0u);
      EXPECT_LE(file.info.dims[3], t + 1);
      EXPECT_EQ(file.info.frames_expected, o.dims[3] > 0 ? frames : file.info.dims[3]);
      const auto shown = static_cast<uint32_t>(file.info.dims[3]);
      EXPECT_EQ(file.info.time_last, time_of(v, shown - 1));
      float value = 0;
      const double beyond[4] = {20, 5, 5, shown - 0.5};
      EXPECT_EQ(bccsplat_volume_evaluate(file.volume, 1, beyond, &value, nullptr),
                BCCSPLAT_ERROR_OUT_OF_DOMAIN);
      states.push_back(look(file));
    }
    EXPECT_GE(states.size(), 3u);
    EXPECT_GE(states.back().frames, frames * 2 / 3);
    ASSERT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
    bccsplat_writer_release(writer);
    const Opened file(device, path);
    ASSERT_EQ(file.status, BCCSPLAT_OK) << bccsplat_last_error();
    EXPECT_EQ(file.damages(), 0u);
    EXPECT_EQ(file.info.frames_expected, 0u);
    EXPECT_EQ(file.info.dims[3], frames);
    for (const Seen& state : states) {
      for (const auto& [t, values] : state.moments)
        EXPECT_EQ(values, file.slice({0, 0, 0, 1, -t})) << state.frames << " frames, " << t;
      for (const auto& [t, values] : state.of_level)
        EXPECT_EQ(values, file.slice({0, 0, 0, 1, -t}, 1)) << state.frames << " frames, level 1, " << t;
    }
    const uint64_t unused =
        file.info.bytes_file - file.info.bytes_values - file.info.bytes_runs - file.info.bytes_index;
    EXPECT_GT(unused, 0u);
    EXPECT_LT(unused, states.size() * 8192); // directory and metadata of each state

    // But for these bytes it is the file of a writer that shows nothing.
    const std::string plain = folder.file(std::string(v.name) + ", not live.bcc4");
    o.live = 0;
    ASSERT_EQ(bccsplat_writer_create(device.device, plain.c_str(), &o, &writer), BCCSPLAT_OK);
    for (uint32_t t = 0; t < frames; ++t) ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK);
    ASSERT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK);
    bccsplat_writer_release(writer);
    const Opened other(device, plain);
    EXPECT_EQ(other.info.bytes_values, file.info.bytes_values);
    EXPECT_EQ(other.info.bytes_runs, file.info.bytes_runs);
    // Chunks are further apart, which takes a few bytes to tell.
    const auto index = static_cast<double>(other.info.bytes_index);
    EXPECT_NEAR(static_cast<double>(file.info.bytes_index), index, 0.03 * index);
  }
}

// Moments of the first `count` frames and between them, all of the last ones.
void expect_same_moments(const Opened& a, const Opened& b, uint64_t count) {
  const double last = static_cast<double>(count) - 1;
  for (double t = 0; t <= last; t += t < last - 6 ? 1.5 : 0.5) {
    ASSERT_EQ(a.around(t), b.around(t)) << t;
    ASSERT_EQ(a.slice({0, 0, 0, 1, -t}), b.slice({0, 0, 0, 1, -t})) << t;
    if (a.info.level_count == 0) continue;
    ASSERT_EQ(a.slice({0, 0, 0, 1, -t}, 1), b.slice({0, 0, 0, 1, -t}, 1)) << t;
  }
}

// A volume that is opened again shows what a fresh one does, bit for bit, and reads of the moments that were
// looked at hardly more than what depends on the old end.
void follow(const Variant& v, const char* kernel) {
  SCOPED_TRACE(testing::Message() << v.name << " " << (kernel ? kernel : ""));
  const host::Folder folder;
  const TestDevice device;
  const std::string path = folder.file(std::string(v.name) + ".bcc4");
  std::array<bccsplat_channel_options, 2> channels{sized<bccsplat_channel_options>(),
                                                   sized<bccsplat_channel_options>()};
  channels[0].name = "a", channels[1].name = "b";
  auto o = v.options;
  o.channels = channels.data(), o.channel_count = v.channels;
  bccsplat_writer* writer = nullptr;
  ASSERT_EQ(bccsplat_writer_create(device.device, path.c_str(), &o, &writer), BCCSPLAT_OK);
  std::unique_ptr<Opened> held;
  uint64_t by_fresh = 0, by_newer = 0;
  int states = 0;
  const auto look_again = [&](const std::string& at) {
    const Opened fresh(device, at, kernel);
    ASSERT_EQ(fresh.status, BCCSPLAT_OK);
    auto newer = std::make_unique<Opened>(*held);
    ASSERT_EQ(newer->info.dims[3], fresh.info.dims[3]);
    const uint64_t known = held->info.dims[3];
    held.reset(); // what is shared outlives it
    expect_same_moments(*newer, fresh, known);
    by_fresh += fresh.bytes_read(), by_newer += newer->bytes_read();
    expect_same_moments(*newer, fresh, newer->info.dims[3]);
    EXPECT_EQ(newer->damages(), 0u);
    held = std::move(newer), ++states;
  };
  for (uint32_t t = 0; t < frames; ++t) {
    ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK) << bccsplat_last_error();
    auto now = std::make_unique<Opened>(device, path + ".partial", kernel);
    if (now->status != BCCSPLAT_OK || (held && now->info.dims[3] == held->info.dims[3])) continue;
    EXPECT_EQ(now->info.series_state, o.dims[3] > 0 ? BCCSPLAT_SERIES_UNFINISHED : BCCSPLAT_SERIES_OPEN_END);
    if (held)
      look_again(path + ".partial");
    else
      held = std::move(now), expect_same_moments(*held, *held, held->info.dims[3]);
  }
  ASSERT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
  bccsplat_writer_release(writer);
  ASSERT_TRUE(held);
  look_again(path); // the file has another name now
  EXPECT_EQ(held->info.series_state, BCCSPLAT_SERIES_FINISHED);
  EXPECT_EQ(held->info.dims[3], frames);
  EXPECT_GE(states, 3);
  EXPECT_LT(by_newer, by_fresh / 2) << by_newer << " of " << by_fresh;
}

TEST(Live, AVolumeOpenedAgainIsAFreshOneThatReadsLess) {
  for (const Variant& v : bccsplat::test::some(variants(), 5)) follow(v, nullptr);
}

// Kernels that reach further than the file's see mirror images beyond the last layer, until there are more.
TEST(Live, AVolumeOpenedAgainUnderAnotherKernelIsAFreshOne) {
  for (const Variant& v : variants())
    if (const std::string name = v.name; name == "plain" || name == "two channels of bytes")
      follow(v, "fine");
}

// What is kept is the bytes of memory that the old handle had.
TEST(Live, AVolumeOpenedAgainSharesItsMemory) {
  const host::Folder folder;
  const TestDevice device;
  const Variant v = variants().front();
  const std::string path = folder.file("s.bcc4");
  bccsplat_writer* writer = nullptr;
  ASSERT_EQ(bccsplat_writer_create(device.device, path.c_str(), &v.options, &writer), BCCSPLAT_OK);
  for (uint32_t t = 0; t < frames; ++t) ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK);
  ASSERT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK);
  bccsplat_writer_release(writer);
  const auto used = [&] {
    auto info = sized<bccsplat_device_info>();
    EXPECT_EQ(bccsplat_device_get_info(device.device, &info), BCCSPLAT_OK);
    return info.memory_used;
  };
  const Opened file(device, path);
  (void)file.slice({0, 0, 0, 1, -8.5});
  const uint64_t before = used();
  EXPECT_GT(before, 0u);
  {
    const Opened again(file);
    EXPECT_EQ(used(), before);
    const uint64_t read = again.bytes_read();
    EXPECT_EQ(again.slice({0, 0, 0, 1, -8.5}), file.slice({0, 0, 0, 1, -8.5}));
    EXPECT_EQ(again.bytes_read(), read);
    EXPECT_EQ(used(), before);
  }
  EXPECT_EQ(used(), before);
  // Another file in its place begins with nothing.
  Variant other = v;
  other.options.time_scale = 1.3;
  const std::string elsewhere = folder.file("other.bcc4");
  ASSERT_EQ(bccsplat_writer_create(device.device, elsewhere.c_str(), &other.options, &writer), BCCSPLAT_OK);
  for (uint32_t t = 0; t < frames; ++t) ASSERT_EQ(add_frame(other, writer, t), BCCSPLAT_OK);
  ASSERT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK);
  bccsplat_writer_release(writer);
  const Opened replaced(device, elsewhere);
  Bytes bytes(1 << 22);
  std::FILE* f = std::fopen(elsewhere.c_str(), "rb");
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), f));
  std::fclose(f);
  auto stream = sized<bccsplat_read_stream>();
  stream.size = bytes.size(), stream.user = bytes.data();
  stream.read_at = [](void* user, uint64_t offset, void* to, uint64_t size) {
    std::memcpy(to, static_cast<const char*>(user) + offset, size);
    return static_cast<int64_t>(size);
  };
  bccsplat_volume* through = nullptr;
  ASSERT_EQ(bccsplat_volume_reopen(file.volume, &stream, &through), BCCSPLAT_OK) << bccsplat_last_error();
  EXPECT_EQ(used(), before);
  float a = 0, b = 0;
  const double at[4] = {20, 5, 5, 8.5};
  EXPECT_EQ(bccsplat_volume_evaluate(through, 1, at, &a, nullptr), BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_volume_evaluate(replaced.volume, 1, at, &b, nullptr), BCCSPLAT_OK);
  EXPECT_EQ(a, b);
  bccsplat_volume_release(through);
}

// What spans time ends with the frames that can be looked at.
TEST(Live, PlanesOverTimeEndWithTheFrames) {
  const host::Folder folder;
  const TestDevice device;
  const Variant v = variants().front();
  bccsplat_writer* writer = nullptr;
  const std::string path = folder.file("s.bcc4");
  ASSERT_EQ(bccsplat_writer_create(device.device, path.c_str(), &v.options, &writer), BCCSPLAT_OK);
  for (uint32_t t = 0; t < 40; ++t) ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK);
  const Opened file(device, path + ".partial");
  ASSERT_EQ(file.status, BCCSPLAT_OK) << bccsplat_last_error();
  const size_t shown = file.info.dims[3];
  EXPECT_EQ(file.slice({1, 0, 0, 0, -12}).size(), size_t{21} * 18 * shown); // y, z and time
  ASSERT_EQ(bccsplat_writer_finish_short(writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
  bccsplat_writer_release(writer);
  const Opened finished(device, path);
  EXPECT_EQ(finished.info.dims[3], 40u);
  EXPECT_EQ(finished.info.frames_expected, 0u);
  EXPECT_EQ(finished.damages(), 0u);
  // The volume that was opened before still holds the file as it was.
  EXPECT_EQ(file.slice({0, 0, 0, 1, -8.5}), finished.slice({0, 0, 0, 1, -8.5}));
  EXPECT_EQ(file.damages(), 0u);
}

int32_t field_function(void*, uint64_t n, const double* p, float* values) {
  for (uint64_t i = 0; i < n; ++i)
    values[i] = static_cast<float>(1 + field_of(p[4 * i], p[4 * i + 1], p[4 * i + 2], p[4 * i + 3]));
  return 0;
}

TEST(Live, LayersAndStreamsAreShownAsWell) {
  const TestDevice device;
  auto o = variants().front().options;
  Bytes bytes;
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = write_bytes, stream.user = &bytes;
  bccsplat_writer* writer = nullptr;
  ASSERT_EQ(bccsplat_writer_create_stream(device.device, &stream, &o, &writer), BCCSPLAT_OK);
  ASSERT_EQ(bccsplat_writer_add_field(writer, 0, field_function, nullptr), BCCSPLAT_OK)
      << bccsplat_last_error();
  const Bytes before = bytes; // as it stands
  ASSERT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
  bccsplat_writer_release(writer);
  const OpenVolume unfinished(device, before), finished(device, bytes);
  ASSERT_EQ(unfinished.status, BCCSPLAT_OK);
  auto info = sized<bccsplat_volume_info>();
  ASSERT_EQ(bccsplat_volume_get_info(unfinished.volume, &info), BCCSPLAT_OK);
  EXPECT_EQ(info.frames_expected, frames);
  EXPECT_GT(info.dims[3], frames / 2);
  const double last = static_cast<double>(info.dims[3]) - 1;
  EXPECT_EQ(unfinished.frame(last), finished.frame(last));
}

#ifndef _WIN32 // which has no fork: cross/windows_test.py kills the tool
// A writer that is killed at any moment leaves a file that opens up to what it showed last.
TEST(Live, AKilledWriterLeavesWhatItShowed) {
  const host::Folder folder;
  const Variant v = variants().front();
  const std::string path = folder.file("s.bcc4");
  uint64_t most = 0;
  for (int attempt = 0; attempt < 12; ++attempt) {
    for (const char* end : {".partial", ".journal"}) std::filesystem::remove(path + end);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const TestDevice device(1);
      auto o = v.options;
      o.partial = BCCSPLAT_PARTIAL_KEEP;
      bccsplat_writer* writer = nullptr;
      if (bccsplat_writer_create(device.device, path.c_str(), &o, &writer) != BCCSPLAT_OK) ::_exit(1);
      for (uint32_t t = 0; t < frames; ++t)
        if (add_frame(v, writer, t) != BCCSPLAT_OK) ::_exit(1);
      for (;;) ::pause(); // never finished
    }
    // Until it shows something, and a little longer.
    const TestDevice device;
    bool shown = false;
    for (int i = 0; i < 2000 && !shown; ++i) {
      ::usleep(5000);
      shown = Opened(device, path + ".partial").status == BCCSPLAT_OK;
    }
    ::usleep(static_cast<useconds_t>(attempt * 7000));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    const Opened left(device, path + ".partial");
    ASSERT_TRUE(shown);
    ASSERT_EQ(left.status, BCCSPLAT_OK) << bccsplat_last_error();
    EXPECT_EQ(left.damages(), 0u);
    EXPECT_EQ(left.info.frames_expected, frames);
    EXPECT_FALSE(left.slice({0, 0, 0, 1, 1.0 - static_cast<double>(left.info.dims[3])}).empty());
    most = std::max(most, left.info.dims[3]);
  }
  EXPECT_GT(most, 2u);

  // It is taken up again where it ended.
  const TestDevice device;
  const auto write = [&](const std::string& to, int32_t partial, bccsplat_writer_report& report) {
    auto o = v.options;
    o.partial = partial;
    bccsplat_writer* writer = nullptr;
    ASSERT_EQ(bccsplat_writer_create(device.device, to.c_str(), &o, &writer), BCCSPLAT_OK);
    for (uint32_t t = 0; t < frames; ++t)
      ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK) << bccsplat_last_error();
    ASSERT_EQ(bccsplat_writer_finish(writer, &report), BCCSPLAT_OK) << bccsplat_last_error();
    bccsplat_writer_release(writer);
  };
  auto report = sized<bccsplat_writer_report>();
  write(folder.file("whole.bcc4"), BCCSPLAT_PARTIAL_DEFAULT, report);
  write(path, BCCSPLAT_PARTIAL_RESUME, report);
  const auto bytes_of = [](const std::string& name) {
    std::FILE* f = std::fopen(name.c_str(), "rb");
    Bytes bytes(1 << 24);
    bytes.resize(std::fread(bytes.data(), 1, bytes.size(), f));
    std::fclose(f);
    return bytes;
  };
  EXPECT_EQ(bytes_of(path), bytes_of(folder.file("whole.bcc4")));
}
#endif

// A reader never sees fewer frames than before, nor other values, while a writer takes up the work.
TEST(Live, AWriterThatResumesShowsNoLess) {
  const host::Folder folder;
  const TestDevice device(2);
  for (const Variant& v : variants()) {
    if (v.options.dims[3] == 0 || v.channels > 1) continue;
    SCOPED_TRACE(v.name);
    const std::string path = folder.free_file("s.bcc4"), unfinished = path + ".partial";
    const auto begin = [&](int32_t partial) {
      auto o = v.options;
      o.partial = partial;
      bccsplat_writer* writer = nullptr;
      EXPECT_EQ(bccsplat_writer_create(device.device, path.c_str(), &o, &writer), BCCSPLAT_OK)
          << bccsplat_last_error();
      return writer;
    };
    bccsplat_writer* writer = begin(BCCSPLAT_PARTIAL_KEEP);
    for (uint32_t t = 0; t < 40; ++t) ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK);
    bccsplat_writer_release(writer);
    const Opened before(device, unfinished);
    ASSERT_EQ(before.status, BCCSPLAT_OK) << bccsplat_last_error();
    const uint64_t shown = before.info.dims[3];
    ASSERT_GT(shown, 8u);
    const auto first = before.slice({0, 0, 0, 1, -2.5}),
               last = before.slice({0, 0, 0, 1, 1 - static_cast<double>(shown)});
    writer = begin(BCCSPLAT_PARTIAL_RESUME);
    uint64_t most = 0;
    for (uint32_t t = 0; t < frames; ++t) {
      ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK) << bccsplat_last_error();
      if (t % 3 != 0 && t + 1 < frames) continue;
      const Opened now(device, unfinished);
      ASSERT_EQ(now.status, BCCSPLAT_OK) << bccsplat_last_error();
      ASSERT_GE(now.info.dims[3], shown) << t;
      ASSERT_EQ(now.damages(), 0u) << t;
      if (now.info.dims[3] == shown) {
        ASSERT_EQ(now.slice({0, 0, 0, 1, -2.5}), first) << t;
        ASSERT_EQ(now.slice({0, 0, 0, 1, 1 - static_cast<double>(shown)}), last) << t;
      }
      most = std::max(most, now.info.dims[3]);
    }
    EXPECT_GT(most, shown) << "and more, once there is more";
    EXPECT_EQ(bccsplat_writer_finish(writer, nullptr), BCCSPLAT_OK) << bccsplat_last_error();
    bccsplat_writer_release(writer);
    EXPECT_EQ(Opened(device, path).info.dims[3], frames);
  }
}

TEST(Live, IsNotForPartsAndNothingIsAppendedToIt) {
  const host::Folder folder;
  const TestDevice device;
  const Variant v = variants().front();
  std::vector<double> times;
  for (uint32_t t = 0; t < frames; ++t) times.push_back(t);
  auto part = sized<bccsplat_series_part>();
  part.first = 0, part.end = 20, part.times = times.data();
  auto o = v.options;
  o.part = &part;
  bccsplat_writer* writer = nullptr;
  EXPECT_EQ(bccsplat_writer_create(device.device, folder.file("p.bcc4").c_str(), &o, &writer),
            BCCSPLAT_ERROR_UNSUPPORTED);
  o = v.options, o.periodic_axes = 8;
  EXPECT_EQ(bccsplat_writer_create(device.device, folder.file("p.bcc4").c_str(), &o, &writer),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o = v.options, o.partial = BCCSPLAT_PARTIAL_KEEP;
  const std::string path = folder.file("s.bcc4"), left = folder.file("left.bcc4");
  ASSERT_EQ(bccsplat_writer_create(device.device, path.c_str(), &o, &writer), BCCSPLAT_OK);
  for (uint32_t t = 0; t < 30; ++t) ASSERT_EQ(add_frame(v, writer, t), BCCSPLAT_OK);
  bccsplat_writer_release(writer); // without finish
  std::filesystem::rename(path + ".partial", left);
  o.partial = BCCSPLAT_PARTIAL_APPEND, o.live = 0;
  EXPECT_EQ(bccsplat_writer_create(device.device, left.c_str(), &o, &writer), BCCSPLAT_ERROR_WRONG_STATE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("unfinished"), std::string::npos);
}

} // namespace
} // namespace bccsplat::test

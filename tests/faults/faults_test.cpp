// SPDX-License-Identifier: Apache-2.0
// What fails once must fail cleanly: allocation N, read N, write N, a disk full after N bytes, a call
// cancelled at N, for every N. The answer is a status that names the cause, outputs stay empty, nothing
// leaks, and the name of the target never holds a broken file.
#include <chrono>
#include <csignal>
#include <cstring>
#include <functional>
#include <string>
#include <thread>

#include <sys/resource.h>

#include "../api/support.h"
#include "allocation_faults.h"

namespace host {
namespace {

const Series tiny{.nx = 6, .ny = 5, .nz = 4, .nt = 3, .field = nullptr};
constexpr size_t tiny_frame = 6 * 5 * 4;

// A stream of the host over a fixed buffer, whose call number `fail_at` fails: the host itself allocates
// nothing.
struct Stream {
  std::vector<char> bytes = std::vector<char>(1 << 20);
  uint64_t size = 0, calls = 0, fail_at = UINT64_MAX;
  bool part_of_it = false; // the failing call does half its work

  [[nodiscard]] int64_t failed(uint64_t wanted) const {
    return part_of_it ? static_cast<int64_t>(wanted / 2) : -1;
  }
  static int64_t write_at(void* user, uint64_t offset, const void* from, uint64_t wanted) {
    auto& s = *static_cast<Stream*>(user);
    if (s.calls++ == s.fail_at || offset + wanted > s.bytes.size()) return s.failed(wanted);
    s.size = std::max(s.size, offset + wanted);
    std::memcpy(s.bytes.data() + offset, from, wanted);
    return wanted;
  }
  static int64_t read_at(void* user, uint64_t offset, void* to, uint64_t wanted) {
    auto& s = *static_cast<Stream*>(user);
    if (s.calls++ == s.fail_at) return s.failed(wanted);
    std::memcpy(to, s.bytes.data() + offset, wanted);
    return wanted;
  }
};

// Goes on only while all is well.
class Steps {
 public:
  template<class Call> Steps& then(const Call& call) {
    if (status_ == BCCSPLAT_OK) status_ = call();
    return *this;
  }
  [[nodiscard]] bccsplat_status status() const { return status_; }

 private:
  bccsplat_status status_ = BCCSPLAT_OK;
};

bccsplat_status add_tiny_frames(bccsplat_writer* writer, const std::function<void()>& between = nullptr) {
  float values[tiny_frame];
  for (uint32_t t = 0; t < tiny.nt; ++t) {
    for (uint32_t i = 0; i < tiny_frame; ++i)
      values[i] = i % tiny.nx < 4 ? 10 + static_cast<float>(3 * (i % 7) + t) : 0;
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_F32, box.data = values;
    box.dims[0] = tiny.nx, box.dims[1] = tiny.ny, box.dims[2] = tiny.nz;
    const bccsplat_status status = bccsplat_writer_add_frame(writer, 0, t, &box, 1);
    if (status != BCCSPLAT_OK) return status;
    if (between) between();
  }
  return BCCSPLAT_OK;
}

bccsplat_status make_one_thread(Device& device) {
  auto o = sized<bccsplat_device_options>();
  o.thread_count = 1;
  bccsplat_device* d = nullptr;
  const bccsplat_status status = bccsplat_device_create(&o, &d);
  EXPECT_EQ(status == BCCSPLAT_OK, d != nullptr);
  device.reset(d);
  return status;
}

bccsplat_status write_to(Stream& stream) {
  stream.calls = stream.size = 0;
  Device device;
  Writer writer;
  return Steps()
      .then([&] { return make_one_thread(device); })
      .then([&] {
        const bccsplat_writer_options o = options_of(tiny);
        auto s = sized<bccsplat_write_stream>();
        s.write_at = Stream::write_at, s.user = &stream;
        bccsplat_writer* w = nullptr;
        const bccsplat_status status = bccsplat_writer_create_stream(device.get(), &s, &o, &w);
        EXPECT_EQ(status == BCCSPLAT_OK, w != nullptr);
        writer.reset(w);
        return status;
      })
      .then([&] { return add_tiny_frames(writer.get()); })
      .then([&] { return bccsplat_writer_finish(writer.get(), nullptr); })
      .status();
}

// What becomes of a file: each step may be left out.
struct Reading {
  bool verify = true, evaluate = true, slice = true, render = true, salvage = false;
};

bccsplat_status read_from(Stream& stream, const Reading& wanted) {
  stream.calls = 0;
  Device device;
  Volume volume;
  Slice slice;
  Renderer renderer;
  Frame frame;
  static float grid[tiny_frame];
  Steps steps;
  steps.then([&] { return make_one_thread(device); }).then([&] {
    auto s = sized<bccsplat_read_stream>();
    s.size = stream.size, s.read_at = Stream::read_at, s.user = &stream;
    auto o = sized<bccsplat_volume_options>();
    o.salvage = wanted.salvage;
    bccsplat_volume* v = nullptr;
    const bccsplat_status status = bccsplat_volume_open_stream(device.get(), &s, &o, &v);
    EXPECT_EQ(status == BCCSPLAT_OK, v != nullptr);
    volume.reset(v);
    return status;
  });
  if (wanted.verify)
    steps.then([&] {
      auto report = sized<bccsplat_verify_report>();
      const bccsplat_status status = bccsplat_volume_verify(volume.get(), nullptr, nullptr, &report);
      return status == BCCSPLAT_OK && report.damages > 0 ? BCCSPLAT_ERROR_CORRUPT : status;
    });
  if (wanted.evaluate)
    steps.then([&] {
      const double at[4] = {2, 2, 2, 1};
      float value = 0;
      return bccsplat_volume_evaluate(volume.get(), 1, at, &value, nullptr);
    });
  if (wanted.slice)
    steps
        .then([&] {
          auto plane = sized<bccsplat_hyperplane>();
          plane.d = 1, plane.e = -1.25;
          bccsplat_slice* s = nullptr;
          const bccsplat_status status = bccsplat_slice_create(volume.get(), &plane, nullptr, &s);
          EXPECT_EQ(status == BCCSPLAT_OK, s != nullptr);
          slice.reset(s);
          return status;
        })
        .then([&] { return bccsplat_slice_sample_grid(slice.get(), nullptr, grid); });
  if (wanted.render)
    steps
        .then([&] {
          bccsplat_renderer* r = nullptr;
          const bccsplat_status status = bccsplat_renderer_create(device.get(), &r);
          renderer.reset(r);
          return status;
        })
        .then([&] {
          bccsplat_frame* f = nullptr;
          const bccsplat_status status = bccsplat_frame_create(device.get(), 12, 12, BCCSPLAT_FRAME_RGBA, &f);
          frame.reset(f);
          return status;
        })
        .then([&] { return bccsplat_renderer_set_slice(renderer.get(), slice.get()); })
        .then([&] { return bccsplat_renderer_render(renderer.get(), frame.get()); });
  return steps.status();
}

bccsplat_status open_from(Stream& stream, const Device& device, Volume& volume) {
  auto s = sized<bccsplat_read_stream>();
  s.size = stream.size, s.read_at = Stream::read_at, s.user = &stream;
  bccsplat_volume* v = nullptr;
  const bccsplat_status status = bccsplat_volume_open_stream(device.get(), &s, nullptr, &v);
  EXPECT_EQ(status == BCCSPLAT_OK, v != nullptr);
  volume.reset(v);
  return status;
}

// Two volumes in a scene, one of them opened again, read ahead and drawn within a budget and without.
bccsplat_status draw_scene(Stream& stream) {
  stream.calls = 0;
  Device device;
  Volume volume, newer;
  Handle<bccsplat_scene> scene;
  Frame frame;
  uint64_t first = 0, second = 0;
  auto camera = sized<bccsplat_camera>();
  auto view = sized<bccsplat_view>();
  const auto render = [&](double budget_ms) {
    auto status = sized<bccsplat_scene_status>();
    const bccsplat_status s =
        bccsplat_scene_render(scene.get(), &view, frame.get(), nullptr, budget_ms, &status);
    EXPECT_TRUE(s != BCCSPLAT_OK || status.complete);
    return s;
  };
  return Steps()
      .then([&] { return make_one_thread(device); })
      .then([&] { return open_from(stream, device, volume); })
      .then([&] {
        const double at[4] = {2, 2, 2, 1};
        float value = 0;
        return bccsplat_volume_evaluate(volume.get(), 1, at, &value, nullptr);
      })
      .then([&] {
        bccsplat_volume* v = nullptr;
        const bccsplat_status status = bccsplat_volume_reopen(volume.get(), nullptr, &v);
        EXPECT_EQ(status == BCCSPLAT_OK, v != nullptr);
        newer.reset(v);
        return status;
      })
      .then([&] {
        bccsplat_scene* s = nullptr;
        const bccsplat_status status = bccsplat_scene_create(device.get(), &s);
        EXPECT_EQ(status == BCCSPLAT_OK, s != nullptr);
        scene.reset(s);
        return status;
      })
      .then([&] { return bccsplat_scene_add(scene.get(), volume.get(), nullptr, &first); })
      .then([&] {
        auto instance = sized<bccsplat_instance>();
        for (size_t n = 0; n < 4; ++n) instance.placement[5 * n] = 1;
        instance.placement[3] = 2;
        return bccsplat_scene_add(scene.get(), newer.get(), &instance, &second);
      })
      .then([&] { return bccsplat_scene_set_time(scene.get(), 1.25); })
      .then([&] {
        bccsplat_clip clip{};
        clip.normal[0] = 1, clip.offset = -1, clip.instance = second;
        return bccsplat_scene_set_clips(scene.get(), &clip, 1);
      })
      .then([&] {
        view.camera = &camera;
        return bccsplat_scene_fit_camera(scene.get(), 0, 20, 30, 12, 12, &camera);
      })
      .then([&] { return bccsplat_scene_prefetch(scene.get(), &view, 12, 12, nullptr, 2); })
      .then([&] {
        const bccsplat_host_plane plane{BCCSPLAT_FRAME_DEPTH, 0, nullptr, 0};
        bccsplat_frame* f = nullptr;
        const bccsplat_status status = bccsplat_frame_wrap_planes(device.get(), 12, 12, &plane, 1, &f);
        EXPECT_EQ(status == BCCSPLAT_OK, f != nullptr);
        frame.reset(f);
        return status;
      })
      .then([&] { return render(1e6); })
      .then([&] { return render(0); })
      .then([&] { return bccsplat_scene_remove(scene.get(), first); })
      .then([&] { return render(0); })
      .status();
}

// Fails every allocation of `run` in turn, or each so many-th. OK is an answer too where the library can do
// without the memory.
void fail_each_allocation(const std::function<bccsplat_status()>& run, uint64_t stride = 1) {
  for (int warm_up = 0; warm_up < 2; ++warm_up) // what is allocated once for good is there afterwards
    ASSERT_EQ(run(), BCCSPLAT_OK) << bccsplat_last_error();
  faults::fail_allocation(UINT64_MAX, false);
  const bccsplat_status undisturbed = run();
  const uint64_t allocations = faults::stop_failing();
  ASSERT_EQ(undisturbed, BCCSPLAT_OK);
  ASSERT_GT(allocations, 20u);
  for (const bool all_after : {false, true}) {
    uint64_t failures = 0, trials = 0;
    for (uint64_t n = all_after ? stride / 2 : 0; n < allocations; n += stride, ++trials) {
      const int64_t live = faults::live_allocations();
      faults::fail_allocation(n, all_after);
      const bccsplat_status status = run();
      faults::stop_failing();
      ASSERT_TRUE(status == BCCSPLAT_ERROR_OUT_OF_MEMORY || status == BCCSPLAT_OK)
          << "allocation " << n << " of " << allocations << ": " << status << " " << bccsplat_last_error();
      ASSERT_EQ(faults::live_allocations(), live) << "allocation " << n << " of " << allocations << " leaks";
      failures += status != BCCSPLAT_OK;
    }
    EXPECT_GT(failures, trials * 9 / 10);
  }
  testing::Test::RecordProperty("allocations", std::to_string(allocations));
  EXPECT_EQ(run(), BCCSPLAT_OK) << bccsplat_last_error();
}

TEST(Faults, EveryAllocationOfWriting) {
  Stream stream;
  fail_each_allocation([&] { return write_to(stream); });
}

TEST(Faults, EveryAllocationOfReading) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  fail_each_allocation([&] { return read_from(stream, {.slice = false, .render = false}); });
}

// Salvaging takes what cannot be read for a hole: memory that is short must not look like that.
TEST(Faults, EveryAllocationOfSalvaging) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  fail_each_allocation([&] { return read_from(stream, {.slice = false, .render = false, .salvage = true}); });
}

TEST(Faults, EveryAllocationOfSlicing) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  fail_each_allocation(
      [&] { return read_from(stream, {.verify = false, .evaluate = false, .render = false}); });
}

TEST(Faults, EveryAllocationOfRendering) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  fail_each_allocation([&] { return read_from(stream, {.verify = false, .evaluate = false}); });
}

TEST(Faults, AllocationsOfScenes) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  constexpr uint64_t some = 11; // all of them take a minute and more
  fail_each_allocation([&] { return draw_scene(stream); }, some);
}

TEST(Faults, EveryWriteOfAStream) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  const uint64_t writes = stream.calls;
  ASSERT_GE(writes, 2u);
  for (const bool part : {false, true})
    for (uint64_t n = 0; n < writes; ++n) {
      stream.fail_at = n, stream.part_of_it = part;
      EXPECT_EQ(write_to(stream), BCCSPLAT_ERROR_IO) << "write " << n;
      EXPECT_NE(std::string(bccsplat_last_error()).find("write"), std::string::npos);
    }
}

TEST(Faults, EveryReadOfAStream) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  for (const Reading& wanted :
       {Reading{.slice = false, .render = false}, Reading{.verify = false, .evaluate = false}}) {
    stream.fail_at = UINT64_MAX;
    ASSERT_OK(read_from(stream, wanted));
    const uint64_t reads = stream.calls;
    ASSERT_GE(reads, 3u);
    for (const bool part : {false, true})
      for (uint64_t n = 0; n < reads; ++n) {
        stream.fail_at = n, stream.part_of_it = part;
        const bccsplat_status status = read_from(stream, wanted);
        EXPECT_TRUE(status == BCCSPLAT_ERROR_IO || status == BCCSPLAT_ERROR_TRUNCATED ||
                    (wanted.verify && status == BCCSPLAT_ERROR_CORRUPT))
            << "read " << n << ": " << status;
      }
  }
}

// The size to which files of this process may grow; SIGXFSZ is ignored, so that writing answers EFBIG.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    rlimit now = old_;
    now.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int) = nullptr;
};

[[nodiscard]] std::vector<std::string> names_in(const Folder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    names.push_back(entry.path().filename().string());
  return names;
}

TEST(Faults, ADiskFullAfterNBytes) {
  const Folder folder;
  const std::string path = folder.file("full.bcc4");
  const auto write = [&](bool overwrite) {
    Device device;
    Writer writer;
    return Steps()
        .then([&] { return make_one_thread(device); })
        .then([&] {
          bccsplat_writer_options o = options_of(tiny);
          o.overwrite = overwrite;
          bccsplat_writer* w = nullptr;
          const bccsplat_status status = bccsplat_writer_create(device.get(), path.c_str(), &o, &w);
          writer.reset(w);
          return status;
        })
        .then([&] { return add_tiny_frames(writer.get()); })
        .then([&] { return bccsplat_writer_finish(writer.get(), nullptr); })
        .status();
  };
  ASSERT_EQ(write(false), BCCSPLAT_OK);
  const uint64_t size = std::filesystem::file_size(path);
  const auto written = std::filesystem::last_write_time(path);
  for (uint64_t room = 0; room < size; room += room < 12000 ? 1777 : 61) {
    const FileSizeLimit limit(room);
    EXPECT_EQ(write(true), BCCSPLAT_ERROR_NO_SPACE) << room << " bytes of " << size;
    ASSERT_EQ(std::filesystem::file_size(path), size);
    ASSERT_EQ(std::filesystem::last_write_time(path), written) << "the old file was touched";
    ASSERT_EQ(names_in(folder), std::vector<std::string>{"full.bcc4"}) << room << " bytes of " << size;
  }
  std::filesystem::remove(path);
  const FileSizeLimit limit(size / 2);
  EXPECT_EQ(write(false), BCCSPLAT_ERROR_NO_SPACE);
  EXPECT_TRUE(names_in(folder).empty());
}

// Cancels the progress call number `at`.
struct Cancel {
  uint64_t calls = 0, at = UINT64_MAX;
  static int32_t progress(void* user, double) {
    auto& c = *static_cast<Cancel*>(user);
    return c.calls++ == c.at;
  }
};

TEST(Faults, WritingCancelledAtEveryReport) {
  const Folder folder;
  const std::string path = folder.file("cancelled.bcc4");
  const auto write = [&](Cancel& cancel) {
    Device device;
    Writer writer;
    return Steps()
        .then([&] { return make_one_thread(device); })
        .then([&] {
          bccsplat_writer_options o = options_of(tiny);
          o.progress = Cancel::progress, o.progress_user = &cancel;
          bccsplat_writer* w = nullptr;
          const bccsplat_status status = bccsplat_writer_create(device.get(), path.c_str(), &o, &w);
          writer.reset(w);
          return status;
        })
        .then([&] {
          // Reports come at most 30 times a second.
          return add_tiny_frames(writer.get(),
                                 [] { std::this_thread::sleep_for(std::chrono::milliseconds(40)); });
        })
        .then([&] { return bccsplat_writer_finish(writer.get(), nullptr); })
        .status();
  };
  uint64_t cancelled = 0;
  for (uint64_t n = 0;; ++n) {
    Cancel cancel{.at = n};
    const bccsplat_status status = write(cancel);
    if (status == BCCSPLAT_OK) break;
    ++cancelled;
    EXPECT_EQ(status, BCCSPLAT_CANCELLED) << "report " << n;
    ASSERT_TRUE(names_in(folder).empty()) << "report " << n;
    ASSERT_LT(n, 100u);
  }
  EXPECT_GE(cancelled, 3u);
  EXPECT_EQ(names_in(folder), std::vector<std::string>{"cancelled.bcc4"});
}

TEST(Faults, VerifyingCancelledAtEveryReport) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  Device device;
  ASSERT_OK(make_one_thread(device));
  bccsplat_volume* v = nullptr;
  ASSERT_OK(bccsplat_volume_open_memory(device.get(), stream.bytes.data(), stream.size, nullptr, &v));
  const Volume volume(v);
  uint64_t cancelled = 0;
  for (uint64_t n = 0;; ++n) {
    Cancel cancel{.at = n};
    auto report = sized<bccsplat_verify_report>();
    const bccsplat_status status = bccsplat_volume_verify(v, Cancel::progress, &cancel, &report);
    if (status == BCCSPLAT_OK) {
      EXPECT_EQ(report.damages, 0u);
      break;
    }
    ++cancelled;
    EXPECT_EQ(status, BCCSPLAT_CANCELLED) << "report " << n;
    ASSERT_LT(n, 100u);
  }
  EXPECT_GE(cancelled, 1u);
}

// A runner of the host that cancels a render before its task number `at`.
struct CancellingRunner {
  uint64_t tasks = 0, at = UINT64_MAX;
  bccsplat_renderer* renderer = nullptr;
  static void run(void* user, uint64_t count, bccsplat_task_fn body, void* task) {
    auto& r = *static_cast<CancellingRunner*>(user);
    for (uint64_t i = 0; i < count; ++i) {
      if (r.tasks++ == r.at && r.renderer) {
        EXPECT_OK(bccsplat_renderer_cancel(r.renderer));
      }
      body(task, i);
    }
  }
};

TEST(Faults, RenderingCancelledAtEveryTask) {
  Stream stream;
  ASSERT_OK(write_to(stream));
  CancellingRunner runner;
  auto o = sized<bccsplat_device_options>();
  o.runner = CancellingRunner::run, o.runner_user = &runner, o.thread_count = 2;
  bccsplat_device* d = nullptr;
  ASSERT_OK(bccsplat_device_create(&o, &d));
  const Device device(d);
  bccsplat_volume* v = nullptr;
  ASSERT_OK(bccsplat_volume_open_memory(d, stream.bytes.data(), stream.size, nullptr, &v));
  const Volume volume(v);
  const Slice slice = cut_time(volume, 1);
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(d, &r));
  const Renderer renderer(r);
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(d, 40, 40, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  ASSERT_OK(bccsplat_renderer_render(r, f)); // the slice keeps its points from then on
  runner.renderer = r;
  runner.tasks = 0;
  ASSERT_OK(bccsplat_renderer_render(r, f));
  const uint64_t tasks = runner.tasks;
  ASSERT_GE(tasks, 3u);
  uint64_t cancelled = 0;
  for (uint64_t n = 0; n < tasks; ++n) {
    runner.tasks = 0, runner.at = n;
    const bccsplat_status status = bccsplat_renderer_render(r, f);
    EXPECT_TRUE(status == BCCSPLAT_CANCELLED || status == BCCSPLAT_OK) << "task " << n << ": " << status;
    cancelled += status == BCCSPLAT_CANCELLED;
  }
  EXPECT_GE(cancelled, tasks / 2);
  runner.at = UINT64_MAX;
  EXPECT_OK(bccsplat_renderer_render(r, f)); // a cancelled renderer is as good as new
}

} // namespace
} // namespace host

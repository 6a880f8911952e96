// SPDX-License-Identifier: Apache-2.0
// Const calls of one volume, slice and frame from many threads at once, with one device for all; run under
// the thread sanitizer it proves that they share nothing unguarded.
#include <atomic>
#include <cstring>
#include <thread>

#include "support.h"

using namespace host;

namespace {

constexpr int thread_count = 4;

// All threads start together; each runs the body with its number.
template<class Body> void together(const Body& body) {
  std::atomic<int> ready{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < thread_count; ++i)
    threads.emplace_back([&, i] {
      ++ready;
      while (ready.load() < thread_count) std::this_thread::yield();
      body(i);
    });
  for (std::thread& t : threads) t.join();
}

TEST(Threads, ConstCallsOfOneVolume) {
  const Folder folder;
  const Device device = make_device(2);
  (void)write_series(device, folder.file("s.bcc4"));
  const Volume volume = open(device, folder.file("s.bcc4"));
  const std::vector<double> at{3, 4, 5, 1.25, 8, 9, 10, 6.5, 12, 3, 7, 0};
  std::vector<std::vector<float>> values(thread_count, std::vector<float>(3));
  together([&](int i) {
    bccsplat_volume_retain(volume.get());
    // Cold caches first: all want the same coefficients.
    EXPECT_OK(bccsplat_volume_evaluate(volume.get(), 3, at.data(), values[i].data(), nullptr));
    auto info = sized<bccsplat_volume_info>();
    EXPECT_OK(bccsplat_volume_get_info(volume.get(), &info));
    auto channel = sized<bccsplat_channel_info>();
    EXPECT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &channel));
    double index = 0;
    EXPECT_OK(bccsplat_volume_time_to_index(volume.get(), 1 + i, &index));
    auto report = sized<bccsplat_verify_report>();
    EXPECT_OK(bccsplat_volume_verify(volume.get(), nullptr, nullptr, &report));
    EXPECT_EQ(report.damages, 0u);
    auto about = sized<bccsplat_device_info>();
    EXPECT_OK(bccsplat_device_get_info(device.get(), &about));
    // Each its own failure and its own text.
    const char* value = nullptr;
    const std::string key = "key" + std::to_string(i);
    EXPECT_EQ(bccsplat_volume_find_attribute(volume.get(), key.c_str(), &value), BCCSPLAT_ERROR_NOT_FOUND);
    EXPECT_NE(std::string(bccsplat_last_error()).find(key), std::string::npos);
    bccsplat_volume_release(volume.get());
  });
  for (const auto& v : values) EXPECT_EQ(v, values[0]);
}

TEST(Threads, SlicesAndPicturesOfOneVolume) {
  const Folder folder;
  const Device device = make_device(2);
  (void)write_series(device, folder.file("s.bcc4"));
  const Volume volume = open(device, folder.file("s.bcc4"));
  const Slice shared = cut_time(volume, 2.5);
  std::vector<std::vector<float>> dense(thread_count), pictures(thread_count);
  together([&](int i) {
    const size_t n = i;
    // Two kernels and two kinds of hyperplanes: the volume's caches are filled from all sides.
    const Slice own = i % 2 ? cut(volume, 0.3, 0.1, 0, 1, -6) : cut_time(volume, 2.5);
    dense[n].resize(20 * 19 * 18);
    EXPECT_OK(bccsplat_slice_sample_grid(shared.get(), nullptr, dense[n].data()));
    uint64_t points = 0;
    EXPECT_OK(bccsplat_slice_get_points(shared.get(), 0, nullptr, nullptr, &points));
    auto camera = sized<bccsplat_camera>();
    EXPECT_OK(bccsplat_slice_fit_camera(shared.get(), 0, 10, 20, 48, 32, &camera));
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    const Renderer renderer(r);
    EXPECT_OK(bccsplat_renderer_set_slice(r, own.get()));
    pictures[n].resize(48 * 32 * 4);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), 48, 32, pictures[n].data(), 0, &f));
    const Frame frame(f);
    EXPECT_OK(bccsplat_renderer_render(r, f));
    EXPECT_OK(bccsplat_renderer_set_slice(r, shared.get())); // its points are made once, by whoever is first
    EXPECT_OK(bccsplat_renderer_render(r, f));
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
  });
  for (size_t i = 1; i < thread_count; ++i) {
    EXPECT_EQ(dense[i], dense[0]);
    EXPECT_EQ(pictures[i], pictures[0]);
  }
}

// Writers, volumes and renderers of one device at once.
TEST(Threads, DifferentObjectsOfOneDevice) {
  const Folder folder;
  const Device device = make_device(3);
  (void)write_series(device, folder.file("shared.bcc4"));
  together([&](int i) {
    const std::string path = folder.file("own" + std::to_string(i) + ".bcc4");
    (void)write_series(device, path);
    const Volume volume = open(device, i % 2 ? path : folder.file("shared.bcc4"));
    const Slice slice = cut_time(volume, i);
    std::vector<float> dense(20 * 19 * 18);
    EXPECT_OK(bccsplat_slice_sample_grid(slice.get(), nullptr, dense.data()));
  });
  const auto size = std::filesystem::file_size(folder.file("shared.bcc4"));
  for (int i = 0; i < thread_count; ++i)
    EXPECT_EQ(std::filesystem::file_size(folder.file("own" + std::to_string(i) + ".bcc4")), size);
}

// Cancelling from elsewhere ends a render, or comes too late, or has nothing to end; it never does harm.
TEST(Threads, CancelAtAnyMoment) {
  const Folder folder;
  const Device device = make_device(2);
  (void)write_series(device, folder.file("s.bcc4"));
  const Slice slice = cut_time(open(device, folder.file("s.bcc4")), 2.5);
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  auto options = sized<bccsplat_render_options>();
  options.disable_skips = BCCSPLAT_SKIP_UNCHANGED; // every picture takes its time
  ASSERT_OK(bccsplat_renderer_set_options(r, &options));
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), 64, 64, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  std::atomic<bool> stop{false};
  std::thread canceller([&] {
    while (!stop) {
      EXPECT_OK(bccsplat_renderer_cancel(r));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  int ended = 0;
  for (int i = 0; i < 20; ++i) {
    const bccsplat_status status = bccsplat_renderer_render(r, f);
    EXPECT_TRUE(status == BCCSPLAT_OK || status == BCCSPLAT_CANCELLED) << bccsplat_last_error();
    ended += status == BCCSPLAT_CANCELLED;
  }
  stop = true;
  canceller.join();
  EXPECT_GT(ended, 0);
  EXPECT_OK(bccsplat_renderer_render(r, f));
}

} // namespace

// SPDX-License-Identifier: Apache-2.0
// Hosts of the C ABI in C++: handles that release themselves, and a small series to work on.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <unistd.h>

#include "../support/api_handles.h"
#include "../support/larger.h"

namespace host {

using bccsplat::larger;
using bccsplat::largest_difference;

using Device = Handle<bccsplat_device>;
using Writer = Handle<bccsplat_writer>;
using Volume = Handle<bccsplat_volume>;
using Slice = Handle<bccsplat_slice>;
using Renderer = Handle<bccsplat_renderer>;
using Frame = Handle<bccsplat_frame>;

#define ASSERT_OK(call) ASSERT_EQ((call), BCCSPLAT_OK) << bccsplat_last_error()
#define EXPECT_OK(call) EXPECT_EQ((call), BCCSPLAT_OK) << bccsplat_last_error()

[[nodiscard]] inline Device make_device(int threads = 2, uint64_t budget = 0) {
  auto o = sized<bccsplat_device_options>();
  o.thread_count = threads;
  o.memory_budget = budget;
  bccsplat_device* d = nullptr;
  EXPECT_OK(bccsplat_device_create(&o, &d));
  return Device(d);
}

// A directory of its own for the running test, removed at the end.
class Folder {
 public:
  Folder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() / ("bccsplat-" + std::string(info->test_suite_name()) +
                                                      "-" + info->name() + "-" + std::to_string(::getpid()));
    for (char& c : name_storage_ = path_.string())
      if (c == '+') c = '_';
    path_ = name_storage_;
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }
  // The same of a name that no file has yet: on some Windows what is open cannot be replaced.
  [[nodiscard]] std::string free_file(std::string name) const {
    while (std::filesystem::exists(path_ / name)) name = "another-" + name;
    return file(name);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::string name_storage_;
};

using Field = std::function<double(double x, double y, double z, double t)>;

// A moving smooth blob in air 0, values about 0 .. 100.
[[nodiscard]] inline double blob(double x, double y, double z, double t) {
  const double dx = x - 8 - 0.5 * t, dy = y - 10, dz = z - 9 + 0.2 * t;
  return 100 * std::exp(-(dx * dx + dy * dy + dz * dz) / 18);
}

struct Series {
  uint32_t nx = 20, ny = 19, nz = 18, nt = 8;
  double first = 0, step = 1;
  Field field = blob;
  std::vector<double> times{}; // instead of first and step
};

// All frames of a series as float boxes into a writer.
inline bccsplat_status add_frames(bccsplat_writer* writer, const Series& s, uint32_t channel = 0) {
  std::vector<float> frame(size_t{s.nx} * s.ny * s.nz);
  for (uint32_t t = 0; t < s.nt; ++t) {
    size_t i = 0;
    for (uint32_t z = 0; z < s.nz; ++z)
      for (uint32_t y = 0; y < s.ny; ++y)
        for (uint32_t x = 0; x < s.nx; ++x) frame[i++] = static_cast<float>(s.field(x, y, z, t));
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_F32;
    box.data = frame.data();
    box.dims[0] = s.nx, box.dims[1] = s.ny, box.dims[2] = s.nz;
    const double time = s.times.empty() ? s.first + s.step * t : s.times[t];
    const bccsplat_status status = bccsplat_writer_add_frame(writer, channel, time, &box, 1);
    if (status != BCCSPLAT_OK) return status;
  }
  return BCCSPLAT_OK;
}

[[nodiscard]] inline bccsplat_writer_options options_of(const Series& s) {
  auto o = sized<bccsplat_writer_options>();
  o.dims[0] = s.nx, o.dims[1] = s.ny, o.dims[2] = s.nz, o.dims[3] = s.nt;
  return o;
}

[[nodiscard]] inline Writer make_writer(const Device& device, const std::string& path,
                                        const bccsplat_writer_options& o) {
  bccsplat_writer* w = nullptr;
  EXPECT_OK(bccsplat_writer_create(device.get(), path.c_str(), &o, &w));
  return Writer(w);
}

inline bccsplat_writer_report write_series(const Device& device, const std::string& path,
                                           const Series& s = {}) {
  auto report = sized<bccsplat_writer_report>();
  const Writer w = make_writer(device, path, options_of(s));
  EXPECT_OK(add_frames(w.get(), s));
  EXPECT_OK(bccsplat_writer_finish(w.get(), &report));
  return report;
}

[[nodiscard]] inline Volume open(const Device& device, const std::string& path,
                                 const char* kernel = nullptr) {
  auto o = sized<bccsplat_volume_options>();
  o.kernel = kernel;
  bccsplat_volume* v = nullptr;
  EXPECT_OK(bccsplat_volume_open_file(device.get(), path.c_str(), &o, &v));
  return Volume(v);
}

[[nodiscard]] inline Slice cut(const Volume& volume, double a, double b, double c, double d, double e) {
  auto h = sized<bccsplat_hyperplane>();
  h.a = a, h.b = b, h.c = c, h.d = d, h.e = e;
  bccsplat_slice* s = nullptr;
  EXPECT_OK(bccsplat_slice_create(volume.get(), &h, nullptr, &s));
  return Slice(s);
}
[[nodiscard]] inline Slice cut_time(const Volume& volume, double frame) {
  return cut(volume, 0, 0, 0, 1, -frame);
}

} // namespace host

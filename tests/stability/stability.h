// SPDX-License-Identifier: Apache-2.0
// What the stability tests share: volumes in memory, made and read through the C ABI, pictures of them.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>

#include "tests/api/support.h"

namespace host {

// A bound that a test holds: the largest error it saw is printed beside what is allowed, as a row of a table.
// It fails where no error was added, as nothing was looked at then.
class Bound {
 public:
  Bound(const std::string& name, double asked) : name_(name), asked_(asked) {}
  ~Bound() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    std::printf("| %s.%s | %s | %.2g | %.2g |\n", test->test_suite_name(), test->name(), name_.c_str(),
                reached_, asked_);
    EXPECT_LE(reached_, asked_) << name_;
    EXPECT_TRUE(added_) << name_ << ": nothing was compared";
  }
  Bound(const Bound&) = delete;
  Bound& operator=(const Bound&) = delete;
  void add(double error) { reached_ = larger(reached_, std::abs(error)), added_ = true; }

 private:
  std::string name_;
  double asked_, reached_ = 0;
  bool added_ = false;
};

[[nodiscard]] inline std::string shown(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", value);
  return buffer;
}

struct MemoryFile {
  std::vector<unsigned char> bytes;
};

inline int64_t append_at(void* user, uint64_t offset, const void* data, uint64_t size) {
  auto& bytes = static_cast<MemoryFile*>(user)->bytes;
  if (bytes.size() < offset + size) bytes.resize(offset + size);
  std::memcpy(bytes.data() + offset, data, size);
  return size;
}

// A volume and the bytes it reads.
struct Stored {
  std::unique_ptr<MemoryFile> file = std::make_unique<MemoryFile>();
  Volume volume;
};

[[nodiscard]] inline Writer make_writer(const Device& device, MemoryFile& file,
                                        const bccsplat_writer_options& o) {
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = append_at;
  stream.user = &file;
  bccsplat_writer* w = nullptr;
  EXPECT_OK(bccsplat_writer_create_stream(device.get(), &stream, &o, &w));
  return Writer(w);
}

[[nodiscard]] inline Stored store(const Device& device, const Series& s, const bccsplat_writer_options& o,
                                  const char* kernel = nullptr) {
  Stored stored;
  const Writer writer = make_writer(device, *stored.file, o);
  EXPECT_OK(add_frames(writer.get(), s));
  EXPECT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  auto v = sized<bccsplat_volume_options>();
  v.kernel = kernel;
  bccsplat_volume* volume = nullptr;
  EXPECT_OK(bccsplat_volume_open_memory(device.get(), stored.file->bytes.data(), stored.file->bytes.size(),
                                        &v, &volume));
  stored.volume.reset(volume);
  return stored;
}

[[nodiscard]] inline Stored store(const Device& device, const Series& s, const char* kernel = nullptr) {
  return store(device, s, options_of(s), kernel);
}

// n random points of the domain, n x 4.
[[nodiscard]] inline std::vector<double> random_points(const Series& s, size_t n, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<double> points;
  for (size_t i = 0; i < n; ++i)
    for (const uint32_t dim : {s.nx, s.ny, s.nz, s.nt}) points.push_back(unit(random) * (dim - 1));
  return points;
}

[[nodiscard]] inline std::vector<float> values_at(const Volume& volume, const std::vector<double>& points) {
  std::vector<float> values(points.size() / 4);
  EXPECT_OK(bccsplat_volume_evaluate(volume.get(), values.size(), points.data(), values.data(), nullptr));
  return values;
}

[[nodiscard]] inline std::vector<float> grid_of(const Slice& slice) {
  auto info = sized<bccsplat_slice_info>();
  EXPECT_OK(bccsplat_slice_get_info(slice.get(), &info));
  std::vector<float> values(info.dims[0] * info.dims[1] * info.dims[2]);
  EXPECT_OK(bccsplat_slice_sample_grid(slice.get(), nullptr, values.data()));
  return values;
}

// Grey, opacity rising from `low` to `high` by `opacity` per unit length.
struct Ramp {
  double low = 0, high = 1, opacity = 0.1, unit = 1;
};

struct Shot {
  uint32_t width = 48, height = 48;
  Ramp ramp;
  const bccsplat_camera* camera = nullptr;
  bccsplat_render_options options = sized<bccsplat_render_options>();
  const bccsplat_trail* trail = nullptr;
  bool own_look = false;                                // the volume's instead of the ramp
  const bccsplat_transfer_function* function = nullptr; // likewise
};

[[nodiscard]] inline std::vector<float> picture(const Device& device, const Slice& slice, const Shot& shot) {
  bccsplat_renderer* r = nullptr;
  EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  const double colors[] = {shot.ramp.low, 1, 1, 1, shot.ramp.high, 1, 1, 1};
  const double opacities[] = {shot.ramp.low, 0, shot.ramp.high, shot.ramp.opacity};
  auto function = sized<bccsplat_transfer_function>();
  function.colors = colors, function.color_count = 2;
  function.opacities = opacities, function.opacity_count = 2;
  function.unit_distance = shot.ramp.unit;
  EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  if (shot.function) function = *shot.function;
  EXPECT_OK(bccsplat_renderer_set_transfer_function(r, shot.own_look ? nullptr : &function));
  EXPECT_OK(bccsplat_renderer_set_camera(r, shot.camera));
  EXPECT_OK(bccsplat_renderer_set_options(r, &shot.options));
  EXPECT_OK(bccsplat_renderer_set_trail(r, shot.trail));
  bccsplat_frame* f = nullptr;
  EXPECT_OK(bccsplat_frame_create(device.get(), shot.width, shot.height, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  EXPECT_OK(bccsplat_renderer_render(r, f));
  auto plane = sized<bccsplat_plane>();
  EXPECT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
  std::vector<float> rgba;
  for (uint32_t y = 0; y < plane.height; ++y) {
    const auto* row =
        reinterpret_cast<const float*>(reinterpret_cast<const char*>(plane.pixels) + y * plane.row_bytes);
    rgba.insert(rgba.end(), row, row + size_t{4} * plane.width);
  }
  return rgba;
}

[[nodiscard]] inline bool all_finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

} // namespace host

// SPDX-License-Identifier: Apache-2.0
// Files in memory through the C ABI, for tests of bounds and stores.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "bccsplat.h"

#include "../support/larger.h"

namespace bccsplat::test {

template<class T> T sized() {
  T value;
  std::memset(&value, 0, sizeof value);
  value.struct_size = sizeof value;
  return value;
}

struct TestDevice {
  explicit TestDevice(int threads = 2) {
    auto options = sized<bccsplat_device_options>();
    options.thread_count = threads;
    EXPECT_EQ(bccsplat_device_create(&options, &device), BCCSPLAT_OK);
  }
  ~TestDevice() { bccsplat_device_release(device); }
  bccsplat_device* device = nullptr;
};

using Bytes = std::vector<unsigned char>;

inline int64_t write_bytes(void* user, uint64_t offset, const void* data, uint64_t size) {
  auto& bytes = *static_cast<Bytes*>(user);
  if (bytes.size() < offset + size) bytes.resize(offset + size);
  std::memcpy(bytes.data() + offset, data, size);
  return size;
}

// A source series of any type; values in double, which the type holds exactly.
struct Source {
  std::array<uint32_t, 4> dims{};
  int32_t type = BCCSPLAT_TYPE_F32;
  double air = 0, threshold = 0;
  std::vector<double> values; // x fastest
  [[nodiscard]] size_t frame_samples() const { return size_t{dims[0]} * dims[1] * dims[2]; }
};

using FieldFunction = std::function<double(double x, double y, double z, double t)>;

template<class T> void store_as(const std::vector<double>& from, size_t first, size_t count, Bytes& to) {
  to.resize(count * sizeof(T));
  for (size_t i = 0; i < count; ++i) {
    const auto v = static_cast<T>(from[first + i]);
    std::memcpy(to.data() + i * sizeof(T), &v, sizeof(T));
  }
}

inline Source source_of(std::array<uint32_t, 4> dims, int32_t type, const FieldFunction& f) {
  Source s{dims, type, 0, 0, {}};
  for (uint32_t t = 0; t < dims[3]; ++t)
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x) {
          double v = f(x, y, z, t);
          if (type == BCCSPLAT_TYPE_F32) v = static_cast<float>(v);
          if (type != BCCSPLAT_TYPE_F32 && type != BCCSPLAT_TYPE_F64) v = std::nearbyint(v);
          s.values.push_back(v);
        }
  return s;
}

inline Bytes frame_bytes(const Source& s, uint32_t t) {
  Bytes data;
  const size_t n = s.frame_samples(), first = t * n;
  if (s.type == BCCSPLAT_TYPE_U8) store_as<uint8_t>(s.values, first, n, data);
  if (s.type == BCCSPLAT_TYPE_U16) store_as<uint16_t>(s.values, first, n, data);
  if (s.type == BCCSPLAT_TYPE_I16) store_as<int16_t>(s.values, first, n, data);
  if (s.type == BCCSPLAT_TYPE_I32) store_as<int32_t>(s.values, first, n, data);
  if (s.type == BCCSPLAT_TYPE_F32) store_as<float>(s.values, first, n, data);
  if (s.type == BCCSPLAT_TYPE_F64) store_as<double>(s.values, first, n, data);
  return data;
}

struct Written {
  bccsplat_status status = BCCSPLAT_OK;
  std::string text; // of a failure
  Bytes bytes;
  bccsplat_writer_report report = sized<bccsplat_writer_report>();
  bccsplat_error_report error = sized<bccsplat_error_report>(); // of the series, when measured
  std::vector<bccsplat_error_report> frames;
};

// Runs `feed` on a writer of one channel and finishes it. options: dims, channels and the stream are set
// here.
inline Written write_with(const TestDevice& device, const Source& s, bccsplat_writer_options options,
                          bccsplat_channel_options channel,
                          const std::function<bccsplat_status(bccsplat_writer*)>& feed) {
  Written w;
  std::copy(s.dims.begin(), s.dims.end(), options.dims);
  channel.set_mask |= BCCSPLAT_CHANNEL_SET_AIR;
  channel.air = s.air, channel.air_threshold = s.threshold;
  options.channels = &channel, options.channel_count = 1;
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = write_bytes, stream.user = &w.bytes;
  bccsplat_writer* writer = nullptr;
  w.status = bccsplat_writer_create_stream(device.device, &stream, &options, &writer);
  if (w.status == BCCSPLAT_OK) w.status = feed(writer);
  if (w.status == BCCSPLAT_OK) w.status = bccsplat_writer_finish(writer, &w.report);
  if (w.status != BCCSPLAT_OK) w.text = bccsplat_last_error();
  if (w.status == BCCSPLAT_OK && w.report.frames_measured > 0) {
    EXPECT_EQ(bccsplat_writer_get_error(writer, 0, -1, &w.error), BCCSPLAT_OK);
    for (uint64_t i = 0; i < w.report.frames_measured; ++i) {
      w.frames.push_back(sized<bccsplat_error_report>());
      EXPECT_EQ(bccsplat_writer_get_error(writer, 0, i, &w.frames.back()), BCCSPLAT_OK);
    }
  }
  bccsplat_writer_release(writer);
  return w;
}

inline bccsplat_status feed_frames(const Source& s, bccsplat_writer* writer) {
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const Bytes data = frame_bytes(s, t);
    auto box = sized<bccsplat_box>();
    box.type = s.type, box.data = data.data();
    for (size_t a = 0; a < 3; ++a) box.dims[a] = s.dims[a];
    const bccsplat_status status = bccsplat_writer_add_frame(writer, 0, t, &box, 1);
    if (status != BCCSPLAT_OK) return status;
  }
  return BCCSPLAT_OK;
}

inline Written write_frames(const TestDevice& device, const Source& s,
                            const bccsplat_writer_options& options = sized<bccsplat_writer_options>(),
                            const bccsplat_channel_options& channel = sized<bccsplat_channel_options>()) {
  return write_with(device, s, options, channel, [&](bccsplat_writer* w) { return feed_frames(s, w); });
}

struct OpenVolume {
  OpenVolume(const TestDevice& device, const Bytes& bytes, const char* kernel = nullptr) {
    auto options = sized<bccsplat_volume_options>();
    options.kernel = kernel;
    status = bccsplat_volume_open_memory(device.device, bytes.data(), bytes.size(), &options, &volume);
  }
  ~OpenVolume() { bccsplat_volume_release(volume); }
  OpenVolume(const OpenVolume&) = delete;
  OpenVolume& operator=(const OpenVolume&) = delete;

  // The source samples of a frame as a slice gives them.
  [[nodiscard]] std::vector<float> frame(double t) const {
    auto plane = sized<bccsplat_hyperplane>();
    plane.d = 1, plane.e = -t;
    bccsplat_slice* slice = nullptr;
    EXPECT_EQ(bccsplat_slice_create(volume, &plane, nullptr, &slice), BCCSPLAT_OK) << bccsplat_last_error();
    auto info = sized<bccsplat_slice_info>();
    EXPECT_EQ(bccsplat_slice_get_info(slice, &info), BCCSPLAT_OK);
    std::vector<float> values(info.dims[0] * info.dims[1] * info.dims[2]);
    EXPECT_EQ(bccsplat_slice_sample_grid(slice, nullptr, values.data()), BCCSPLAT_OK);
    bccsplat_slice_release(slice);
    return values;
  }
  // NaN where there is no value.
  [[nodiscard]] std::vector<float> at(const std::vector<std::array<double, 4>>& points) const {
    std::vector<float> values(points.size());
    (void)bccsplat_volume_evaluate(volume, points.size(), points.data()->data(), values.data(), nullptr);
    return values;
  }
  bccsplat_volume* volume = nullptr;
  bccsplat_status status = BCCSPLAT_OK;
};

// A slice of one.
struct Cut {
  Cut(const OpenVolume& volume, std::array<double, 5> h,
      bccsplat_slice_options options = sized<bccsplat_slice_options>()) {
    auto plane = sized<bccsplat_hyperplane>();
    plane.a = h[0], plane.b = h[1], plane.c = h[2], plane.d = h[3], plane.e = h[4];
    EXPECT_EQ(bccsplat_slice_create(volume.volume, &plane, &options, &slice), BCCSPLAT_OK)
        << bccsplat_last_error();
    EXPECT_EQ(bccsplat_slice_get_info(slice, &info), BCCSPLAT_OK);
  }
  ~Cut() { bccsplat_slice_release(slice); }
  Cut(const Cut&) = delete;
  Cut& operator=(const Cut&) = delete;

  [[nodiscard]] std::vector<float> samples() const {
    std::vector<float> values(info.dims[0] * info.dims[1] * info.dims[2]);
    EXPECT_EQ(bccsplat_slice_sample_grid(slice, nullptr, values.data()), BCCSPLAT_OK);
    return values;
  }
  // Index space of the n-th of samples().
  [[nodiscard]] std::array<double, 4> place(size_t n) const {
    const std::array<double, 3> uvw{info.extent[0][0] + double(n % info.dims[0]),
                                    info.extent[1][0] + double(n / info.dims[0] % info.dims[1]),
                                    info.extent[2][0] + double(n / (info.dims[0] * info.dims[1]))};
    std::array<double, 4> p{};
    for (size_t a = 0; a < 4; ++a) {
      p[a] = info.origin[a];
      for (size_t k = 0; k < 3; ++k) p[a] += info.basis[k][a] * uvw[k];
    }
    return p;
  }
  bccsplat_slice* slice = nullptr;
  bccsplat_slice_info info = sized<bccsplat_slice_info>();
};

// Largest difference from the finite source samples: through slices, and through evaluate. Infinite where a
// finite sample has no value.
struct LargestError {
  double slices = 0, points = 0;
};
inline LargestError largest_error(const OpenVolume& volume, const Source& s) {
  LargestError largest;
  const auto worse = [](double& most, float got, double want) {
    if (!std::isfinite(want)) return;
    most = larger(most, std::fabs(got - want));
  };
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const std::vector<float> slice = volume.frame(t);
    std::vector<std::array<double, 4>> points;
    for (uint32_t z = 0; z < s.dims[2]; ++z)
      for (uint32_t y = 0; y < s.dims[1]; ++y)
        for (uint32_t x = 0; x < s.dims[0]; ++x)
          points.push_back({double(x), double(y), double(z), double(t)});
    const std::vector<float> at = volume.at(points);
    for (size_t i = 0; i < s.frame_samples(); ++i) {
      worse(largest.slices, slice[i], s.values[t * s.frame_samples() + i]);
      worse(largest.points, at[i], s.values[t * s.frame_samples() + i]);
    }
  }
  return largest;
}

} // namespace bccsplat::test

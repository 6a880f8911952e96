// SPDX-License-Identifier: Apache-2.0
// Planes in the host's memory get what a frame of its own gets, rows from the bottom up as well, and nothing
// is written between them.
#include <algorithm>
#include <cstring>

#include "support.h"

namespace host {
namespace {

constexpr uint32_t plane_width = 40, plane_height = 27;
constexpr size_t row_gap = 5; // floats between rows
constexpr float not_written = -777;

struct PlaneChannel {
  uint32_t bit;
  size_t components;
};
constexpr std::array<PlaneChannel, 4> plane_channels{{{BCCSPLAT_FRAME_RGBA, 4},
                                                      {BCCSPLAT_FRAME_DEPTH, 1},
                                                      {BCCSPLAT_FRAME_VALUE, 1},
                                                      {BCCSPLAT_FRAME_TIME, 1}}};

class HostPlanes : public testing::Test {
 protected:
  void SetUp() override {
    write_series(device_, folder_.file("s.bcc4"));
    volume_ = open(device_, folder_.file("s.bcc4"));
    slice_ = cut_time(volume_, 3.5);
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device_.get(), &r));
    renderer_.reset(r);
    ASSERT_OK(bccsplat_renderer_set_slice(r, slice_.get()));
  }
  [[nodiscard]] Frame own() const {
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_create(device_.get(), plane_width, plane_height, 15, &f));
    return Frame(f);
  }
  [[nodiscard]] static std::vector<float> rows_of(const Frame& frame, const PlaneChannel& c) {
    std::vector<float> out(plane_width * plane_height * c.components);
    EXPECT_OK(bccsplat_frame_copy(frame.get(), c.bit, BCCSPLAT_PIXELS_F32, out.data(), 0));
    return out;
  }

  const Folder folder_;
  Device device_ = make_device();
  Volume volume_;
  Slice slice_;
  Renderer renderer_;
};

bool same_floats(const float* a, const float* b, size_t n) {
  return std::memcmp(a, b, n * sizeof(float)) == 0;
}

TEST_F(HostPlanes, HoldWhatAFrameOfItsOwnHolds) {
  const Frame reference = own();
  ASSERT_OK(bccsplat_renderer_render(renderer_.get(), reference.get()));
  for (const bool up : {false, true}) {
    std::array<std::vector<float>, 4> memory;
    std::array<bccsplat_host_plane, 4> planes{};
    for (size_t n = 0; n < plane_channels.size(); ++n) {
      const size_t row = plane_width * plane_channels[n].components + row_gap;
      memory[n].assign(row * plane_height, not_written);
      const auto bytes = static_cast<int64_t>(row * sizeof(float));
      planes[n] = {plane_channels[n].bit, 0, memory[n].data() + (up ? row * (plane_height - 1) : 0),
                   up ? -bytes : bytes};
    }
    bccsplat_frame* f = nullptr;
    ASSERT_OK(bccsplat_frame_wrap_planes(device_.get(), plane_width, plane_height, planes.data(),
                                         planes.size(), &f));
    const Frame wrapped(f);
    ASSERT_OK(bccsplat_renderer_render(renderer_.get(), f));
    for (size_t n = 0; n < plane_channels.size(); ++n) {
      const size_t floats = plane_width * plane_channels[n].components;
      const std::vector<float> expected = rows_of(reference, plane_channels[n]);
      EXPECT_TRUE(same_floats(rows_of(wrapped, plane_channels[n]).data(), expected.data(), expected.size()));
      for (size_t y = 0; y < plane_height; ++y) {
        const float* const row = memory[n].data() + (floats + row_gap) * (up ? plane_height - 1 - y : y);
        ASSERT_TRUE(same_floats(row, expected.data() + floats * y, floats)) << n << " " << y;
        ASSERT_EQ(std::count(row + floats, row + floats + row_gap, not_written),
                  static_cast<int64_t>(row_gap));
      }
      auto plane = sized<bccsplat_plane>();
      ASSERT_OK(bccsplat_frame_get_channel(f, plane_channels[n].bit, &plane));
      EXPECT_EQ(plane.pixels, planes[n].pixels);
      EXPECT_EQ(static_cast<int64_t>(plane.row_bytes), planes[n].row_bytes);
    }
    // Images of both are the same bytes.
    if (std::string(bccsplat_build_info()).find("image=none") != std::string::npos) continue;
    for (const bccsplat_image as : {BCCSPLAT_IMAGE_PNG, BCCSPLAT_IMAGE_EXR}) {
      std::vector<char> a(1 << 20), b(1 << 20);
      uint64_t a_size = 0, b_size = 0;
      ASSERT_OK(bccsplat_frame_save_memory(reference.get(), as, nullptr, a.data(), a.size(), &a_size));
      ASSERT_OK(bccsplat_frame_save_memory(f, as, nullptr, b.data(), b.size(), &b_size));
      a.resize(a_size), b.resize(b_size);
      EXPECT_EQ(a, b) << "image " << as;
    }
  }
}

// Edges of an isosurface are drawn again, into rows from the bottom up, too.
TEST_F(HostPlanes, EdgesAreSmoothedInThem) {
  auto options = sized<bccsplat_render_options>();
  options.mode = BCCSPLAT_MODE_ISOSURFACE, options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 40;
  ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &options));
  const Frame reference = own();
  ASSERT_OK(bccsplat_renderer_render(renderer_.get(), reference.get()));
  std::vector<float> memory(size_t{4} * plane_width * plane_height);
  const bccsplat_host_plane plane{BCCSPLAT_FRAME_RGBA, 0,
                                  memory.data() + size_t{4} * plane_width * (plane_height - 1),
                                  -int64_t{16} * plane_width};
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_wrap_planes(device_.get(), plane_width, plane_height, &plane, 1, &f));
  const Frame wrapped(f);
  ASSERT_OK(bccsplat_renderer_render(renderer_.get(), f));
  EXPECT_EQ(rows_of(wrapped, plane_channels[0]), rows_of(reference, plane_channels[0]));
}

TEST_F(HostPlanes, WhatIsNotGivenIsTheFramesOwn) {
  std::vector<float> depth(plane_width * plane_height, not_written);
  const std::array<bccsplat_host_plane, 3> planes{{{BCCSPLAT_FRAME_DEPTH, 0, depth.data(), 0},
                                                   {BCCSPLAT_FRAME_VALUE, 0, nullptr, 0},
                                                   {BCCSPLAT_FRAME_DEEP, 0, nullptr, 0}}};
  auto before = sized<bccsplat_device_info>(), after = before;
  ASSERT_OK(bccsplat_device_get_info(device_.get(), &before));
  bccsplat_frame* f = nullptr;
  ASSERT_OK(
      bccsplat_frame_wrap_planes(device_.get(), plane_width, plane_height, planes.data(), planes.size(), &f));
  const Frame wrapped(f);
  ASSERT_OK(bccsplat_device_get_info(device_.get(), &after));
  EXPECT_EQ(after.memory_used - before.memory_used, uint64_t{5} * sizeof(float) * plane_width * plane_height);
  ASSERT_OK(bccsplat_renderer_render(renderer_.get(), f));
  EXPECT_EQ(std::count(depth.begin(), depth.end(), not_written), 0);
  auto deep = sized<bccsplat_deep>();
  ASSERT_OK(bccsplat_frame_get_deep(f, &deep));
  EXPECT_GT(deep.sample_count, 0u);
  auto plane = sized<bccsplat_plane>();
  EXPECT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
  EXPECT_EQ(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_TIME, &plane), BCCSPLAT_ERROR_NOT_FOUND);
}

} // namespace
} // namespace host

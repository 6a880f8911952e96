// SPDX-License-Identifier: Apache-2.0
// What an import holds.
#include <gtest/gtest.h>

#include <random>

#include "store/volume_writer.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat {
namespace {

using test::Bench;

struct Held {
  double largest = 0; // bytes a voxel of a frame
  uint64_t at_end = 0;
};

// A dense series of bytes, of which bricks are filled to their faces.
Held held_by_import(uint32_t frames, int levels = 0) {
  const std::array<uint32_t, 4> dims{62, 62, 62, frames};
  const size_t voxels = size_t{dims[0]} * dims[1] * dims[2];
  WriterSettings settings;
  settings.dims = dims, settings.levels = levels;
  Bench bench;
  std::vector<std::byte> file;
  std::mt19937 random(5);
  std::vector<uint8_t> values(voxels);
  {
    VolumeWriter writer(settings, create_memory_sink(file), bench.context);
    for (uint32_t t = 0; t < frames; ++t) {
      for (uint8_t& v : values) v = static_cast<uint8_t>(1 + random() % 255);
      FrameBox box;
      box.data = values.data(), box.type = SourceType::u8, box.dims = {dims[0], dims[1], dims[2]};
      writer.add_frame(0, t, {&box, 1});
    }
    (void)writer.finish();
  }
  return {static_cast<double>(bench.memory.peak()) / static_cast<double>(voxels), bench.memory.used()};
}

// Eight frames in reach of the filter take 17 bytes a voxel, a slab of codes 4 and what it is coded with 1.
TEST(ImportMemory, AVoxelTakesTheFramesInReach) {
  const Held held = held_by_import(22);
  EXPECT_LT(held.largest, 22.6);
  EXPECT_EQ(held.at_end, 0u);
}

// A level takes an eighth as much, and its frames are floats; the frame that it is made of has gone when
// level 0 takes its memory: with it they would take half a byte more.
TEST(ImportMemory, LevelsTakeTheirShare) {
  const Held alone = held_by_import(22), with = held_by_import(22, 2);
  EXPECT_LT(with.largest - alone.largest, 5.8);
  EXPECT_EQ(with.at_end, 0u);
}

// Layers beyond the last one need no more at once. (A brick with a site of air has a mask.)
TEST(ImportMemory, DoesNotGrowWithTheSeries) {
  EXPECT_NEAR(held_by_import(22).largest, held_by_import(36).largest, 0.02);
}

} // namespace
} // namespace bccsplat

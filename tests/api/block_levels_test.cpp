// SPDX-License-Identifier: Apache-2.0
// Coarser levels of a series that was written in blocks of space: no writer has measured them, and whoever
// joins the blocks may ask for a comparison with level 0.
#include <cmath>
#include <fstream>
#include <iterator>

#include "support.h"

namespace host {
namespace {

constexpr uint32_t wide = 110, high = 105, deep = 100, level_frames = 2;

// Waves of 5 to 60 samples within a ball.
double ball_of_waves(double x, double y, double z, double t) {
  const double dx = x - 55, dy = y - 52, dz = z - 50, r2 = dx * dx + dy * dy + dz * dz;
  const double wave = 60 * std::sin(.11 * x + .3 * t) + 40 * std::cos(.31 * y + .1 * z) +
                      20 * std::sin(.8 * z + .9 * x - t) * std::exp(-r2 / 900);
  return 300 * std::exp(-r2 * r2 / 1e6) * (1 + wave / 300);
}

class BlockLevels : public ::testing::Test {
 protected:
  // Writes the block of samples z0 .. z1 - 1.
  void write_block(uint64_t z0, uint64_t z1) {
    auto channel = sized<bccsplat_channel_options>();
    channel.source_type = BCCSPLAT_TYPE_F32, channel.value_type = BCCSPLAT_TYPE_U16;
    channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR | BCCSPLAT_CHANNEL_SET_RANGE, channel.range[1] = 450;
    const std::vector<double> times{0, 1};
    auto part = sized<bccsplat_series_part>();
    part.end = level_frames, part.times = times.data();
    part.box_end[0] = wide, part.box_end[1] = high, part.box_begin[2] = z0, part.box_end[2] = z1;
    auto o = sized<bccsplat_writer_options>();
    o.dims[0] = wide, o.dims[1] = high, o.dims[2] = deep, o.dims[3] = level_frames;
    o.fixed_predictions = 1, o.levels = 2, o.part = &part, o.overwrite = 1;
    o.channels = &channel, o.channel_count = 1;
    names_.push_back(folder_.file("block" + std::to_string(z0) + ".bcc4"));
    const Writer w = make_writer(device_, names_.back(), o);
    std::array<uint64_t, 3> begin{}, end{};
    ASSERT_OK(bccsplat_writer_get_part_box(w.get(), begin.data(), end.data()));
    for (uint32_t t = 0; t < level_frames; ++t) {
      std::vector<float> values;
      for (uint64_t z = begin[2]; z < end[2]; ++z)
        for (uint64_t y = begin[1]; y < end[1]; ++y)
          for (uint64_t x = begin[0]; x < end[0]; ++x)
            values.push_back(static_cast<float>(ball_of_waves(double(x), double(y), double(z), t)));
      auto box = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
      for (size_t a = 0; a < 3; ++a)
        box.begin[a] = static_cast<int64_t>(begin[a]), box.dims[a] = static_cast<int64_t>(end[a] - begin[a]);
      ASSERT_OK(bccsplat_writer_add_frame(w.get(), 0, t, &box, 1));
    }
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  }

  [[nodiscard]] std::string join(const char* name, bool compare) {
    std::vector<const char*> paths;
    for (const std::string& n : names_) paths.push_back(n.c_str());
    auto o = sized<bccsplat_join_options>();
    o.overwrite = 1, o.compare_levels = compare ? 1 : 0;
    const std::string path = folder_.file(name);
    EXPECT_OK(bccsplat_join_parts(device_.get(), paths.size(), paths.data(), path.c_str(), &o, nullptr));
    names_.clear();
    return path;
  }

  // Returns what the file tells of a level; 0: nothing.
  [[nodiscard]] double told(const std::string& path, uint32_t level) const {
    auto info = sized<bccsplat_level_info>();
    EXPECT_OK(bccsplat_volume_get_level_info(open(device_, path).get(), level, &info));
    return info.relative_rmse;
  }

  [[nodiscard]] std::vector<float> samples(const Volume& volume, double frame, uint32_t level) const {
    const bccsplat_hyperplane plane{sizeof plane, 0, 0, 0, 0, 1, -frame};
    auto o = sized<bccsplat_slice_options>();
    o.level = level;
    bccsplat_slice* raw = nullptr;
    EXPECT_OK(bccsplat_slice_create(volume.get(), &plane, &o, &raw));
    const Slice slice(raw);
    bccsplat_grid grid{sizeof grid, 0, {0, 0, 0}, {5, 5, 5}, {wide / 5, high / 5, deep / 5}};
    std::vector<float> values(size_t{wide / 5} * (high / 5) * (deep / 5));
    EXPECT_OK(bccsplat_slice_sample_grid(slice.get(), &grid, values.data()));
    return values;
  }

  // Returns how far a level is from level 0 all over its frames, in the range of the source.
  [[nodiscard]] double measured(const std::string& path, uint32_t level) const {
    const Volume volume = open(device_, path);
    auto channel = sized<bccsplat_channel_info>();
    EXPECT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &channel));
    double squares = 0, count = 0;
    for (uint32_t t = 0; t < level_frames; ++t) {
      const std::vector<float> fine = samples(volume, t, 0), coarse = samples(volume, t, level);
      for (size_t i = 0; i < fine.size(); ++i)
        squares += std::pow(double(fine[i]) - double(coarse[i]), 2), count += 1;
    }
    return std::sqrt(squares / count) / (channel.range[1] - channel.range[0]);
  }

  Device device_ = make_device();
  Folder folder_;
  std::vector<std::string> names_;
};

std::vector<char> read_all(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(BlockLevels, TellWhatTheyLoseWhereTheJoinComparesThem) {
  write_block(0, 50), write_block(50, deep);
  const std::string path = join("two.bcc4", true);
  for (const uint32_t level : {1u, 2u}) {
    const double truth = measured(path, level);
    EXPECT_GT(truth, 1e-4);
    EXPECT_GT(told(path, level), .6 * truth) << level;
    EXPECT_LT(told(path, level), 1.6 * truth) << level;
  }
  EXPECT_EQ(told(path, 0), 0); // nothing is compared with the source
}

TEST_F(BlockLevels, TellTheSameHoweverTheSeriesWasDivided) {
  write_block(0, 41), write_block(41, 70), write_block(70, deep);
  const std::string three = join("three.bcc4", true);
  write_block(0, deep);
  EXPECT_TRUE(read_all(three) == read_all(join("one.bcc4", true)));
}

TEST_F(BlockLevels, TellNothingUnasked) {
  write_block(0, 50), write_block(50, deep);
  const std::string path = join("plain.bcc4", false);
  EXPECT_EQ(told(path, 1), 0);
  EXPECT_EQ(told(path, 2), 0);
}

} // namespace
} // namespace host

// SPDX-License-Identifier: Apache-2.0
// A series that one writer writes, or several, each a block of space of it, whose files are joined.
#pragma once

#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include "support.h"

namespace host::block_series {

using Box = std::array<std::array<uint64_t, 3>, 2>; // begin, end

// What one writer, or each of several, is asked for.
struct Asked {
  std::array<uint32_t, 4> dims{64, 40, 36, 9};
  bccsplat_type type = BCCSPLAT_TYPE_U8;
  bccsplat_writer_options options = sized<bccsplat_writer_options>();
  bccsplat_channel_options channel = sized<bccsplat_channel_options>();
  std::function<bool(double x, double y, double z, uint32_t t)> missing; // none: no sample is
  bool waves = false; // through all of space, in place of a blob

  Asked() {
    options.fixed_predictions = 1;
    channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
    channel.air = 3;
  }
  [[nodiscard]] bccsplat_writer_options writer_options() {
    std::copy(dims.begin(), dims.end(), options.dims);
    channel.source_type = type;
    options.channels = &channel, options.channel_count = 1, options.overwrite = 1;
    return options;
  }
};

// A blob that moves through air of 3, or waves, rough so that nothing is the same in two places.
inline double rough(const Asked& a, uint64_t x, uint64_t y, uint64_t z, uint32_t t) {
  const double dx = static_cast<double>(x) - .4 * a.dims[0] - 3 * t, dy = static_cast<double>(y) - 20,
               dz = static_cast<double>(z) - 17;
  const double smooth = 180 * std::exp(-(dx * dx / 600 + dy * dy / 150 + dz * dz / 90));
  const uint64_t mixed = (x * 7919 + y * 104729 + z * 1299709 + t * 15485863) * 2654435761u % 1024;
  const double noise = static_cast<double>(mixed) / 64;
  if (a.waves) {
    const double px = static_cast<double>(x), py = static_cast<double>(y), pz = static_cast<double>(z);
    return 90 + 50 * std::sin(.11 * px + .3 * t) * std::cos(.07 * py) * std::sin(.09 * pz + .5) + noise;
  }
  return smooth < 8 ? 3 : 3 + smooth + noise;
}

template<class T> std::vector<std::byte> values_of(const Asked& a, const Box& box, uint32_t t) {
  std::vector<T> values;
  for (uint64_t z = box[0][2]; z < box[1][2]; ++z)
    for (uint64_t y = box[0][1]; y < box[1][1]; ++y)
      for (uint64_t x = box[0][0]; x < box[1][0]; ++x) {
        const bool missing =
            a.missing && a.missing(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z), t);
        values.push_back(missing ? std::numeric_limits<T>::quiet_NaN()
                                 : static_cast<T>(rough(a, x, y, z, t)));
      }
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

inline bccsplat_status add_box(bccsplat_writer* writer, const Asked& a, const Box& box, uint32_t t) {
  const std::vector<std::byte> values = a.type == BCCSPLAT_TYPE_U8    ? values_of<uint8_t>(a, box, t)
                                        : a.type == BCCSPLAT_TYPE_U16 ? values_of<uint16_t>(a, box, t)
                                                                      : values_of<float>(a, box, t);
  auto b = sized<bccsplat_box>();
  b.type = a.type, b.data = values.data();
  for (size_t i = 0; i < 3; ++i)
    b.begin[i] = static_cast<int64_t>(box[0][i]), b.dims[i] = static_cast<int64_t>(box[1][i] - box[0][i]);
  return bccsplat_writer_add_frame(writer, 0, .5 * t, &b, 1);
}

// What a writer took of each frame, and what it told.
struct Written {
  Box box{};
  bccsplat_writer_report report = sized<bccsplat_writer_report>();
};

// Writes all, or a part.
inline Written write(const Device& device, const std::string& path, Asked a,
                     const bccsplat_series_part* part = nullptr) {
  bccsplat_writer_options o = a.writer_options();
  o.part = part;
  const Writer w = make_writer(device, path, o);
  if (!w) return {};
  uint64_t begin = 0, end = 0;
  EXPECT_OK(bccsplat_writer_get_part_frames(w.get(), &begin, &end));
  Written written;
  Box& box = written.box;
  EXPECT_OK(bccsplat_writer_get_part_box(w.get(), box[0].data(), box[1].data()));
  for (auto t = static_cast<uint32_t>(begin); t < end; ++t) EXPECT_OK(add_box(w.get(), a, box, t));
  EXPECT_OK(bccsplat_writer_finish(w.get(), &written.report));
  return written;
}

inline std::vector<char> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Writes blocks of a series between these borders, which are along x, y, z and t.
class Blocks {
 public:
  Blocks(const Device& device, const Folder& folder, Asked asked)
      : device_(device), folder_(folder), asked_(std::move(asked)) {
    for (uint32_t t = 0; t < asked_.dims[3]; ++t) times_.push_back(.5 * t);
  }
  Written write_block(const Box& box, uint64_t first, uint64_t end) {
    auto part = sized<bccsplat_series_part>();
    part.first = first, part.end = end, part.times = times_.data();
    std::copy(box[0].begin(), box[0].end(), part.box_begin);
    std::copy(box[1].begin(), box[1].end(), part.box_end);
    names_.push_back(folder_.file("block" + std::to_string(names_.size()) + ".bcc4"));
    return write(device_, names_.back(), asked_, &part);
  }
  void write_all(const std::array<std::vector<uint64_t>, 4>& at) {
    for (size_t t = 0; t + 1 < at[3].size(); ++t)
      for (size_t z = 0; z + 1 < at[2].size(); ++z)
        for (size_t y = 0; y + 1 < at[1].size(); ++y)
          for (size_t x = 0; x + 1 < at[0].size(); ++x)
            write_block({{{at[0][x], at[1][y], at[2][z]}, {at[0][x + 1], at[1][y + 1], at[2][z + 1]}}},
                        at[3][t], at[3][t + 1]);
  }
  bccsplat_status join(const std::string& path) const { return join(path, names_); }
  bccsplat_status join(const std::string& path, const std::vector<std::string>& names,
                       bccsplat_writer_report* report = nullptr) const {
    std::vector<const char*> paths;
    for (auto name = names.rbegin(); name != names.rend(); ++name) paths.push_back(name->c_str());
    auto o = sized<bccsplat_join_options>();
    o.overwrite = 1;
    return bccsplat_join_parts(device_.get(), paths.size(), paths.data(), path.c_str(), &o, report);
  }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  const Device& device_;
  const Folder& folder_;
  Asked asked_;
  std::vector<double> times_;
  std::vector<std::string> names_;
};

// Returns what one writer told, whose file is expected to be that of blocks between borders.
inline Written expect_same(const Device& device, const Folder& folder, const Asked& asked,
                           const std::array<std::vector<uint64_t>, 4>& borders) {
  const Written whole = write(device, folder.file("whole.bcc4"), asked);
  Blocks blocks(device, folder, asked);
  blocks.write_all(borders);
  auto report = sized<bccsplat_writer_report>();
  EXPECT_OK(blocks.join(folder.file("joined.bcc4"), blocks.names(), &report));
  const std::vector<char> one = bytes_of(folder.file("whole.bcc4"));
  EXPECT_GT(one.size(), 10000u);
  EXPECT_TRUE(bytes_of(folder.file("joined.bcc4")) == one) << blocks.names().size() << " blocks";
  EXPECT_EQ(report.frames_measured, whole.report.frames_measured);
  EXPECT_EQ(report.corrected, whole.report.corrected);
  EXPECT_EQ(report.bytes_corrections, whole.report.bytes_corrections);
  return whole;
}

// What one writer is asked for in a case of a test.
struct Case {
  const char* name;
  std::function<void(Asked&)> change;
};

} // namespace host::block_series
